#pragma once

#include <opencv2/core.hpp>

#include "sim/image_motion.hpp"

namespace kantaro::sim {

/// Motion in an exposure by less than this is not drawn [px]: the variance that it gives an edge,
/// 1/12 px², is a third of what lens and pixel do.
inline constexpr double kUnseenBlur_px = 1.0;

/// Spreads what moves over the way that it moves in an exposure: where a picture moves by d px,
/// each point is spread by weights about it with the covariance of an even spread along d, d dᵀ/12.
/// Up to 11 px; farther is drawn as 11.
class MotionBlur {
 public:
  /// @param sharp  8-bit BGR, the ideal picture that `field` is of.
  /// @returns `sharp` itself, or, where it is seen to move, a blurred copy that lasts until the
  /// next call.
  const cv::Mat& Apply(const cv::Mat& sharp, const MotionField& field, double exposure_s);

 private:
  cv::Mat blurred_, before_;
};

}  // namespace kantaro::sim
