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
double PastPlane(const VoidPrimitive& primitive, const SweepPoint& point, double along_m) {
  const double ahead = point.along_m - along_m;
  if (primitive.curvature == 0.0) return ahead;
  const double reach = 1.0 / std::abs(primitive.curvature) -
                       (primitive.curvature > 0.0 ? point.left_m : -point.left_m);
  return reach * std::sin(std::clamp(ahead * std::abs(primitive.curvature), -kHalfTurn, kHalfTurn));
}

}  // namespace

SweepPoint ToSweep(const VoidPrimitive& primitive, const Vector3d& p_W) {
  // The inverse of a rigid transform, written out: this is the innermost function of a physics
  // step.
  const Vector3d q = primitive.X_WS.linear().transpose() * (p_W - primitive.X_WS.translation());
  if (primitive.curvature == 0.0) return {q.x(), q.y(), q.z()};
  const double sign = primitive.curvature > 0.0 ? 1.0 : -1.0;
  const double radius = 1.0 / std::abs(primitive.curvature);
  const double inward = radius - sign * q.y();
  double angle = std::atan2(q.x(), inward);
  // The seam of the angle lies opposite the middle of the arc.
  const double middle = 0.5 * primitive.length_m / radius;
  if (angle < middle - std::numbers::pi) angle += 2.0 * std::numbers::pi;
  return {radius * angle, sign * (radius - std::hypot(q.x(), inward)), q.z()};
}

Eigen::Isometry3d AxisPose(const VoidPrimitive& primitive, double along_m) {
  Eigen::Isometry3d X_SA = Eigen::Isometry3d::Identity();
  if (primitive.curvature == 0.0) {
    X_SA.translation().x() = along_m;
  } else {
    const double angle = along_m * primitive.curvature;
    X_SA.linear() = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
    X_SA.translation() =
        Vector3d(std::sin(angle), 1.0 - std::cos(angle), 0.0) / primitive.curvature;
  }
  return primitive.X_WS * X_SA;
}

Vector3d FromSweep(const VoidPrimitive& primitive, const SweepPoint& point) {
  return AxisPose(primitive, point.along_m) * Vector3d(0.0, point.left_m, point.up_m);
}

Walls WallsAround(const VoidPrimitive& primitive, const Vector3d& p_W) {
  const SweepPoint point = ToSweep(primitive, p_W);
  const auto R_WS = primitive.X_WS.linear();
  Vector3d left_S = Vector3d::UnitY();
  if (primitive.curvature != 0.0) {
    const double angle = point.along_m * primitive.curvature;
    left_S = {-std::sin(angle), std::cos(angle), 0.0};
  }

  Walls walls;
  const auto add = [&](double distance, const Vector3d& normal_S) {
    walls.wall[static_cast<std::size_t>(walls.count++)] = {distance, R_WS * normal_S};
  };
  if (primitive.profile == Profile::kU && point.up_m > 0.0) {
    add(primitive.radius_m - std::abs(point.left_m),
        point.left_m > 0.0 ? Vector3d(-left_S) : left_S);
  } else {
    const double off_axis = std::hypot(point.left_m, point.up_m);
    const Vector3d inward_S =
        off_axis > 0.0
            ? Vector3d(-(point.left_m * left_S + point.up_m * Vector3d::UnitZ()) / off_axis)
            : Vector3d::UnitZ();
    add(primitive.radius_m - off_axis, inward_S);
  }
  add(PastPlane(primitive, point, 0.0), Vector3d::UnitX());
  const double turn = primitive.length_m * primitive.curvature;
  add(-PastPlane(primitive, point, primitive.length_m),
      Vector3d(-std::cos(turn), -std::sin(turn), 0.0));
  if (primitive.profile == Profile::kU)
    add(primitive.wall_height_m - point.up_m, -Vector3d::UnitZ());
  return walls;
}

double InsideDistance(const VoidPrimitive& primitive, const Vector3d& p_W) {
  const SweepPoint point = ToSweep(primitive, p_W);
  const double side = primitive.profile == Profile::kU && point.up_m > 0.0
                          ? std::min(primitive.radius_m - std::abs(point.left_m),
                                     primitive.wall_height_m - point.up_m)
                          : primitive.radius_m - std::hypot(point.left_m, point.up_m);
  return std::min(
      {side, PastPlane(primitive, point, 0.0), -PastPlane(primitive, point, primitive.length_m)});
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
