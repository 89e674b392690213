#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/random.hpp"

namespace kantaro::sim {

/// Shot and read noise of a camera. Renderer's response is a square root, under which shot noise, whose variance
/// grows with the light, has one standard deviation at every brightness; read noise adds to it in the dark, where
/// the picture is clipped anyway. So one number serves: Gaussian, independent by pixel and channel.
/// Immutable once made; one may serve several cameras and threads.
class CameraNoise {
 public:
  /// @param standard_deviation  in steps of the 8-bit image, 0 to 30. @throws std::invalid_argument
  explicit CameraNoise(double standard_deviation);

  /// Adds a frame's noise to an 8-bit image of any number of channels. Each row draws its place in a fixed table
  /// of a million normal numbers from `random`, which costs a fraction of a millisecond a frame.
  void AddTo(cv::Mat& image, RandomStream& random) const;

 private:
  std::vector<std::int8_t> table_;
};

}  // namespace kantaro::sim
