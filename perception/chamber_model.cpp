#include "perception/chamber_model.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurnRadius = 0.66;  ///< of the shaft's radius: usual for a channel that turns

/// Where a level ray enters and leaves an upright cylinder; false if it passes by.
bool Meet(const Vector2d& from, const Vector2d& ray, const Vector2d& middle, double radius_m,
          double& enters, double& leaves) {
  const Vector2d to = from - middle;
  const double a = ray.squaredNorm(), b = ray.dot(to), c = to.squaredNorm() - radius_m * radius_m;
  const double root2 = b * b - a * c;
  if (root2 < 0.0) return false;
  const double root = std::sqrt(root2);
  enters = (-b - root) / a;
  leaves = (-b + root) / a;
  return true;
}

Vector2d Level(const Vector3d& p) { return {p.x(), p.z()}; }
Vector3d Upright(const Vector2d& level) { return Vector3d(level.x(), 0.0, level.y()).normalized(); }

}  // namespace

ChamberModel::ChamberModel(double pipe_radius_m, double shaft_diameter_m)
    : pipe_m_(pipe_radius_m),
      shaft_m_(shaft_diameter_m / 2.0),
      turn_m_(std::max(kTurnRadius * shaft_m_, pipe_radius_m)) {}

ChamberModel::Hit ChamberModel::Trace(const Vector3d& from_P, const Vector3d& wall_P,
                                      double mouth_m, Channel channel) const {
  const Vector3d ray_P = wall_P - from_P;
  if (wall_P.z() <= mouth_m)
    return {Surface::kPipe, 1.0, Vector3d(-wall_P.x(), -wall_P.y(), 0.0) / pipe_m_};
  if (channel == Channel::kStraight || channel == Channel::kEnds)
    return Straight(from_P, ray_P, mouth_m, channel == Channel::kEnds);
  return Turning(from_P, ray_P, mouth_m, channel == Channel::kLeft ? -1.0 : 1.0);
}

ChamberModel::Hit ChamberModel::FarPipe(const Vector3d& wall_P) const {
  return {Surface::kFarPipe, 1.0, Vector3d(-wall_P.x(), -wall_P.y(), 0.0) / pipe_m_};
}

/// Over the benching, or under what of the channel the shaft leaves roofed.
ChamberModel::Hit ChamberModel::InShaft(const Vector3d& from_P, const Vector3d& ray_P,
                                        double mouth_m, double over_crown) const {
  const Vector2d from = Level(from_P), ray = Level(ray_P), middle(0.0, mouth_m + shaft_m_);
  double enters = 0.0, leaves = 0.0;
  if (!Meet(from, ray, middle, shaft_m_, enters, leaves) || over_crown < enters ||
      over_crown > leaves)
    return {Surface::kShaft, over_crown, Vector3d::UnitY()};
  return {Surface::kShaft, leaves, Upright(middle - from - leaves * ray)};
}

ChamberModel::Hit ChamberModel::Straight(const Vector3d& from_P, const Vector3d& ray_P,
                                         double mouth_m, bool ends) const {
  const double end_m = mouth_m + 2.0 * shaft_m_, at_end = end_m / ray_P.z();
  const Vector3d wall_P = from_P + ray_P;
  if (end_m <= 0.0 || (!ends && wall_P.z() > end_m)) return FarPipe(wall_P);
  const Hit end{Surface::kEndWall, at_end, -Vector3d::UnitZ()};
  if (wall_P.y() >= 0.0) {
    if (ends && wall_P.z() > end_m) return end;
    return {Surface::kChannel, 1.0, Vector3d(-wall_P.x(), -wall_P.y(), 0.0) / pipe_m_};
  }
  const double side = ray_P.x() < 0.0 ? -1.0 : 1.0;
  const double at_side = ray_P.x() == 0.0 ? HUGE_VAL : (side * pipe_m_ - from_P.x()) / ray_P.x();
  const double over_crown = ray_P.y() < 0.0 ? (-pipe_m_ - from_P.y()) / ray_P.y() : HUGE_VAL;
  if (over_crown < std::min(at_side, at_end)) return InShaft(from_P, ray_P, mouth_m, over_crown);
  if (at_side < at_end) return {Surface::kChannel, at_side, -side * Vector3d::UnitX()};
  return end;
}

ChamberModel::Hit ChamberModel::Turning(const Vector3d& from_P, const Vector3d& ray_P,
                                        double mouth_m, double side) const {
  // Mirrored so that the channel turns to the right.
  const Vector2d from(side * from_P.x(), from_P.z()), ray(side * ray_P.x(), ray_P.z());
  const double bend_m = mouth_m + shaft_m_ - turn_m_;
  const Vector2d middle(turn_m_, bend_m);
  double along = HUGE_VAL;
  Vector2d normal = Vector2d::Zero();
  const auto offer = [&](double there, const Vector2d& towards_void) {
    if (there <= 0.0 || there >= along) return;
    along = there;
    normal = towards_void;
  };
  const double to_side = ray.x() < 0.0 ? -1.0 : 1.0;
  const double at_side = ray.x() == 0.0 ? HUGE_VAL : (to_side * pipe_m_ - from.x()) / ray.x();
  if (from.y() + at_side * ray.y() < bend_m) {
    offer(at_side, {-to_side, 0.0});
  } else {
    double enters = 0.0, leaves = 0.0;
    if (turn_m_ > pipe_m_ && Meet(from, ray, middle, turn_m_ - pipe_m_, enters, leaves)) {
      const Vector2d there = from + enters * ray;
      if (there.y() > bend_m && there.x() < turn_m_) offer(enters, there - middle);
    }
    if (Meet(from, ray, middle, turn_m_ + pipe_m_, enters, leaves)) {
      const Vector2d there = from + leaves * ray;
      if (there.x() < turn_m_) offer(leaves, middle - there);
    }
    offer((mouth_m + shaft_m_ + pipe_m_ - from.y()) / ray.y(), {0.0, -1.0});
  }
  const Vector3d wall_P = from_P + ray_P;
  if (along == HUGE_VAL) return FarPipe(wall_P);
  if (wall_P.y() >= 0.0 && wall_P.z() < bend_m)  // the channel's round bed
    return {Surface::kChannel, 1.0, Vector3d(-wall_P.x(), -wall_P.y(), 0.0) / pipe_m_};
  const double over_crown = ray_P.y() < 0.0 ? (-pipe_m_ - from_P.y()) / ray_P.y() : HUGE_VAL;
  if (over_crown < along) return InShaft(from_P, ray_P, mouth_m, over_crown);
  return {Surface::kChannel, along, Upright({side * normal.x(), normal.y()})};
}

}  // namespace kantaro::perception
