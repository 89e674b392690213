#include "tests/perception/stereo/stereo_pair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "base/random.hpp"

namespace kantaro::perception::stereo {
namespace {

cv::Mat Draw(cv::Size size, RandomStream& random, std::uint64_t levels, int step) {
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x)
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(step * static_cast<int>(random.Index(levels)));
  }
  return image;
}

/// A sum of waves no shorter than 7 px.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) {
    RandomStream random(seed, "texture");
    for (int i = 0; i < 40; ++i) {
      waves_.push_back({random.Uniform(-0.6, 0.6), random.Uniform(-0.6, 0.6),
                        random.Uniform(0.0, 2.0 * std::numbers::pi)});
    }
  }
  [[nodiscard]] std::uint8_t At(double x, double y) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::sin(wave.x * x + wave.y * y + wave.phase);
    return static_cast<std::uint8_t>(std::lround(std::clamp(128.0 + 10.0 * sum, 0.0, 255.0)));
  }

 private:
  struct Wave {
    double x, y, phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace

Pair Noise(cv::Size size, std::uint64_t seed) {
  RandomStream random(seed, "noise");
  cv::Mat left = Draw(size, random, 256, 1);
  return {left, Draw(size, random, 256, 1)};
}

Pair CoarseNoise(cv::Size size, std::uint64_t seed) {
  RandomStream random(seed, "coarse noise");
  cv::Mat left = Draw(size, random, 4, 7);
  return {left, Draw(size, random, 4, 7)};
}

Pair Surface(cv::Size size, const std::function<double(int x, int y)>& disparity,
             std::uint64_t seed) {
  const Texture texture(seed);
  Pair pair{cv::Mat(size, CV_8U), cv::Mat(size, CV_8U)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      pair.left.at<std::uint8_t>(y, x) = texture.At(x - disparity(x, y), y);
      pair.right.at<std::uint8_t>(y, x) = texture.At(x, y);
    }
  }
  return pair;
}

Parameters Small(Method method) {
  Parameters parameters;
  parameters.method = method;
  parameters.gaussian_window_px = 1;
  parameters.min_disparity_px = 2;
  parameters.disparities = 11;
  parameters.window_px = 5;
  parameters.least_deviation = 0;
  return parameters;
}

double ShareWithin(const DisparityMap& map, cv::Rect region,
                   const std::function<double(int x, int y)>& expected, double tolerance) {
  int within = 0;
  for (int y = region.y; y < region.y + region.height; ++y) {
    for (int x = region.x; x < region.x + region.width; ++x)
      within += std::abs(map.disparity_px.at<float>(y, x) - expected(x, y)) <= tolerance ? 1 : 0;
  }
  return static_cast<double>(within) / region.area();
}

int CountDisparities(const DisparityMap& map) {
  return cv::countNonZero(map.disparity_px == map.disparity_px);
}

void ExpectSame(const cv::Mat& actual, const cv::Mat& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  ASSERT_EQ(actual.type(), CV_32F);
  for (int y = 0; y < actual.rows; ++y) {
    for (int x = 0; x < actual.cols; ++x) {
      const float a = actual.at<float>(y, x), e = expected.at<float>(y, x);
      if (std::isnan(a) && std::isnan(e)) continue;
      ASSERT_EQ(a, e) << "at " << x << ", " << y;
    }
  }
}

}  // namespace kantaro::perception::stereo
