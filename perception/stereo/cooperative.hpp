#pragma once

#include <opencv2/core/mat.hpp>

#include "perception/stereo/frame.hpp"

namespace kantaro::perception::stereo {

/// Cooperative stereo matching (thesis section 5.3): LC (eq. 5.2) on feature pixels (eq. 5.1); on
/// the others SSD, its minimum questioned by the function-value constraint (eq. 5.5) and then kept
/// near its left neighbour by ConstrainToNeighbour. A row is scanned from left to right, so the
/// neighbour's disparity is already the final one; where it has none, the pixel is free.
/// @returns CV_32F, NaN where there is none.
[[nodiscard]] cv::Mat MatchCooperative(const Frame& frame);

/// The neighbouring constraint (eq. 5.3, 5.4): a disparity more than `threshold` from the left
/// neighbour's becomes the neighbour's ± threshold / 2. As written it jumps there: a difference of
/// 10 stays 10, one of 11 becomes 5.
[[nodiscard]] float ConstrainToNeighbour(float current, float previous, double threshold);

}  // namespace kantaro::perception::stereo
