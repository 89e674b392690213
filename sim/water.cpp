#include "sim/water.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::sim {
namespace {

constexpr double kDensity_kg_m3 = 1000.0;
constexpr double kGravity_m_s2 = 9.81;
constexpr double kDragCoefficient = 1.0;  // a short cylinder across the flow

double DeepestOfPipes(const network::Network& network, const network::Manhole& manhole) {
  double depth_m = 0.0;
  for (const std::size_t i : network.PipesAt(manhole.name))
    depth_m = std::max(depth_m, network.pipes[i].water_m);
  return depth_m;
}

}  // namespace

Water::Water(const Sewer& sewer) : sewer_(sewer) {
  for (const Part& part : sewer.parts) {
    depth_m_.push_back(part.kind == Part::Kind::kPipe
                           ? sewer.network.pipes[part.index].water_m
                           : DeepestOfPipes(sewer.network, sewer.network.manholes[part.index]));
  }
}

double Water::AboveAxis(const VoidPrimitive& primitive) const {
  const Part& part = sewer_.parts[primitive.part];
  const double depth_m = depth_m_[primitive.part];
  if (part.kind == Part::Kind::kManhole) {
    return sewer_.network.manholes[part.index].p_WM.z() + depth_m -
           primitive.X_WS.translation().z();
  }
  // A groove's bottom is deeper than the invert, from which the water counts.
  const double chainage_m = primitive.start_chainage_m + 0.5 * primitive.length_m;
  return depth_m - 0.5 * sewer_.network.pipes[part.index].DiameterAt(chainage_m);
}

double Water::Over(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W) const {
  const Part& part = sewer_.parts[primitive.part];
  const double depth_m = depth_m_[primitive.part];
  if (depth_m <= 0.0 || primitive.feature == Feature::kInlet) return 0.0;
  if (part.kind == Part::Kind::kManhole) {
    return std::max(0.0, sewer_.network.manholes[part.index].p_WM.z() + depth_m - p_W.z());
  }
  return std::max(0.0, AboveAxis(primitive) - ToSweep(primitive, p_W).up_m);
}

double WadingDrag_N(const WadingWheel& wheel, double depth_m, double speed_m_s) {
  const double area_m2 = wheel.width_m * std::clamp(depth_m, 0.0, 2.0 * wheel.radius_m);
  return 0.5 * kDensity_kg_m3 * kDragCoefficient * area_m2 * speed_m_s * speed_m_s;
}

double WadingLift_N(const WadingWheel& wheel, double depth_m) {
  const double r = wheel.radius_m;
  const double up = std::clamp(depth_m, 0.0, 2.0 * r) - r;  // of the surface above the axle
  const double area_m2 = r * r * std::acos(-up / r) + up * std::sqrt(r * r - up * up);
  return kDensity_kg_m3 * kGravity_m_s2 * area_m2 * wheel.width_m;
}

}  // namespace kantaro::sim
