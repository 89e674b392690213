#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "robot/description.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// Turns a camera's pictures into those of the ideal pinhole that its calibration names: focal_px
/// about (center_x_px, center_y_px), without distortion. Bilinear, with maps made once, to 1/32 px.
class Rectifier {
 public:
  /// @param R_RC  from the optical frame C to the frame R of the rectified picture.
  explicit Rectifier(const Camera& camera,
                     const Eigen::Matrix3d& R_RC = Eigen::Matrix3d::Identity());

  /// @param image  8-bit, one or three channels, of the camera's size.
  /// @returns the same size and type; black where the camera does not see; the image itself where
  /// there is nothing to rectify.
  /// @throws std::invalid_argument for another size.
  [[nodiscard]] cv::Mat Rectify(const cv::Mat& image) const;

 private:
  cv::Size size_;
  cv::Mat whole_, fraction_;  ///< empty: the camera is an ideal pinhole
};

/// From a camera's optical frame C to its rectified frame R. The front camera's R is its link's
/// frame. The stereo cameras share theirs: x along the baseline from left to right, z as near to
/// the left link's as that allows; so a point has one row in both pictures, and the disparity
/// x_L − x_R = focal_px · baseline / Z.
[[nodiscard]] Eigen::Matrix3d FrontRectification(const Description& description);
[[nodiscard]] Eigen::Matrix3d StereoRectification(const Description& description,
                                                  const Camera& camera);

/// Distance of the two lenses [m].
[[nodiscard]] double StereoBaseline_m(const Description& description);

/// Rectifies both pictures of a pair.
class StereoRectifier {
 public:
  explicit StereoRectifier(const Description& description);
  [[nodiscard]] StereoPair Rectify(const StereoPair& pair) const;

 private:
  Rectifier left_, right_;
};

}  // namespace kantaro::robot
