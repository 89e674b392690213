#pragma once

#include <opencv2/core.hpp>

#include "base/random.hpp"

namespace kantaro::sim {

/// What an image sensor adds to what falls on it: shot noise, growing with the square root of the
/// light, over read noise.
struct ImageNoise {
  double read_levels{1.2};  ///< standard deviation in the dark [8-bit levels]
  double shot_levels{2.2};  ///< at full scale
};

/// Adds noise to an 8-bit BGR image as a renderer drew it, in place: a plain stand-in for an Imager
/// where an ideal pinhole is wanted. The pattern is a fixed field of normal numbers read
/// from an offset that `random` draws: each image gets another, at a fraction of the cost of
/// drawing every pixel.
void AddSensorNoise(cv::Mat& image, RandomStream& random, const ImageNoise& noise = {});

}  // namespace kantaro::sim
