#include "robot/flat_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "robot/rectifier.hpp"

namespace kantaro::robot {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kUnit = 4096;
constexpr double kGamma = 2.2;
constexpr double kLeastShare = 0.05;  ///< below it a calibrated polynomial is out of its range

/// Share of the light that arrives from a direction in the optical frame.
double Transmission(const Camera& camera, const Lens& lens, const Vector3d& direction_C) {
  if (!camera.sensor.vignetting) {
    const double cos2 = direction_C.z() * direction_C.z() / direction_C.squaredNorm();
    return cos2 * cos2;
  }
  const auto& [a, b, c] = *camera.sensor.vignetting;
  const Vector2d p_px = Project(lens, direction_C.hnormalized());
  const double half_diagonal = 0.5 * std::hypot(camera.width_px, camera.height_px);
  const double r2 = (p_px - Vector2d(lens.center_x_px, lens.center_y_px)).squaredNorm() /
                    (half_diagonal * half_diagonal);
  return 1.0 + r2 * (a + r2 * (b + r2 * c));
}

}  // namespace

FlatField::FlatField(const Camera& camera, const Eigen::Matrix3d& R_RC)
    : gain_(camera.height_px, camera.width_px, CV_16U) {
  const Lens lens = LensOf(camera);
  for (int row = 0; row < gain_.rows; ++row) {
    for (int col = 0; col < gain_.cols; ++col) {
      const Vector3d direction_C =
          R_RC.transpose() * Vector3d((col - camera.center_x_px) / camera.focal_px,
                                      (row - camera.center_y_px) / camera.focal_px, 1.0);
      const double share = std::max(kLeastShare, Transmission(camera, lens, direction_C));
      gain_.at<std::uint16_t>(row, col) =
          static_cast<std::uint16_t>(std::lround(kUnit * std::pow(share, -1.0 / kGamma)));
    }
  }
}

cv::Mat FlatField::Flatten(const cv::Mat& rectified) const {
  if (rectified.type() != CV_8UC1 || rectified.size() != gain_.size())
    throw std::invalid_argument("a picture to flatten must be 8-bit grey, of its camera's size");
  cv::Mat flat(rectified.size(), CV_8U);
  for (int row = 0; row < flat.rows; ++row) {
    const std::uint8_t* const in = rectified.ptr(row);
    const auto* const gain = gain_.ptr<std::uint16_t>(row);
    std::uint8_t* const out = flat.ptr(row);
    for (int col = 0; col < flat.cols; ++col)
      out[col] =
          static_cast<std::uint8_t>(std::min(255, (in[col] * gain[col] + kUnit / 2) / kUnit));
  }
  return flat;
}

StereoFlatField::StereoFlatField(const Description& description)
    : left_(description.stereo_left, StereoRectification(description, description.stereo_left)),
      right_(description.stereo_right, StereoRectification(description, description.stereo_right)) {
}

StereoPair StereoFlatField::Flatten(const StereoPair& rectified) const {
  return {left_.Flatten(rectified.left), right_.Flatten(rectified.right)};
}

}  // namespace kantaro::robot
