#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/mouth_fit.hpp"
#include "perception/tried_distance.hpp"

namespace kantaro::perception {

/// A picture of a manhole ahead.
struct MouthSight {
  cv::Mat log_brightness;
  WallPose pose;
  double roll_rad{};  ///< of the wall against the last picture's, clockwise
  double ahead_m{};  ///< added to a distance from the last left picture, the distance from this one
  double right_m{};  ///< of the camera from the left one
};

/// Where a manhole's mouth is, by all pictures together: before calibration.
[[nodiscard]] RangedLandmark FindMouth(const MouthFit& fit, const std::vector<MouthSight>& sights,
                                       double near_m, double far_m);

}  // namespace kantaro::perception
