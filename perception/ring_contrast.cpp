#include "perception/ring_contrast.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::perception {
namespace {

constexpr int kReach = kStepReach_px;
constexpr double kDarkFloor = 4.0;  // grey levels added before the logarithm: tames dark noise

}  // namespace

const Groups& AllRound() {
  static const Groups groups = [] {
    Groups result(1);
    for (int t = 0; t < kDirections; ++t) result[0].push_back(t);
    return result;
  }();
  return groups;
}

const Groups& CrownAndShoulders() {
  static const Groups groups = [] {
    Groups result(3);
    for (int off = -34; off <= 34; ++off) {
      result[std::abs(off) <= 18 ? 0
             : off > 0           ? 1
                                 : 2]
          .push_back((off + kDirections) % kDirections);
    }
    return result;
  }();
  return groups;
}

cv::Mat LogBrightness(const cv::Mat& brightness) {
  cv::Mat table(1, 256, CV_32F), result;
  for (int level = 0; level < 256; ++level) {
    table.at<float>(level) = static_cast<float>(std::log(level + kDarkFloor));
  }
  cv::LUT(brightness, table, result);
  return result;
}

Contrasts Measure(const Polar& polar, const Optics& optics, float largest_line,
                  float largest_step) {
  Contrasts contrasts{cv::Mat::zeros(polar.value.size(), CV_32F),
                      cv::Mat::zeros(polar.value.size(), CV_32F)};
  std::vector<float> sums(static_cast<std::size_t>(polar.columns()) + 1);
  for (int t = 0; t < kDirections; ++t) {
    const float* value = polar.value.ptr<float>(t);
    float* line = contrasts.line.ptr<float>(t);
    float* step = contrasts.step.ptr<float>(t);
    for (int k = 0; k < polar.columns(); ++k) sums[k + 1] = sums[k] + value[k];
    const auto mean = [&](int from, int to) {
      return (sums[to + 1] - sums[from]) / static_cast<float>(to - from + 1);
    };
    for (int k = kReach; k < polar.columns() - kReach; ++k) {
      if (!polar.Visible(t, k)) continue;
      const int flank = optics.LineFlank(polar.first_px + k), half = (flank - 1) / 2;
      line[k] = std::clamp(mean(k - half, k + half) - (value[k - flank] + value[k + flank]) / 2,
                           -largest_line, largest_line);
      // Inner and outer pairs of means, 5 and 17 px apart: their weighted difference answers to a
      // step and not to the fall of brightness along the pipe.
      const float near_pair = mean(k + 1, k + 4) - mean(k - 4, k - 1);
      const float far_pair = mean(k + 5, k + kReach) - mean(k - kReach, k - 5);
      step[k] = std::clamp((17 * near_pair - 5 * far_pair) / 12, -largest_step, largest_step);
    }
  }
  return contrasts;
}

std::vector<int> CountVisible(const Polar& polar, const Groups& groups) {
  std::vector<int> counts(static_cast<std::size_t>(polar.columns()));
  for (const auto& group : groups) {
    for (const int t : group) {
      for (int k = 0; k < polar.columns(); ++k) counts[k] += polar.Visible(t, k);
    }
  }
  return counts;
}

}  // namespace kantaro::perception
