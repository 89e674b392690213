#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "base/random.hpp"

namespace kantaro::sim {

/// What an image sensor adds to what falls on it: shot noise, growing with the square root of the
/// light, over read noise.
struct ImageNoise {
  double read_levels{1.2};  ///< standard deviation in the dark [8-bit levels]
  double shot_levels{2.2};  ///< at full scale
};

/// Normal numbers in units of 1/kNoiseUnit standard deviations, the same in every run: read from a
/// place that a random number chooses, they are the noise of a picture at a fraction of the cost of
/// drawing every pixel's.
[[nodiscard]] std::span<const std::int8_t> NoiseField();
inline constexpr int kNoiseUnit = 32;

/// Adds noise to an 8-bit BGR image as a renderer drew it, in place: a plain stand-in for an Imager
/// where an ideal pinhole is wanted. From the noise field, at an offset that `random` draws.
void AddSensorNoise(cv::Mat& image, RandomStream& random, const ImageNoise& noise = {});

}  // namespace kantaro::sim
