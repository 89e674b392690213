#include "sim/ground.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::sim {

using network::WallCondition;

SewerGround::SewerGround(const Sewer& sewer, const VoidField& field, const GripTable& grips)
    : field_(field), sewer_(sewer), grips_(grips), water_(sewer) {
  for (const Part& part : sewer.parts) surfaces_.push_back(PartSurface(sewer.network, part));
}

SewerGround::Surface SewerGround::PartSurface(const network::Network& network, const Part& part) {
  if (part.kind == Part::Kind::kPipe) {
    const network::Pipe& pipe = network.pipes[part.index];
    return {GroundOf(pipe.material), pipe.condition};
  }
  Surface surface{Ground::kConcrete, WallCondition::kDry};
  for (const std::size_t i : network.PipesAt(network.manholes[part.index].name))
    surface.condition = std::max(surface.condition, network.pipes[i].condition);
  return surface;
}

Ground SewerGround::GroundIn(const VoidPrimitive& primitive, const Nearby& nearby,
                             const Eigen::Vector3d& p_W) const {
  constexpr double kTouching_m = 0.003;
  for (const SolidPrimitive* solid : nearby.solids()) {
    if (std::abs(SurfaceOf(*solid, p_W).distance_m) > kTouching_m) continue;
    if (solid->feature != Feature::kObstacle) return Ground::kPvc;  // an inlet's pipe
    const Part& part = sewer_.parts[solid->part];
    const network::ObstacleKind kind = sewer_.network.pipes[part.index].obstacles[solid->item].kind;
    return kind == network::ObstacleKind::kSediment ? Ground::kSediment : Ground::kConcrete;
  }
  return surfaces_[primitive.part].ground;
}

Footing SewerGround::operator()(const Eigen::Vector3d& p_W) const {
  constexpr double kReach_m = 0.02;
  const VoidPrimitive* deepest = nullptr;
  double deepest_m = 0.0;
  const Nearby nearby = field_.Around(p_W, kReach_m);
  for (const VoidPrimitive* primitive : nearby.voids()) {
    const double inside_m = InsideDistance(*primitive, p_W);
    if (deepest != nullptr && inside_m <= deepest_m) continue;
    deepest = primitive;
    deepest_m = inside_m;
  }
  if (deepest == nullptr) return {grips_.At(Ground::kConcrete, WallCondition::kDry), 0.0};
  const Surface& surface = surfaces_[deepest->part];
  const double water_m = water_.Over(*deepest, p_W);
  const WallCondition condition =
      water_m > 0.0 ? std::max(surface.condition, WallCondition::kWet) : surface.condition;
  return {grips_.At(GroundIn(*deepest, nearby, p_W), condition), water_m};
}

}  // namespace kantaro::sim
