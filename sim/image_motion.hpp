#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "sim/lens_map.hpp"
#include "sim/ray_caster.hpp"

namespace kantaro::sim {

/// How a camera moves, in its own optical frame.
struct CameraMotion {
  Eigen::Vector3d velocity_C{Eigen::Vector3d::Zero()};          ///< of its origin [m/s]
  Eigen::Vector3d angular_velocity_C{Eigen::Vector3d::Zero()};  ///< [rad/s]
};

/// How fast the image of a point moves that the camera sees in a direction (x, y, 1), at this
/// depth along the optical axis: (x, y) per second. Longuet-Higgins and Prazdny, Proceedings of the
/// Royal Society B 208, 1980.
[[nodiscard]] Eigen::Vector2d ImageVelocity(const CameraMotion& motion,
                                            const Eigen::Vector2d& direction, double depth_m);

/// How fast what each pixel of a lens map's ideal picture shows moves across it. Measured along
/// rays to the walls on a grid, linear between its nodes.
class MotionField {
 public:
  static constexpr int kGrid_px = 64;

  /// Nothing moves.
  MotionField() = default;
  /// @param X_WC  of the camera in the middle of the exposure.
  MotionField(const LensMap& lens, const RayCaster& rays, const Eigen::Isometry3d& X_WC,
              const CameraMotion& motion);

  /// Velocities at the nodes, CV_64FC2 [px/s]; empty if nothing moves.
  [[nodiscard]] const cv::Mat& nodes() const { return nodes_; }
  /// At a place of the ideal picture, or the place in it that is nearest [px/s].
  [[nodiscard]] Eigen::Vector2d At(const Eigen::Vector2d& p_px) const;
  /// The largest of them [px/s].
  [[nodiscard]] double Fastest() const { return fastest_px_s_; }

 private:
  cv::Mat nodes_;
  double fastest_px_s_{};
};

/// Where each pixel of a picture looks in the ideal one, for cv::remap: CV_16SC2 and CV_16UC1.
struct RemapMaps {
  cv::Mat whole, fraction;
};

/// The maps if odd rows look at the picture as it is `odd_rows_s` later.
void FillMaps(const LensMap& lens, const MotionField& field, double odd_rows_s, RemapMaps& maps);

}  // namespace kantaro::sim
