#pragma once

#include <opencv2/core/mat.hpp>

namespace kantaro::perception::stereo {

/// Blocks are 8 x 8 pixels (thesis section 5.4.2; eq. 5.13 writes a pitch of 7, which fits neither
/// that nor 640 x 480).
inline constexpr int kBlock_px = 8;

enum class Interpolation { kNearest, kLinear, kCubic };

/// Keys' cubic interpolation kernel, a = −1/2 (eq. 5.14), at a distance in units of the pitch.
[[nodiscard]] double KeysKernel(double distance);
/// Its slope.
[[nodiscard]] double KeysKernelSlope(double distance);

/// How many corners a side of an image has: at 0, 8, 16, … up to the first at or beyond its end.
[[nodiscard]] int CornersAlong(int pixels);

/// Extends the corners' disparities to every pixel (eq. 5.15, 5.16, for any fraction of a block),
/// rows and columns in turn, corners beyond the border as the last. "Average" there means the
/// weighted sum.
///
/// Where a corner that takes part has no disparity, linear takes the place of cubic, and the
/// nearest corner the place of linear; where that has none either, the pixel has none.
/// @param corners  CV_32F, CornersAlong(height) x CornersAlong(width), NaN: none.
/// @returns CV_32F of the size; NaN: none.
/// @throws std::invalid_argument if `corners` is not of that type or shape.
[[nodiscard]] cv::Mat Interpolate(const cv::Mat& corners, cv::Size size, Interpolation kind);

}  // namespace kantaro::perception::stereo
