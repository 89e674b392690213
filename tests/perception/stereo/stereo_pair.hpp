#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>

#include "perception/stereo/stereo.hpp"

namespace kantaro::perception::stereo {

struct Pair {
  cv::Mat left, right;  ///< 8-bit
};

/// Every pixel of both images drawn for itself.
[[nodiscard]] Pair Noise(cv::Size size, std::uint64_t seed);
/// Noise of a few grey levels, so that costs tie often.
[[nodiscard]] Pair CoarseNoise(cv::Size size, std::uint64_t seed);

/// A surface with a smooth, strong texture, seen without interpolation: the texture is a formula.
/// @param disparity  of the left image's pixels, as a function of x and y.
[[nodiscard]] Pair Surface(cv::Size size, const std::function<double(int x, int y)>& disparity,
                           std::uint64_t seed);

/// No smoothing, a small window and few candidates: for references that sum by hand.
[[nodiscard]] Parameters Small(Method method);

/// Share of the pixels of a region whose disparity is within `tolerance` of `expected`.
[[nodiscard]] double ShareWithin(const DisparityMap& map, cv::Rect region,
                                 const std::function<double(int x, int y)>& expected,
                                 double tolerance);
[[nodiscard]] int CountDisparities(const DisparityMap& map);

/// A failure that names the first pixel that differs; NaN equals NaN.
void ExpectSame(const cv::Mat& actual, const cv::Mat& expected);

}  // namespace kantaro::perception::stereo
