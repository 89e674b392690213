#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "base/random.hpp"
#include "robot/description.hpp"

namespace kantaro::sim {

/// The camera's output for this amplified signal, 0 … 1 of the 8-bit range: Response(), as the
/// renderer draws, but for a parabola below 0.02, for the slope of a camera's curve ends somewhere.
/// Below 0 too: noise about black is seen because black is not the lowest level.
[[nodiscard]] double CameraCurve(double signal);

/// A sensor behind a lens: what it makes of light, in electrons.
///
/// A pixel collects n = sensitivity · exposure · transmission · radiance electrons, no more than
/// its well holds, with the shot noise √n; reading adds its own. The amplified signal, radiance 1
/// at kFullSignal⁻¹ of a full well times the gain, goes through the camera's curve. Noise passes it
/// by its slope.
class ImageSensorModel {
 public:
  /// Signal of a full well at gain 1.
  static constexpr double kFullSignal = 4.0;

  /// @param transmission  CV_32F, share of the light that each pixel gets.
  ImageSensorModel(const robot::ImageSensor& sensor, const cv::Mat& transmission);

  /// From a noiseless picture as the renderer draws it to the sensor's, in place: 8-bit BGR. The
  /// noise is a fixed field of normal numbers read from an offset that `random` draws: each picture
  /// gets another, at a fraction of the cost of drawing every pixel.
  /// @throws std::invalid_argument for another type, or a size other than the transmission's.
  void Expose(cv::Mat& image, RandomStream& random) const;

 private:
  /// What a level of the renderer's becomes.
  struct Outcome {
    std::int16_t mean;       ///< [1/64 levels]
    std::int16_t deviation;  ///< [1/128 levels]
  };
  /// Of a row of pixels, from each one's row of `outcomes_` and its level.
  void LookUp(const std::uint8_t* rows, const std::uint8_t* pixel, std::span<std::int16_t> mean,
              std::span<std::int16_t> deviation) const;

  std::vector<Outcome> outcomes_;  ///< by transmission, then level
  cv::Mat rows_;                   ///< CV_8U: the row of `outcomes_` for each pixel
};

}  // namespace kantaro::sim
