#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/stereo/frame.hpp"

namespace kantaro::perception::stereo {

/// Conventional matching by square windows centred on the pixel (section 5.3.1; eq. 5.7 starts its
/// windows at a corner). All give CV_32F disparities, NaN where there is none.

/// Sum of squared differences, each window summed anew: what the thesis measures time against.
[[nodiscard]] cv::Mat MatchPlainSsd(const Frame& frame);
/// The same sums by a sliding window: the same result, to the bit.
[[nodiscard]] cv::Mat MatchSsd(const Frame& frame);
/// Gradient measure of D. Scharstein, "Matching images by comparing their gradient fields", 1994:
/// the most of (|g_L| + |g_R|) / 2 − |g_L − g_R|, summed over the window; g is the gradient by
/// central differences.
[[nodiscard]] cv::Mat MatchGradient(const Frame& frame);
/// Normalised cross-correlation (eq. 5.9, 5.10); 0 with a flat window.
[[nodiscard]] cv::Mat MatchNcc(const Frame& frame);

/// Costs of one image row, the less the better: [candidate][column].
template <typename Cost>
class CostRow {
 public:
  CostRow(int candidates, int width)
      : width_(width), costs_(static_cast<std::size_t>(candidates) * width) {}
  [[nodiscard]] Cost* operator[](int candidate) {
    return costs_.data() + static_cast<std::size_t>(candidate) * width_;
  }
  [[nodiscard]] const Cost* operator[](int candidate) const {
    return costs_.data() + static_cast<std::size_t>(candidate) * width_;
  }

 private:
  int width_;
  std::vector<Cost> costs_;
};

/// The best candidate of each column of a row; the lowest of equals. Only the frame's columns.
template <typename Cost>
void FindWinners(const Frame& frame, const CostRow<Cost>& costs, std::vector<Cost>& best,
                 std::vector<std::int32_t>& winner) {
  const int first = frame.first_column, end = frame.end_column;
  best.assign(costs[0], costs[0] + frame.left.cols);
  winner.assign(frame.left.cols, 0);
  Cost* const least = best.data();
  std::int32_t* const index = winner.data();
  for (int i = 1; i < frame.parameters.disparities; ++i) {
    const Cost* const cost = costs[i];
    for (int x = first; x < end; ++x) {
      const bool better = cost[x] < least[x];
      least[x] = better ? cost[x] : least[x];
      index[x] = better ? i : index[x];
    }
  }
}

/// Where the parabola through three costs at −1, 0 and 1 is lowest, if the middle one is the least:
/// −0.5 … 0.5.
[[nodiscard]] inline double ParabolaOffset(double before, double middle, double after) {
  const double curvature = before - 2 * middle + after;
  return curvature > 0 ? (before - after) / (2 * curvature) : 0.0;
}

/// Disparity of a candidate of a column, refined if the parameters ask for it.
template <typename Cost>
[[nodiscard]] float DisparityOf(const Frame& frame, const CostRow<Cost>& costs, int candidate,
                                int x) {
  const Parameters& p = frame.parameters;
  double disparity = p.min_disparity_px + candidate;
  if (p.subpixel && candidate > 0 && candidate + 1 < p.disparities) {
    const double before = costs[candidate - 1][x], middle = costs[candidate][x],
                 after = costs[candidate + 1][x];
    if (middle <= before && middle <= after) disparity += ParabolaOffset(before, middle, after);
  }
  return static_cast<float>(disparity);
}

/// 255 where the left window shows something to match (Parameters::least_deviation), else 0.
[[nodiscard]] cv::Mat Textured(const Frame& frame);

/// Calls `use` with the sums of squared differences of each row that has any, from top to bottom.
void ForEachSsdRow(const Frame& frame,
                   const std::function<void(int y, const CostRow<std::int32_t>& costs)>& use);

}  // namespace kantaro::perception::stereo
