#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "base/random.hpp"
#include "robot/description.hpp"
#include "sim/renderer.hpp"

namespace kantaro::sim {

/// A drop of water on the front glass, as the sensor sees it: out of focus, it shows the picture
/// behind it squeezed and upside down, and keeps some light away at its rim.
struct LensDrop {
  Eigen::Vector2d middle_px{Eigen::Vector2d::Zero()};
  double radius_px{};
  double squeeze{1.6};  ///< 1 - the magnification in its middle: above 1 it turns the picture over
  double sag{0.1};      ///< share by which it hangs down
};

/// Drops as they happen to sit on a lens.
[[nodiscard]] std::vector<LensDrop> ScatterDrops(int count, const robot::Camera& camera,
                                                 RandomStream& random);

/// Where in the ideal pinhole picture, as the renderer draws it, each pixel of the real one looks.
class LensMap {
 public:
  /// Room around the ideal picture [px]: for what moves in an exposure, and of an interlaced camera
  /// for what moves from field to field too.
  static constexpr int kBlurMargin_px = 5, kFieldMargin_px = 6;

  explicit LensMap(const robot::Camera& camera, const std::vector<LensDrop>& drops = {});

  /// The ideal picture that must be drawn; its camera still stands at the origin.
  [[nodiscard]] const CameraView& ideal() const { return ideal_; }
  [[nodiscard]] cv::Size size() const { return base_.size(); }
  /// The direction that a pixel sees, drops aside, in the optical frame, with z = 1.
  [[nodiscard]] Eigen::Vector3d Direction(const Eigen::Vector2d& p_px) const;
  /// Where each pixel looks in the ideal picture: CV_32SC2 [1/kUnit px].
  [[nodiscard]] const cv::Mat& base() const { return base_; }
  static constexpr int kUnit = 1024;
  /// Share of the light that each pixel gets, against the axis: CV_32F. Vignetting and drops.
  [[nodiscard]] const cv::Mat& transmission() const { return transmission_; }

 private:
  robot::Lens lens_;
  CameraView ideal_;
  cv::Mat base_, transmission_;
};

}  // namespace kantaro::sim
