#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/stereo/frame.hpp"

namespace kantaro::perception::stereo {

/// Group classification (eq. 5.1): 255 for a feature pixel, |I(x, y) − I(x − 1, y)| >= threshold,
/// else 0. The first column has no left neighbour and no feature.
/// @param image  8-bit, one channel.
/// @throws std::invalid_argument for another image.
[[nodiscard]] cv::Mat FeaturePixels(const cv::Mat& image, int threshold);

/// The LC measure (eq. 5.2) along one row at a time:
///   E_d = |D_L(x)| + |D_R(x − d)| − |D_L(x) − D_R(x − d)|,   D(x) = I(x) − I(x − 1),
/// which is 2 min(|D_L|, |D_R|) for equal signs and 0 for unequal ones. Many candidates tie: any
/// that is at least as steep as the left pixel. The least |D_L − D_R| decides, then the nearest to
/// the left neighbour's disparity.
class LinearComputation {
 public:
  explicit LinearComputation(const Frame& frame);

  void StartRow(int y);
  /// |D_L| at a column of the row.
  [[nodiscard]] int Difference(int x) const { return left_[x]; }
  /// Disparity at a column, max_disparity < x < width; NaN where no candidate has E_d > 0.
  /// @param neighbour  disparity of the pixel to the left; NaN: the lowest of ties wins
  [[nodiscard]] float Disparity(int x, float neighbour);

 private:
  const Frame& frame_;
  std::vector<std::uint8_t> left_;     ///< |D_L|
  std::vector<std::uint8_t> falling_;  ///< 1 where D_L < 0
  /// D_R of either sign, else 0; columns from right to left, so that candidates follow each other.
  std::vector<std::uint8_t> right_rise_, right_fall_;
  std::vector<std::uint8_t>
      in_range_;  ///< 255 for each candidate, 0 for what fills the last vector
  std::vector<std::uint8_t> keys_;
};

/// LC at every pixel that differs from its left neighbour at all: CV_32F, NaN where there is none.
[[nodiscard]] cv::Mat MatchLc(const Frame& frame);

}  // namespace kantaro::perception::stereo
