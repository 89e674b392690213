#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/ring_contrast.hpp"
#include "perception/ring_votes.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// Unrolls a picture along the wall as it lies before the camera: a ring of the wall is a column of
/// it even where the robot is off the axis and turned.
class RingScan {
 public:
  /// One picture, unrolled.
  struct Scanned {
    int first_px{};
    double ring_px_m{};  ///< focal length times the pipe's radius
    double focal_px{};
    Polar polar;

    [[nodiscard]] double DistanceOf(double column) const { return ring_px_m / (first_px + column); }
    [[nodiscard]] double ColumnOf(double distance_m) const {
      return ring_px_m / distance_m - first_px;
    }
  };

  /// @throws std::invalid_argument for a radius that is not above 0.
  RingScan(const robot::Camera& camera, double pipe_radius_m, double near_m, double far_m);

  /// @param log_brightness  as LogBrightness makes it
  [[nodiscard]] Scanned Scan(const cv::Mat& log_brightness, const WallPose& pose) const;

 private:
  [[nodiscard]] Polar Unroll(const cv::Mat& log_brightness, const WallPose& pose) const;

  robot::Camera camera_;
  double pipe_radius_m_, ring_px_m_{};
  int smallest_px_{}, largest_px_{}, pad_px_{};
};

}  // namespace kantaro::perception
