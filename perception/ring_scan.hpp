#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/ring_contrast.hpp"
#include "perception/ring_votes.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// How much speaks for a ring at each distance, in one picture.
///
/// As RingFinder, but the polar picture follows the wall as it lies before the camera: a ring is a
/// column of it even where the robot is off the axis and turned, and its centre is looked for in a
/// small neighbourhood alone. Nothing is judged: scores of several pictures add up first.
class RingScan {
 public:
  /// Scores by column; column k stands for the nominal radius first_px + k.
  struct Scores {
    std::vector<double> significance;  ///< kUnseen where too little is visible
    std::vector<cv::Point> offset;     ///< of the ring's centre from where the pose puts it [px]
  };
  static constexpr double kUnseen = -1e3;
  /// One picture, scanned for joints or for mouths.
  struct Scanned {
    int first_px{};
    double ring_px_m{};  ///< focal length times the pipe's radius
    double focal_px{};
    Polar polar;
    Scores mouth;  ///< if mouths are looked for

    [[nodiscard]] double DistanceOf(double column) const { return ring_px_m / (first_px + column); }
    [[nodiscard]] double ColumnOf(double distance_m) const {
      return ring_px_m / distance_m - first_px;
    }
    /// Significance between columns; kUnseen beyond them.
    [[nodiscard]] double At(const Scores& scores, double distance_m) const;
  };

  /// @throws std::invalid_argument for a radius that is not above 0.
  RingScan(const robot::Camera& camera, double pipe_radius_m, double near_m, double far_m);

  /// @param log_brightness  as LogBrightness makes it
  [[nodiscard]] Scanned Scan(const cv::Mat& log_brightness, const WallPose& pose, bool mouth) const;

 private:
  [[nodiscard]] Polar Unroll(const cv::Mat& log_brightness, const WallPose& pose) const;

  robot::Camera camera_;
  double pipe_radius_m_;
  Optics optics_;
  int smallest_px_{}, largest_px_{}, pad_px_{};
};

}  // namespace kantaro::perception
