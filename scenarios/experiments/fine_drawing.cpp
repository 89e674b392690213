#include "scenarios/experiments/fine_drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace kantaro::scenarios {
namespace {

constexpr int kSteps = 65536;  ///< of 1 − e^−radiance, from 0 to 1

/// 1 − e^−radiance of each level, in steps: the inverse of sim::Response up to its last curve.
const std::array<int, 256>& Exposures() {
  static const std::array<int, 256> exposures = [] {
    const double black = sim::Response(0.0);
    std::array<int, 256> of{};
    for (int level = 0; level < 256; ++level) {
      const double root = std::max(0.0, (level / 255.0 - black) / (1.0 - black));
      of[static_cast<std::size_t>(level)] = static_cast<int>(std::lround(kSteps * root * root));
    }
    return of;
  }();
  return exposures;
}

}  // namespace

sim::RendererOptions FineOptions(const sim::RendererOptions& options) {
  return {kFineness * options.max_width_px, kFineness * options.max_height_px};
}

cv::Mat MeanLight(const cv::Mat& image, int times) {
  if (image.type() != CV_8UC3 || times < 1 || image.cols % times != 0 || image.rows % times != 0)
    throw std::invalid_argument("mean light: 8-bit BGR of whole squares is wanted");
  static const std::array<std::uint8_t, kSteps + 1> levels = [] {
    const double black = sim::Response(0.0);
    std::array<std::uint8_t, kSteps + 1> of{};
    for (int step = 0; step <= kSteps; ++step) {
      const double root = std::sqrt(static_cast<double>(step) / kSteps);
      of[static_cast<std::size_t>(step)] =
          static_cast<std::uint8_t>(std::lround(255.0 * (black + (1.0 - black) * root)));
    }
    return of;
  }();
  const std::array<int, 256>& exposures = Exposures();
  const int squares = times * times;
  cv::Mat mean(image.rows / times, image.cols / times, CV_8UC3);
  std::vector<int> sums(static_cast<std::size_t>(3 * mean.cols));
  for (int row = 0; row < mean.rows; ++row) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int line = 0; line < times; ++line) {
      const std::uint8_t* from = image.ptr<std::uint8_t>(times * row + line);
      for (std::size_t at = 0; at < sums.size(); at += 3) {
        for (int point = 0; point < times; ++point, from += 3) {
          for (std::size_t c = 0; c < 3; ++c) sums[at + c] += exposures[from[c]];
        }
      }
    }
    auto* to = mean.ptr<std::uint8_t>(row);
    for (std::size_t at = 0; at < sums.size(); ++at)
      to[at] = levels[static_cast<std::size_t>((sums[at] + squares / 2) / squares)];
  }
  return mean;
}

cv::Mat FineDrawing(sim::Renderer& renderer, const sim::CameraView& view, const sim::Lamps& lamps) {
  sim::CameraView fine = view;
  fine.width_px *= kFineness;
  fine.height_px *= kFineness;
  fine.focal_px *= kFineness;
  // Whole numbers are middles of pixels.
  fine.center_x_px = kFineness * (view.center_x_px + 0.5) - 0.5;
  fine.center_y_px = kFineness * (view.center_y_px + 0.5) - 0.5;
  return MeanLight(renderer.Render(fine, lamps), kFineness);
}

}  // namespace kantaro::scenarios
