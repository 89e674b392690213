#include "perception/ring_scan.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace kantaro::perception {
namespace {

constexpr int kCenterSearch_px = 10;

}  // namespace

RingScan::RingScan(const robot::Camera& camera, double pipe_radius_m, double near_m, double far_m)
    : camera_(camera), pipe_radius_m_(pipe_radius_m) {
  if (!(pipe_radius_m > 0.0)) {
    throw std::invalid_argument("ring scan: the pipe's radius must be above 0");
  }
  ring_px_m_ = camera.focal_px * pipe_radius_m;
  smallest_px_ = std::max(8, static_cast<int>(ring_px_m_ / far_m));
  largest_px_ = std::min(static_cast<int>(ring_px_m_ / near_m),
                         static_cast<int>(std::hypot(camera.width_px, camera.height_px) / 2));
  pad_px_ = static_cast<int>(kCenterSearch_px * 1.5) + kStepReach_px + 4;
  largest_px_ = std::max(largest_px_, smallest_px_ + 1);
}

Polar RingScan::Unroll(const cv::Mat& log_brightness, const WallPose& pose) const {
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  const int first = smallest_px_ - pad_px_;
  const cv::Size size(largest_px_ - smallest_px_ + 1 + 2 * pad_px_, kDirections);
  cv::Mat map_x(size, CV_32F), map_y(size, CV_32F);
  Polar polar{{}, cv::Mat::zeros(size, CV_8U), first};
  for (int t = 0; t < kDirections; ++t) {
    const Eigen::Vector2d direction(Directions()[t].x, Directions()[t].y);
    for (int k = 0; k < size.width; ++k) {
      const double radius_px = std::max(1.0, static_cast<double>(first + k));
      const cv::Point2d p = wall.Project(ring_px_m_ / radius_px, direction);
      map_x.at<float>(t, k) = static_cast<float>(p.x);
      map_y.at<float>(t, k) = static_cast<float>(p.y);
      polar.visible.at<std::uint8_t>(t, k) = first + k >= 1 && p.x >= 1 && p.y >= 1 &&
                                             p.x <= log_brightness.cols - 2 &&
                                             p.y <= log_brightness.rows - 2;
    }
  }
  cv::remap(log_brightness, polar.value, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return polar;
}

RingScan::Scanned RingScan::Scan(const cv::Mat& log_brightness, const WallPose& pose) const {
  Scanned scanned;
  scanned.ring_px_m = ring_px_m_;
  scanned.polar = Unroll(log_brightness, pose);
  scanned.first_px = scanned.polar.first_px;
  scanned.focal_px = camera_.focal_px;
  return scanned;
}

}  // namespace kantaro::perception
