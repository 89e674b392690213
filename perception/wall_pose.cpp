#include "perception/wall_pose.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "perception/brightness.hpp"

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector4 = Eigen::Matrix<double, 4, 1>;
using Vector8 = Eigen::Matrix<double, 8, 1>;

constexpr int kGrid_px = 10;
constexpr double kNearest_m = 0.15, kFarthest_m = 1.0;
constexpr double kLowest = 0.2;  ///< of the wall below the axis, in radii: under it water may stand
constexpr double kOutlier = 0.08;  ///< log brightness
constexpr double kOffPrior_m = 0.010, kLeanPrior = 0.035, kPriorNoise = 10.0;
constexpr int kPasses = 12;
constexpr double kDarkFloor = 4.0;

/// Off x, off y, lean x, lean y.
WallPose PoseOf(const Vector4& x) { return {{x[0], x[1]}, {x[2], x[3]}}; }

struct Pixel {
  cv::Point2d at;
  double log_brightness{};
  double log_transmission{};
};

/// Share of the light that the lens passes, as calibrated.
double Transmission(const robot::Camera& camera, const cv::Point2d& pixel) {
  const Vector2d direction((pixel.x - camera.center_x_px) / camera.focal_px,
                           (pixel.y - camera.center_y_px) / camera.focal_px);
  if (!camera.sensor.vignetting) {
    const double cos2 = 1.0 / (1.0 + direction.squaredNorm());
    return cos2 * cos2;
  }
  const auto& [a, b, c] = *camera.sensor.vignetting;
  const double half_px = 0.5 * std::hypot(camera.width_px, camera.height_px);
  const double r2 =
      direction.squaredNorm() * camera.focal_px * camera.focal_px / (half_px * half_px);
  return std::max(0.05, 1.0 + r2 * (a + r2 * (b + r2 * c)));
}

std::vector<Pixel> Grid(const cv::Mat& brightness, const robot::Camera& camera) {
  cv::Mat smooth;
  cv::boxFilter(brightness, smooth, CV_32F, {kGrid_px, kGrid_px});
  std::vector<Pixel> pixels;
  for (int y = kGrid_px; y < brightness.rows - kGrid_px; y += kGrid_px) {
    for (int x = kGrid_px; x < brightness.cols - kGrid_px; x += kGrid_px) {
      const cv::Point2d at(x, y);
      pixels.push_back(
          {at, std::log(smooth.at<float>(y, x) + kDarkFloor), std::log(Transmission(camera, at))});
    }
  }
  return pixels;
}

/// Logarithm of the light that an even wall sends back.
double LogLight(const PipeWall& wall, const Vector3d& point_C,
                const std::vector<Vector3d>& p_CLamp) {
  const Vector3d inward = wall.Inward(point_C);
  double light = 1e-6;
  for (const Vector3d& lamp : p_CLamp) {
    const Vector3d to = lamp - point_C;
    const double range = to.norm();
    light += std::max(0.0, inward.dot(to)) * std::max(0.0, -to.z()) / std::pow(range, 4.0);
  }
  return std::log(light);
}

}  // namespace

Eigen::Matrix2d PoseDoubt::OfAxisAt(double distance_m) const {
  Eigen::Matrix<double, 2, 4> seen;
  seen << Eigen::Matrix2d::Identity() / distance_m, Eigen::Matrix2d::Identity();
  return seen * covariance * seen.transpose();
}

PipeWall::PipeWall(const robot::Camera& camera, double pipe_radius_m, const WallPose& pose)
    : focal_px_(camera.focal_px),
      center_px_(camera.center_x_px, camera.center_y_px),
      radius_m_(pipe_radius_m),
      off_(pose.off_m.x(), pose.off_m.y(), 0.0),
      along_(Vector3d(pose.lean.x(), pose.lean.y(), 1.0).normalized()),
      right_((Vector3d::UnitX() - along_.x() * along_).normalized()),
      down_(along_.cross(right_)) {}

cv::Point2d PipeWall::Project(double distance_m, const Vector2d& direction) const {
  return PixelOf(PointAt(distance_m, direction));
}

Vector3d PipeWall::PointAt(double distance_m, const Vector2d& direction) const {
  // Distances count along the axis from the foot of the camera's perpendicular on it.
  const Vector3d foot = off_ - off_.dot(along_) * along_;
  return foot + distance_m * along_ + radius_m_ * Outward(direction);
}

Vector3d PipeWall::PointAt(const cv::Point2d& pixel) const {
  const Vector3d ray((pixel.x - center_px_.x) / focal_px_, (pixel.y - center_px_.y) / focal_px_,
                     1.0);
  const Vector3d d = ray - ray.dot(along_) * along_;
  const Vector3d o = -(off_ - off_.dot(along_) * along_);
  const double a = std::max(d.squaredNorm(), 1e-9), b = o.dot(d),
               c = o.squaredNorm() - radius_m_ * radius_m_;
  return (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a * ray;
}

Vector2d PipeWall::DirectionOf(const Vector3d& point_C) const {
  const Vector3d out = point_C - off_;
  return Vector2d(out.dot(right_), out.dot(down_)).normalized();
}

Vector3d PipeWall::Inward(const Vector3d& point_C) const {
  const Vector3d out = point_C - off_;
  return -(out - out.dot(along_) * along_).normalized();
}

WallPose FindWallPose(const cv::Mat& brightness, const robot::Camera& camera,
                      const std::vector<Vector3d>& p_CLamp, double pipe_radius_m,
                      double camera_height_m) {
  RequireBrightness(brightness, "wall pose");
  const std::vector<Pixel> all = Grid(brightness, camera);
  const Vector4 usual(0.0, camera_height_m, 0.0, 0.0);
  Vector4 x = usual;
  Vector4 curve = Vector4::Zero();  // brightness by light, and by height: dirt lies low
  bool started = false;
  for (int pass = 0; pass < kPasses; ++pass) {
    const PipeWall wall(camera, pipe_radius_m, PoseOf(x));
    constexpr double kSmall = 1e-4;
    std::vector<PipeWall> moved;
    for (int i = 0; i < 4; ++i) {
      Vector4 other = x;
      other[i] += kSmall;
      moved.emplace_back(camera, pipe_radius_m, PoseOf(other));
    }
    Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
    Vector8 right = Vector8::Zero();
    for (const Pixel& pixel : all) {
      const Vector3d point = wall.PointAt(pixel.at);
      const Vector3d inward = wall.Inward(point);
      if (point.z() < kNearest_m || point.z() > kFarthest_m || inward.y() < -kLowest) continue;
      const double q = LogLight(wall, point, p_CLamp) + pixel.log_transmission;
      const double slope = curve[1] + 2.0 * curve[2] * q;
      Vector8 row;
      row.head<4>() << 1.0, q, q * q, inward.y();
      for (int i = 0; i < 4; ++i) {
        const double there =
            LogLight(moved[i], moved[i].PointAt(pixel.at), p_CLamp) + pixel.log_transmission;
        row[4 + i] = started ? slope * (there - q) / kSmall : 0.0;
      }
      const double off = pixel.log_brightness - curve.dot(row.head<4>());
      const double scaled = started ? off / kOutlier : 0.0;
      const double weight = 1.0 / ((1.0 + scaled * scaled) * (1.0 + scaled * scaled));
      normal += weight * row * row.transpose();
      right += weight * off * row;
    }
    // The curve is solved anew each time, the pose goes on from where it is.
    const double outlier2 = kOutlier * kOutlier * kPriorNoise;
    for (int i = 0; i < 4; ++i) {
      const double deviation = i < 2 ? kOffPrior_m : kLeanPrior;
      normal(4 + i, 4 + i) += outlier2 / (deviation * deviation);
      right[4 + i] -= outlier2 * (x[i] - usual[i]) / (deviation * deviation);
    }
    normal.topLeftCorner<4, 4>().diagonal().array() += 1e-9;
    const Vector8 step = normal.ldlt().solve(right);
    curve += step.head<4>();
    if (started) {
      const double largest = std::max(step.segment<2>(4).cwiseAbs().maxCoeff() / 0.02,
                                      step.segment<2>(6).cwiseAbs().maxCoeff() / 0.04);
      x += step.tail<4>() / std::max(1.0, largest);
    }
    started = true;
  }
  return PoseOf(x);
}

PoseDoubt DoubtOfLight() {
  constexpr double kOff_m = 0.004, kLean = 0.006, kTogether = -0.85;  // deviations, correlation
  PoseDoubt doubt;
  doubt.covariance << kOff_m * kOff_m * Eigen::Matrix2d::Identity(),
      kTogether * kOff_m * kLean * Eigen::Matrix2d::Identity(),
      kTogether * kOff_m * kLean * Eigen::Matrix2d::Identity(),
      kLean * kLean * Eigen::Matrix2d::Identity();
  return doubt;
}

std::vector<Vector3d> LampsBefore(const robot::Description& description,
                                  const robot::Camera& camera) {
  const Eigen::Isometry3d X_CB = description.PoseInBase(camera.link).inverse();
  std::vector<Vector3d> lamps;
  for (const std::string& link : description.lights)
    lamps.push_back(X_CB * description.PoseInBase(link).translation());
  return lamps;
}

}  // namespace kantaro::perception
