#include "sim/void_primitive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kHalfTurn = std::numbers::pi / 2.0;

/// Distance to the plane across the axis at `along`, positive on the side of larger `along`. On an
/// arc the plane turns, and only its near half counts.
double PastPlane(const SweptAxis& axis, const SweepPoint& point, double along_m) {
  const double ahead = point.along_m - along_m;
  if (axis.curvature == 0.0) return ahead;
  const double reach =
      1.0 / std::abs(axis.curvature) - (axis.curvature > 0.0 ? point.left_m : -point.left_m);
  return reach * std::sin(std::clamp(ahead * std::abs(axis.curvature), -kHalfTurn, kHalfTurn));
}

// Lengths here are of metres: std::hypot's care for overflow would be a fifth of a physics step.
double Hypotenuse(double a, double b) { return std::sqrt(a * a + b * b); }

enum WallIndex { kSide, kStart, kEnd, kTop };

/// Distances in the order of WallIndex.
struct WallDistances {
  std::array<double, 4> distance_m;
  int count;
};

bool HasVerticalSide(const VoidPrimitive& primitive, const SweepPoint& point) {
  return primitive.profile == Profile::kU && point.up_m > 0.0;
}

WallDistances DistancesAround(const VoidPrimitive& primitive, const SweepPoint& point) {
  const double off = HasVerticalSide(primitive, point) ? std::abs(point.left_m)
                                                       : Hypotenuse(point.left_m, point.up_m);
  return {{primitive.radius_m - off, PastPlane(primitive, point, 0.0),
           -PastPlane(primitive, point, primitive.length_m), primitive.wall_height_m - point.up_m},
          primitive.profile == Profile::kU ? 4 : 3};
}

Vector3d NormalOf(const VoidPrimitive& primitive, const SweepPoint& point, int wall) {
  const double turn = primitive.curvature * (wall == kSide  ? point.along_m
                                             : wall == kEnd ? primitive.length_m
                                                            : 0);
  const Vector3d forward_S = primitive.curvature == 0.0
                                 ? Vector3d::UnitX()
                                 : Vector3d(std::cos(turn), std::sin(turn), 0.0);
  const Vector3d left_S(-forward_S.y(), forward_S.x(), 0.0);
  const auto R_WS = primitive.X_WS.linear();
  switch (wall) {
    case kStart:
      return R_WS * forward_S;
    case kEnd:
      return R_WS * -forward_S;
    case kTop:
      return -R_WS.col(2);
    default:
      break;
  }
  if (HasVerticalSide(primitive, point)) return R_WS * (point.left_m > 0.0 ? -left_S : left_S);
  const double off = Hypotenuse(point.left_m, point.up_m);
  if (off == 0.0) return R_WS.col(2);
  return R_WS * (-(point.left_m * left_S + point.up_m * Vector3d::UnitZ()) / off);
}

}  // namespace

SweepPoint ToSweep(const SweptAxis& axis, const Vector3d& p_W) {
  // The inverse of a rigid transform, written out: this is the innermost function of a physics
  // step.
  const Vector3d q = axis.X_WS.linear().transpose() * (p_W - axis.X_WS.translation());
  if (axis.curvature == 0.0) return {q.x(), q.y(), q.z()};
  const double sign = axis.curvature > 0.0 ? 1.0 : -1.0;
  const double radius = 1.0 / std::abs(axis.curvature);
  const double inward = radius - sign * q.y();
  double angle = std::atan2(q.x(), inward);
  // The seam of the angle lies opposite the middle of the arc.
  const double middle = 0.5 * axis.length_m / radius;
  if (angle < middle - std::numbers::pi) angle += 2.0 * std::numbers::pi;
  return {radius * angle, sign * (radius - Hypotenuse(q.x(), inward)), q.z()};
}

Eigen::Isometry3d AxisPose(const SweptAxis& axis, double along_m) {
  Eigen::Isometry3d X_SA = Eigen::Isometry3d::Identity();
  if (axis.curvature == 0.0) {
    X_SA.translation().x() = along_m;
  } else {
    const double angle = along_m * axis.curvature;
    X_SA.linear() = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
    X_SA.translation() = Vector3d(std::sin(angle), 1.0 - std::cos(angle), 0.0) / axis.curvature;
  }
  return axis.X_WS * X_SA;
}

Vector3d FromSweep(const SweptAxis& axis, const SweepPoint& point) {
  return AxisPose(axis, point.along_m) * Vector3d(0.0, point.left_m, point.up_m);
}

Walls WallsAround(const VoidPrimitive& primitive, const Vector3d& p_W, double cap_m) {
  const SweepPoint point = ToSweep(primitive, p_W);
  const WallDistances around = DistancesAround(primitive, point);
  const auto first = around.distance_m.begin();
  const auto least = static_cast<int>(std::min_element(first, first + around.count) - first);
  Walls walls;
  for (int i = 0; i < around.count; ++i) {
    const double distance = around.distance_m[static_cast<std::size_t>(i)];
    if (distance >= cap_m && i != least) continue;
    if (i == least) walls.least = walls.count;
    const auto slot = static_cast<std::size_t>(walls.count++);
    walls.wall[slot] = {distance, NormalOf(primitive, point, i)};
    walls.index[slot] = i;
  }
  return walls;
}

Wall WallAt(const VoidPrimitive& primitive, int index, const Vector3d& p_W) {
  const SweepPoint point = ToSweep(primitive, p_W);
  return {DistancesAround(primitive, point).distance_m[static_cast<std::size_t>(index)],
          NormalOf(primitive, point, index)};
}

double InsideDistance(const VoidPrimitive& primitive, const Vector3d& p_W) {
  const WallDistances around = DistancesAround(primitive, ToSweep(primitive, p_W));
  const auto first = around.distance_m.begin();
  return *std::min_element(first, first + around.count);
}

Eigen::AlignedBox3d BoundingBox(const VoidPrimitive& primitive) {
  const double top =
      primitive.profile == Profile::kU ? primitive.wall_height_m : primitive.radius_m;
  // Between samples an arc bulges out of its chord by at most its sagitta.
  const double turn = std::abs(primitive.length_m * primitive.curvature);
  const int steps = 1 + static_cast<int>(std::ceil(turn / 0.2));
  const double step = primitive.length_m / steps;
  const double sagitta = turn > 0.0 ? (1.0 - std::cos(0.5 * step * std::abs(primitive.curvature))) /
                                          std::abs(primitive.curvature)
                                    : 0.0;
  Eigen::AlignedBox3d box;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Isometry3d X_WA = AxisPose(primitive, i * step);
    for (const double left : {-primitive.radius_m, primitive.radius_m}) {
      for (const double up : {-primitive.radius_m, top}) box.extend(X_WA * Vector3d(0.0, left, up));
    }
  }
  box.min().array() -= sagitta + 1e-9;
  box.max().array() += sagitta + 1e-9;
  return box;
}

}  // namespace kantaro::sim
