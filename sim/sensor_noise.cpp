#include "sim/sensor_noise.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace kantaro::sim {
namespace {

constexpr int kHalf = 256 * kNoiseUnit / 2;

/// Standard deviation for each level, in 1/256 levels.
std::array<int, 256> Deviations(const ImageNoise& noise) {
  std::array<int, 256> deviations{};
  for (std::size_t level = 0; level < deviations.size(); ++level) {
    const double shot = noise.shot_levels * std::sqrt(static_cast<double>(level) / 255.0);
    deviations[level] = static_cast<int>(std::lround(256.0 * std::hypot(noise.read_levels, shot)));
  }
  return deviations;
}

}  // namespace

std::span<const std::int8_t> NoiseField() {
  /// A prime, so that no image width divides it and rows do not repeat under each other.
  constexpr std::size_t kField = 1'000'003;
  static const std::vector<std::int8_t> field = [] {
    RandomStream random(0, "image noise field");
    std::vector<std::int8_t> values(kField);
    for (std::int8_t& value : values) {
      value = static_cast<std::int8_t>(
          std::lround(std::fmin(std::fmax(random.Normal(kNoiseUnit), -127.0), 127.0)));
    }
    return values;
  }();
  return field;
}

void AddSensorNoise(cv::Mat& image, RandomStream& random, const ImageNoise& noise) {
  if (image.type() != CV_8UC3) throw std::invalid_argument("sensor noise goes on 8-bit BGR images");
  const std::span<const std::int8_t> field = NoiseField();
  const std::array<int, 256> deviations = Deviations(noise);
  std::size_t at = random.Index(field.size());
  for (int y = 0; y < image.rows; ++y) {
    auto* row = image.ptr<std::uint8_t>(y);
    for (int x = 0; x < 3 * image.cols; ++x) {
      const int change =
          (deviations[row[x]] * field[at] + kHalf) >> 13;  // / (256 * kNoiseUnit), rounded
      row[x] = cv::saturate_cast<std::uint8_t>(row[x] + change);
      if (++at == field.size()) at = 0;
    }
  }
}

}  // namespace kantaro::sim
