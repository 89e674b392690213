#include "sim/camera_noise.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::sim {
namespace {

constexpr std::size_t kTableSize = std::size_t{1} << 20;

}  // namespace

CameraNoise::CameraNoise(double standard_deviation) {
  if (!(standard_deviation >= 0.0 && standard_deviation <= 30.0)) {
    throw std::invalid_argument("camera noise must be 0 to 30 steps of an 8-bit image");
  }
  RandomStream random(0, "camera noise table");
  table_.resize(kTableSize);
  for (std::int8_t& value : table_) {
    value = static_cast<std::int8_t>(std::clamp(std::lround(random.Normal(standard_deviation)), -127L, 127L));
  }
}

void CameraNoise::AddTo(cv::Mat& image, RandomStream& random) const {
  const std::size_t row_size = static_cast<std::size_t>(image.cols) * image.elemSize();
  if (image.depth() != CV_8U || row_size >= table_.size()) {
    throw std::invalid_argument("camera noise is for 8-bit images of camera size");
  }
  for (int row = 0; row < image.rows; ++row) {
    const std::int8_t* noise = table_.data() + random.Index(table_.size() - row_size);
    std::uint8_t* values = image.ptr<std::uint8_t>(row);
    for (std::size_t i = 0; i < row_size; ++i) {
      values[i] = static_cast<std::uint8_t>(std::clamp(values[i] + noise[i], 0, 255));
    }
  }
}

}  // namespace kantaro::sim
