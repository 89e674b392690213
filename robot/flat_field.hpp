#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "robot/description.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// Undoes in rectified pictures what the lens keeps from the sensor off its axis, as calibrated
/// (ImageSensor::vignetting). A wall that both cameras of a pair see lies at different distances
/// from their axes, so without this it is not equally bright in both: 150 px from the axis it gets
/// 7 % less light than 100 px from it (554 px of focal length, cos⁴).
///
/// Levels are taken to go with the 1/2.2nd power of light, as cameras' do. To 1/4096 of the level.
class FlatField {
 public:
  /// @param R_RC  from the optical frame C to the frame R of the rectified picture.
  FlatField(const Camera& camera, const Eigen::Matrix3d& R_RC);

  /// @param rectified  8-bit, one channel, of the camera's size.
  /// @returns the same as bright everywhere as on the lens' axis, saturated at 255.
  /// @throws std::invalid_argument for another type or size.
  [[nodiscard]] cv::Mat Flatten(const cv::Mat& rectified) const;

 private:
  cv::Mat gain_;  ///< CV_16U [1/4096]
};

/// Flattens both pictures of a pair that StereoRectifier made.
class StereoFlatField {
 public:
  explicit StereoFlatField(const Description& description);
  [[nodiscard]] StereoPair Flatten(const StereoPair& rectified) const;

 private:
  FlatField left_, right_;
};

}  // namespace kantaro::robot
