#include "scenarios/experiments/image_statistics.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kantaro::scenarios {
namespace {

cv::Mat Plain(int level) { return {kStatisticsSize, CV_8UC3, cv::Scalar::all(level)}; }

// All the earth lies in one bin and is carried three bins of 0.5.
TEST(WassersteinDistance, IsTheWayThatAHeapIsCarried) {
  const std::array<double, 5> a{1.0, 0.0, 0.0, 0.0, 0.0}, b{0.0, 0.0, 0.0, 1.0, 0.0};
  EXPECT_DOUBLE_EQ(WassersteinDistance(a, b, 0.5), 1.5);
  EXPECT_DOUBLE_EQ(WassersteinDistance(a, a, 0.5), 0.0);
}

// On a circle of five bins the fourth is two away from the first, not three.
TEST(CircularWassersteinDistance, TakesTheShorterWayRound) {
  const std::array<double, 5> a{1.0, 0.0, 0.0, 0.0, 0.0}, b{0.0, 0.0, 0.0, 1.0, 0.0};
  EXPECT_DOUBLE_EQ(CircularWassersteinDistance(a, b, 72.0), 144.0);
}

// Grey grows by 1 level a pixel from the middle: its profile is the radius, its gradient 1.
TEST(StatisticsOf, SeesACone) {
  cv::Mat cone = Plain(0);
  for (int row = 0; row < cone.rows; ++row) {
    for (int col = 0; col < cone.cols; ++col) {
      const double radius_px = std::hypot(col - 176, row - 144);
      cone.at<cv::Vec3b>(row, col) = cv::Vec3b::all(cv::saturate_cast<std::uint8_t>(radius_px));
    }
  }
  const ImageStatistics s = StatisticsOf({cone, {}});
  for (const std::size_t k : {4u, 8u, 15u})
    EXPECT_NEAR(s.radial[k], kRadialStep_px * (static_cast<double>(k) + 0.5), 1.5) << k;
  EXPECT_GT(s.gradient[1] + s.gradient[2], 0.9);  // 0.5 … 1.5 levels/px
  EXPECT_GT(s.saturation[0], 0.999);
}

// A ring of 150 on a wall of 100: log(158 / 108) = 0.38, whichever way the sectors look.
TEST(JointContrasts, AreThoseOfARing) {
  for (const int level : {150, 60}) {
    cv::Mat wall = Plain(100);
    cv::circle(wall, {180, 144}, 70, cv::Scalar::all(level), 3);
    const auto contrasts = JointContrasts({wall, {{110.0, 74.0, 140.0, 140.0}}});
    ASSERT_GT(contrasts.size(), 12u);
    for (const double contrast : contrasts)
      EXPECT_NEAR(contrast, std::log((level + 8.0) / 108.0), 0.06);
  }
}

TEST(JointContrasts, LeaveOutBoxesThatTheFrameCuts) {
  EXPECT_TRUE(JointContrasts({Plain(100), {{-20.0, 20.0, 200.0, 200.0}}}).empty());
}

// White noise of deviation 5 has the power 25 at every frequency, times the mean square of the
// window. OpenCV's is the root of Hann's in two dimensions, and the sum of Hann's over 64 samples
// is 63 / 2. Rounding to whole levels adds 1/12.
TEST(StatisticsOf, FindsWhiteNoiseFlat) {
  cv::Mat grey(kStatisticsSize, CV_8U), noisy;
  cv::RNG random(1);
  random.fill(grey, cv::RNG::NORMAL, 128, 5);
  cv::cvtColor(grey, noisy, cv::COLOR_GRAY2BGR);
  const double expected_dB = 10.0 * std::log10((25.0 + 1.0 / 12.0) * std::pow(63.0 / 128.0, 2.0));
  const ImageStatistics s = StatisticsOf({noisy, {}});
  for (std::size_t k = 3; k < s.spectrum_dB.size(); ++k)
    EXPECT_NEAR(s.spectrum_dB[k], expected_dB, 0.5) << k;
}

TEST(StatisticsOf, RefusesAnotherSize) {
  EXPECT_THROW(static_cast<void>(StatisticsOf({cv::Mat(10, 10, CV_8UC3), {}})),
               std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::scenarios
