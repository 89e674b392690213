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
  /// Scores of one sort of ring by column; column k stands for the nominal radius first_px + k.
  struct Scores {
    std::vector<double> significance;  ///< contrast over its chance in mere texture; 0: not seen
    std::vector<double> contrast;      ///< of log brightness
    std::vector<cv::Point> offset;     ///< of the ring's centre from where the pose puts it [px]
  };
  /// One picture, scanned.
  struct Scanned {
    int first_px{};
    double ring_px_m{};  ///< focal length times the pipe's radius
    Contrasts contrasts;
    Polar polar;
    Scores joint, mouth;

    [[nodiscard]] double DistanceOf(double column) const { return ring_px_m / (first_px + column); }
    [[nodiscard]] double ColumnOf(double distance_m) const {
      return ring_px_m / distance_m - first_px;
    }
  };

  /// @throws std::invalid_argument for a radius that is not above 0.
  RingScan(const robot::Camera& camera, double pipe_radius_m, double near_m, double far_m);

  [[nodiscard]] Scanned Scan(const cv::Mat& brightness, const WallPose& pose) const;

  /// A circle in a scanned picture.
  struct Ring {
    double column{};
    cv::Point2d offset;
  };
  /// A ring near a column, to a fraction of a pixel: the circle of most contrast.
  [[nodiscard]] static Ring Refine(const Scanned& scanned, bool mouth, int column);

  /// What is left of the brightness across a ring at its crown and shoulders, once a line there, or
  /// a step (where the wall ends), is taken away: sums of squares.
  struct Misfit {
    double line{}, step{};
  };
  [[nodiscard]] static Misfit Compare(const Scanned& scanned, int line_column, int step_column);

 private:
  [[nodiscard]] Polar Unroll(const cv::Mat& log_brightness, const WallPose& pose) const;

  robot::Camera camera_;
  double pipe_radius_m_;
  Optics optics_;
  int smallest_px_{}, largest_px_{}, pad_px_{};
};

}  // namespace kantaro::perception
