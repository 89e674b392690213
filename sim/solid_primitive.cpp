#include "sim/solid_primitive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

/// A signed distance in two dimensions, and the way out.
struct Outline {
  double distance_m{};
  Vector2d normal{Vector2d::UnitX()};
};

Vector2d UnitOr(const Vector2d& v, const Vector2d& otherwise) {
  const double length = v.norm();
  return length > 0.0 ? Vector2d(v / length) : otherwise;
}

/// |x| <= half.
Outline Slab(double x, double half_m) {
  return {std::abs(x) - half_m, {x < 0.0 ? -1.0 : 1.0, 0.0}};
}

/// Two bodies that bound each other at right angles: the distance to what they share.
struct Share {
  double distance_m{};
  double a{}, b{};  ///< of the two normals
};
Share Both(double a_m, double b_m) {
  if (a_m > 0.0 && b_m > 0.0) {
    const double distance = std::sqrt(a_m * a_m + b_m * b_m);
    return {distance, a_m / distance, b_m / distance};
  }
  return a_m > b_m ? Share{a_m, 1.0, 0.0} : Share{b_m, 0.0, 1.0};
}

/// A convex polygon, counter-clockwise.
template <typename Corner>
Outline Polygon(std::size_t corners, const Corner& corner, const Vector2d& p) {
  Outline nearest{-std::numeric_limits<double>::infinity(), Vector2d::UnitY()};
  Outline outside{std::numeric_limits<double>::infinity(), Vector2d::UnitY()};
  for (std::size_t i = 0; i < corners; ++i) {
    const Vector2d a = corner(i);
    const Vector2d edge = corner((i + 1) % corners) - a;
    const Vector2d normal = UnitOr({edge.y(), -edge.x()}, Vector2d::UnitY());
    const double height = normal.dot(p - a);
    if (height > nearest.distance_m) nearest = {height, normal};
    if (height <= 0.0) continue;
    const double t = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    const Vector2d offset = p - a - t * edge;
    const double distance = offset.norm();
    if (distance < outside.distance_m) outside = {distance, UnitOr(offset, normal)};
  }
  return nearest.distance_m > 0.0 ? outside : nearest;
}

Wall SurfaceOf(const Bed& bed, const Vector3d& p_W) {
  const SweepPoint s = ToSweep(bed.axis, p_W);
  // Round a bend, what lies on its inside is shorter.
  const double scale = std::max(0.1, 1.0 - bed.axis.curvature * s.left_m);
  const auto corner = [&](std::size_t i) {
    return Vector2d((bed.outline[i].x() - s.along_m) * scale, bed.outline[i].y());
  };
  const Outline side = Polygon(bed.corners, corner, {0.0, s.up_m});
  const Outline across = Slab(s.left_m, bed.half_width_m);
  const Share share = Both(side.distance_m, across.distance_m);
  const Eigen::Matrix3d R_WA = AxisPose(bed.axis, s.along_m).linear();
  return {share.distance_m, R_WA * Vector3d(share.a * side.normal.x(), share.b * across.normal.x(),
                                            share.a * side.normal.y())};
}

Wall SurfaceOf(const Ball& ball, const Vector3d& p_W) {
  const Vector3d offset = p_W - ball.p_WB;
  const double distance = offset.norm();
  const double height = ball.up_W.dot(offset);
  const Wall round{distance - ball.radius_m,
                   distance > 0.0 ? Vector3d(offset / distance) : ball.up_W};
  // A whole ball, or its round side is nearer.
  if (ball.foot_m <= -ball.radius_m || ball.radius_m * height >= ball.foot_m * distance) {
    const double under = ball.foot_m - height;
    return under > round.distance_m ? Wall{under, -ball.up_W} : round;
  }
  const double rim = std::sqrt(ball.radius_m * ball.radius_m - ball.foot_m * ball.foot_m);
  const Vector3d across = offset - height * ball.up_W;
  const double off = across.norm();
  if (off <= rim || off == 0.0) return {ball.foot_m - height, -ball.up_W};
  const Vector3d from_rim = offset - ball.foot_m * ball.up_W - across * (rim / off);
  const double length = from_rim.norm();
  return {length, length > 0.0 ? Vector3d(from_rim / length) : -ball.up_W};
}

/// Across the axis: (left, up) against a ring between two radii, or a sector of it.
Outline Sector(const Ridge& ridge, double left_m, double up_m) {
  const Vector2d p(left_m, up_m);
  const double off = p.norm();
  const Vector2d out = UnitOr(p, Vector2d::UnitY());
  const Outline ring = ridge.inner_radius_m - off > off - ridge.outer_radius_m
                           ? Outline{ridge.inner_radius_m - off, -out}
                           : Outline{off - ridge.outer_radius_m, out};
  if (ridge.half_arc_rad >= kPi) return ring;
  const double angle = std::remainder(std::atan2(-left_m, up_m) - ridge.middle_rad, 2.0 * kPi);
  const double sign = angle < 0.0 ? -1.0 : 1.0;
  const double edge_angle = ridge.middle_rad + sign * ridge.half_arc_rad;
  const Vector2d edge(-std::sin(edge_angle), std::cos(edge_angle));
  const double along = std::clamp(p.dot(edge), ridge.inner_radius_m, ridge.outer_radius_m);
  const Vector2d offset = p - along * edge;
  const double to_edge = offset.norm();
  if (std::abs(angle) > ridge.half_arc_rad) return {to_edge, UnitOr(offset, edge)};
  if (ring.distance_m > 0.0 || -ring.distance_m < to_edge) return ring;
  return {-to_edge, UnitOr(-offset, edge)};
}

Wall SurfaceOf(const Ridge& ridge, const Vector3d& p_W) {
  const SweepPoint s = ToSweep(ridge.axis, p_W);
  const double scale = std::max(0.1, 1.0 - ridge.axis.curvature * s.left_m);
  const double half = 0.5 * ridge.axis.length_m;
  const Outline along = Slab((s.along_m - half) * scale, half * scale);
  const Outline across = Sector(ridge, s.left_m, s.up_m);
  const Share share = Both(across.distance_m, along.distance_m);
  const Eigen::Matrix3d R_WA = AxisPose(ridge.axis, s.along_m).linear();
  return {share.distance_m, R_WA * Vector3d(share.b * along.normal.x(), share.a * across.normal.x(),
                                            share.a * across.normal.y())};
}

Wall SurfaceOf(const Block& block, const Vector3d& p_W) {
  const Vector3d p_B = block.X_WB.linear().transpose() * (p_W - block.X_WB.translation());
  const Vector3d beyond = p_B.cwiseAbs() - block.half_m;
  Vector3d normal_B = Vector3d::Zero();
  double distance = 0.0;
  if (beyond.maxCoeff() > 0.0) {
    normal_B = beyond.cwiseMax(0.0);
    distance = normal_B.norm();
    normal_B /= distance;
  } else {
    Eigen::Index face = 0;
    distance = beyond.maxCoeff(&face);
    normal_B[face] = 1.0;
  }
  for (int i = 0; i < 3; ++i) normal_B[i] = std::copysign(normal_B[i], p_B[i]);
  return {distance, block.X_WB.linear() * normal_B};
}

Wall SurfaceOf(const Stub& stub, const Vector3d& p_W) {
  const Vector3d p_S = stub.X_WS.linear().transpose() * (p_W - stub.X_WS.translation());
  const Vector2d across(p_S.y(), p_S.z());
  const double off = across.norm();
  const Vector2d out = UnitOr(across, Vector2d::UnitY());
  const Outline along =
      Slab(p_S.x() - 0.5 * (stub.start_m + stub.end_m), 0.5 * (stub.end_m - stub.start_m));
  const Outline wall = Slab(off - 0.5 * (stub.inner_radius_m + stub.outer_radius_m),
                            0.5 * (stub.outer_radius_m - stub.inner_radius_m));
  const Share share = Both(along.distance_m, wall.distance_m);
  const Vector2d away = share.b * wall.normal.x() * out;
  return {share.distance_m,
          stub.X_WS.linear() * Vector3d(share.a * along.normal.x(), away.x(), away.y())};
}

/// Around a frame's box.
Eigen::AlignedBox3d Around(const Eigen::Isometry3d& X, const Vector3d& low, const Vector3d& high) {
  Eigen::AlignedBox3d box;
  for (const double x : {low.x(), high.x()}) {
    for (const double y : {low.y(), high.y()}) {
      for (const double z : {low.z(), high.z()}) box.extend(X * Vector3d(x, y, z));
    }
  }
  return box;
}

Eigen::AlignedBox3d Around(const SweptAxis& axis, double start_m, double end_m, double radius_m) {
  VoidPrimitive tube;
  static_cast<SweptAxis&>(tube) = axis;
  tube.X_WS = AxisPose(axis, start_m);
  tube.length_m = end_m - start_m;
  tube.radius_m = radius_m;
  return BoundingBox(tube);
}

Eigen::AlignedBox3d BoxOf(const Bed& bed) {
  double low = 0.0;
  double high = bed.axis.length_m;
  double radius = 0.0;
  for (std::size_t i = 0; i < bed.corners; ++i) {
    low = std::min(low, bed.outline[i].x());
    high = std::max(high, bed.outline[i].x());
    radius = std::max(radius, std::hypot(bed.outline[i].y(), bed.half_width_m));
  }
  return Around(bed.axis, low, high, radius);
}
Eigen::AlignedBox3d BoxOf(const Ball& ball) {
  return {ball.p_WB.array() - ball.radius_m, ball.p_WB.array() + ball.radius_m};
}
Eigen::AlignedBox3d BoxOf(const Ridge& ridge) {
  return Around(ridge.axis, 0.0, ridge.axis.length_m, ridge.outer_radius_m);
}
Eigen::AlignedBox3d BoxOf(const Block& block) {
  return Around(block.X_WB, -block.half_m, block.half_m);
}
Eigen::AlignedBox3d BoxOf(const Stub& stub) {
  const double r = stub.outer_radius_m;
  return Around(stub.X_WS, {stub.start_m, -r, -r}, {stub.end_m, r, r});
}

void Move(Bed& bed, const Vector3d& by_W) { bed.axis.X_WS.pretranslate(by_W); }
void Move(Ball& ball, const Vector3d& by_W) { ball.p_WB += by_W; }
void Move(Ridge& ridge, const Vector3d& by_W) { ridge.axis.X_WS.pretranslate(by_W); }
void Move(Block& block, const Vector3d& by_W) { block.X_WB.pretranslate(by_W); }
void Move(Stub& stub, const Vector3d& by_W) { stub.X_WS.pretranslate(by_W); }

}  // namespace

Wall SurfaceOf(const SolidPrimitive& solid, const Vector3d& p_W) {
  return std::visit([&](const auto& shape) { return SurfaceOf(shape, p_W); }, solid.shape);
}

SolidPrimitive Moved(SolidPrimitive solid, const Vector3d& by_W) {
  std::visit([&](auto& shape) { Move(shape, by_W); }, solid.shape);
  return solid;
}

Eigen::AlignedBox3d BoundingBox(const SolidPrimitive& solid) {
  return std::visit([](const auto& shape) { return BoxOf(shape); }, solid.shape);
}

}  // namespace kantaro::sim
