#include "sim/image_sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/renderer.hpp"
#include "sim/sensor_noise.hpp"

namespace kantaro::sim {
namespace {

constexpr int kLevels = 256;
constexpr int kTransmissions = 128;
/// Below this signal the camera's curve leaves the renderer's, whose slope has no end.
constexpr double kToe = 0.02;
/// The light that the renderer draws as each level.
const std::array<double, kLevels>& Radiances() {
  static const std::array<double, kLevels> radiances = [] {
    std::array<double, kLevels> inverse{};
    for (int level = 0; level < kLevels; ++level) {
      double low = 0.0, high = 16.0;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (255.0 * Response(middle) < std::min(level, 254) ? low : high) = middle;
      }
      inverse[static_cast<std::size_t>(level)] = low;
    }
    return inverse;
  }();
  return radiances;
}

/// Means and noise add up in 1/4096 levels.
void AddNoise(std::span<const std::int16_t> mean, std::span<const std::int16_t> deviation,
              const std::int8_t* __restrict noise, std::uint8_t* __restrict pixel) {
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const int level = (64 * mean[i] + deviation[i] * noise[i] + 2048) >> 12;
    pixel[i] = static_cast<std::uint8_t>(std::clamp(level, 0, 255));
  }
}

double Slope(double signal) {
  constexpr double kStep = 1e-5;
  return (CameraCurve(signal + kStep) - CameraCurve(signal - kStep)) / (2.0 * kStep);
}

}  // namespace

double CameraCurve(double signal) {
  if (signal >= kToe) return Response(signal);
  // The parabola from black that meets the curve with its slope.
  static const double black = Response(0.0);
  static const double chord = (Response(kToe) - black) / kToe;
  static const double end = (Response(kToe + 1e-6) - Response(kToe - 1e-6)) / 2e-6;
  static const double start = 2.0 * chord - end;
  return black + signal * (start - std::max(0.0, signal) * (start - end) / (2.0 * kToe));
}

ImageSensorModel::ImageSensorModel(const robot::ImageSensor& sensor, const cv::Mat& transmission)
    : outcomes_(static_cast<std::size_t>(kTransmissions) * kLevels) {
  double most = 0.0;
  cv::minMaxLoc(transmission, nullptr, &most);
  // OpenCV's own conversion may fuse its steps on some processors, and round otherwise.
  rows_.create(transmission.size(), CV_8U);
  for (int y = 0; y < rows_.rows; ++y) {
    for (int x = 0; x < rows_.cols; ++x) {
      rows_.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
          std::lround((kTransmissions - 1) / most * transmission.at<float>(y, x)));
    }
  }
  const double signal_per_e = sensor.gain * kFullSignal / sensor.full_well_e;
  for (int row = 0; row < kTransmissions; ++row) {
    const double share = most * row / (kTransmissions - 1);
    for (int level = 0; level < kLevels; ++level) {
      const double electrons =
          std::min(sensor.full_well_e, sensor.sensitivity_e_s * sensor.exposure_s * share *
                                           Radiances()[static_cast<std::size_t>(level)]);
      const double signal = signal_per_e * electrons;
      const double noise =
          signal_per_e * std::sqrt(electrons + sensor.read_noise_e * sensor.read_noise_e);
      outcomes_[static_cast<std::size_t>(row * kLevels + level)] = {
          static_cast<std::int16_t>(std::lround(64.0 * 255.0 * CameraCurve(signal))),
          static_cast<std::int16_t>(
              std::lround(std::min(32767.0, 128.0 * 255.0 * Slope(signal) * noise)))};
    }
  }
}

void ImageSensorModel::Expose(cv::Mat& image, RandomStream& random) const {
  if (image.type() != CV_8UC3 || image.size() != rows_.size())
    throw std::invalid_argument("a sensor takes 8-bit BGR pictures of its own size");
  const std::span<const std::int8_t> field = NoiseField();
  std::size_t at = random.Index(field.size());
  const auto width = static_cast<std::size_t>(image.cols);
  // Looked up first, reckoned then: processors do the second step many at a time.
  std::vector<std::int16_t> mean(3 * width), deviation(3 * width);
  for (int y = 0; y < image.rows; ++y) {
    if (at + 3 * width > field.size()) at -= field.size() - 3 * width;
    auto* pixel = image.ptr<std::uint8_t>(y);
    LookUp(rows_.ptr<std::uint8_t>(y), pixel, mean, deviation);
    AddNoise(mean, deviation, field.data() + at, pixel);
    at += 3 * width;
  }
}

void ImageSensorModel::LookUp(const std::uint8_t* rows, const std::uint8_t* pixel,
                              std::span<std::int16_t> mean,
                              std::span<std::int16_t> deviation) const {
  for (std::size_t i = 0; i < mean.size(); i += 3) {
    const Outcome* outcomes = outcomes_.data() + static_cast<std::size_t>(*rows++) * kLevels;
    for (std::size_t c = i; c < i + 3; ++c) {
      const Outcome outcome = outcomes[pixel[c]];
      mean[c] = outcome.mean;
      deviation[c] = outcome.deviation;
    }
  }
}

}  // namespace kantaro::sim
