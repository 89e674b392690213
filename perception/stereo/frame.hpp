#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>

#include "perception/stereo/stereo.hpp"

namespace kantaro::perception::stereo {

inline constexpr int kMaxWindow_px = 11;  ///< sums of products then fit 32 bits
inline constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// A pair of smoothed images and where in them windows can be compared: what every matcher works
/// on. Candidate i stands for the disparity min_disparity_px + i.
struct Frame {
  Frame(const cv::Mat& left_image, const cv::Mat& right_image, const Parameters& p)
      : left(left_image),
        right(right_image),
        parameters(p),
        radius(p.window_px / 2),
        area(p.window_px * p.window_px),
        max_disparity(p.min_disparity_px + p.disparities - 1),
        first_column(max_disparity + radius),
        end_column(left_image.cols - radius) {}

  [[nodiscard]] const std::uint8_t* Left(int row) const { return left.ptr(row); }
  /// The right image's row, moved so that [x] is the partner of the left pixel x.
  [[nodiscard]] const std::uint8_t* Right(int row, int candidate) const {
    return right.ptr(row) - parameters.min_disparity_px - candidate;
  }
  [[nodiscard]] cv::Mat NoDisparities() const { return {left.size(), CV_32F, cv::Scalar(kNone)}; }

  const cv::Mat& left;
  const cv::Mat& right;
  const Parameters& parameters;
  int radius;         ///< of the window
  int area;           ///< pixels of the window
  int max_disparity;  ///< the last candidate's
  int first_column;   ///< where the window fits at every candidate …
  int end_column;  ///< … up to before this one; the rows are radius … height − radius − 1
};

}  // namespace kantaro::perception::stereo
