#include "perception/branch_mouth.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::perception {
namespace {

using Eigen::Vector3d;

constexpr double kNearest_m = 0.08;
constexpr double kWidest = 0.98;  ///< of the pipe's radius

}  // namespace

BranchMouth::BranchMouth(const robot::Camera& camera, const BranchedPipe& pipe,
                         const WallPose& pose, double right_m, double distance_m, double angle_rad)
    : pipe_(pipe),
      focal_px_(camera.focal_px),
      right_m_(right_m),
      center_px_(camera.center_x_px, camera.center_y_px) {
  const PipeWall wall(camera, pipe.pipe_radius_m, pose);
  p_CM_ = wall.PointAt(distance_m, {0.0, 0.0});
  along_ = wall.PointAt(distance_m + 1.0, {0.0, 0.0}) - p_CM_;
  out_ = (wall.PointAt(distance_m, {std::cos(angle_rad), std::sin(angle_rad)}) - p_CM_) /
         pipe.pipe_radius_m;
  across_ = along_.cross(out_);
}

std::optional<BranchMouth::Spot> BranchMouth::At(double along, double across) const {
  const double radius_m = pipe_.branch_radius_m;
  const double sine = across * radius_m / pipe_.pipe_radius_m;
  if (std::abs(sine) > kWidest) return {};
  const Vector3d outward = std::sqrt(1.0 - sine * sine) * out_ + sine * across_;
  const Vector3d p_CW = p_CM_ + along * radius_m * along_ + pipe_.pipe_radius_m * outward;
  if (p_CW.z() < kNearest_m) return {};
  Spot spot{center_px_ + focal_px_ / p_CW.z() * cv::Point2d(p_CW.x(), p_CW.y()),
            LogLight(p_CW, -outward), 0.0};
  if (along * along + across * across >= 1.0) return spot;
  // On along the same ray until it leaves the branch: a quadratic in the plane square to its axis.
  const Eigen::Vector2d from(along * radius_m, across * radius_m);
  const Eigen::Vector2d ray(p_CW.dot(along_), p_CW.dot(across_));
  const double a = ray.squaredNorm(), b = from.dot(ray),
               c = from.squaredNorm() - radius_m * radius_m;
  const Vector3d p_CB = (1.0 + (-b + std::sqrt(b * b - a * c)) / a) * p_CW;
  const Vector3d off = p_CB - p_CM_;
  spot.branch = LogLight(p_CB, (off.dot(out_) * out_ - off) / radius_m);
  return spot;
}

/// Lambert's law and that of the inverse square, of lamps that send as much as the cosine to where
/// they shine. They sit about the camera: what it sees, they reach, and no edge throws a shadow.
double BranchMouth::LogLight(const Vector3d& p_C, const Vector3d& normal) const {
  const Vector3d p_LP = p_C + right_m_ * Vector3d::UnitX();
  double light = 1e-6;
  for (const Vector3d& lamp : pipe_.p_CLamp) {
    const Vector3d to = lamp - p_LP;
    const double range2 = to.squaredNorm();
    light += std::max(0.0, normal.dot(to)) * std::max(0.0, -to.z()) / (range2 * range2);
  }
  return std::log(light);
}

}  // namespace kantaro::perception
