#include "perception/stereo/interpolation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "tests/perception/stereo/stereo_pair.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
const cv::Size kSize{61, 44};  // 8 + 1 by 6 + 1 corners; no side a multiple of 8

cv::Mat Corners(const std::function<double(double x, double y)>& value) {
  cv::Mat corners(CornersAlong(kSize.height), CornersAlong(kSize.width), CV_32F);
  for (int y = 0; y < corners.rows; ++y) {
    for (int x = 0; x < corners.cols; ++x)
      corners.at<float>(y, x) = static_cast<float>(value(8.0 * x, 8.0 * y));
  }
  return corners;
}

/// The largest error over pixels at least `margin` blocks inside the outermost corners.
double LargestError(const cv::Mat& pixels, const std::function<double(double x, double y)>& value,
                    int margin) {
  double largest = 0;
  for (int y = 8 * margin;
       y < std::min(kSize.height, 8 * (CornersAlong(kSize.height) - 1 - margin)); ++y) {
    for (int x = 8 * margin;
         x < std::min(kSize.width, 8 * (CornersAlong(kSize.width) - 1 - margin)); ++x)
      largest = std::max(largest, std::abs(pixels.at<float>(y, x) - value(x, y)));
  }
  return largest;
}

TEST(KeysKernel, HasTheSlopeOfItsDifferences) {
  constexpr double kSmall = 1e-6;
  for (const double d : {-2.5, -1.6, -1.1, -1.0, -0.4, 0.0, 0.3, 1.0, 1.2, 1.7, 2.0})
    EXPECT_NEAR(KeysKernelSlope(d), (KeysKernel(d + kSmall) - KeysKernel(d - kSmall)) / 2 / kSmall,
                5e-6)
        << d;
}

// By hand: 1.5 / 8 − 2.5 / 4 + 1 = 0.5625 and −0.5 · 3.375 + 2.5 · 2.25 − 6 + 2 = −0.0625.
TEST(KeysKernel, HasTheValuesWorkedOutByHand) {
  EXPECT_DOUBLE_EQ(KeysKernel(0), 1);
  EXPECT_DOUBLE_EQ(KeysKernel(0.5), 0.5625);
  EXPECT_DOUBLE_EQ(KeysKernel(-0.5), 0.5625);
  EXPECT_DOUBLE_EQ(KeysKernel(1), 0);
  EXPECT_DOUBLE_EQ(KeysKernel(1.5), -0.0625);
  EXPECT_DOUBLE_EQ(KeysKernel(2), 0);
  EXPECT_DOUBLE_EQ(KeysKernel(2.5), 0);
}

// The thesis' example, fig 5.16: seven tenths of a block from the second corner.
TEST(KeysKernel, GivesTheWeightsOfTheThesisExample) {
  EXPECT_NEAR(KeysKernel(1.7), -0.0315, 1e-12);
  EXPECT_NEAR(KeysKernel(0.7), 0.2895, 1e-12);
  EXPECT_NEAR(KeysKernel(-0.3), 0.8155, 1e-12);
  EXPECT_NEAR(KeysKernel(-1.3), -0.0735, 1e-12);
}

TEST(KeysKernel, HasWeightsThatSumToOne) {
  for (double t = 0; t < 1; t += 0.01)
    EXPECT_NEAR(KeysKernel(1 + t) + KeysKernel(t) + KeysKernel(1 - t) + KeysKernel(2 - t), 1,
                1e-12);
}

TEST(Interpolation, HasACornerEveryEightPixelsAndOneBeyondTheEnd) {
  EXPECT_EQ(CornersAlong(640), 81);  // the thesis' d_s(640, ·)
  EXPECT_EQ(CornersAlong(480), 61);
  EXPECT_EQ(CornersAlong(641), 82);
  EXPECT_EQ(CornersAlong(7), 2);
}

TEST(Interpolation, OfEveryKindReturnsTheCornersThemselves) {
  const auto value = [](double x, double y) { return std::fmod(7.0 * x + 13.0 * y, 29.0); };
  for (const auto kind : {Interpolation::kNearest, Interpolation::kLinear, Interpolation::kCubic}) {
    const cv::Mat pixels = Interpolate(Corners(value), kSize, kind);
    ASSERT_EQ(pixels.size(), kSize);
    for (int y = 0; y < kSize.height; y += 8) {
      for (int x = 0; x < kSize.width; x += 8)
        EXPECT_FLOAT_EQ(pixels.at<float>(y, x), static_cast<float>(value(x, y)));
    }
  }
}

TEST(NearestInterpolation, TakesTheNearestCorner) {
  const cv::Mat corners = Corners([](double x, double y) { return x + 100 * y; });
  const cv::Mat pixels = Interpolate(corners, kSize, Interpolation::kNearest);
  EXPECT_EQ(pixels.at<float>(3, 3), 0);
  EXPECT_EQ(pixels.at<float>(4, 4), 0);  // half way: the earlier one
  EXPECT_EQ(pixels.at<float>(5, 5), 808);
  EXPECT_EQ(pixels.at<float>(43, 60), 56 + 100 * 40);
}

TEST(LinearInterpolation, IsExactOnPlanes) {
  const auto plane = [](double x, double y) { return 20 + 0.3 * x - 0.1 * y; };
  EXPECT_LT(LargestError(Interpolate(Corners(plane), kSize, Interpolation::kLinear), plane, 0),
            1e-5);
}

// Keys 1981: a = −1/2 makes it exact on parabolas.
TEST(CubicInterpolation, IsExactOnParabolas) {
  const auto bowl = [](double x, double y) { return 20 + 0.01 * x * x - 0.02 * x * y + 0.3 * y; };
  EXPECT_LT(LargestError(Interpolate(Corners(bowl), kSize, Interpolation::kCubic), bowl, 1), 1e-4);
  EXPECT_GT(LargestError(Interpolate(Corners(bowl), kSize, Interpolation::kLinear), bowl, 1), 0.1);
}

// The order of fig 5.21 on what a pipe's wall is: a smooth curve.
TEST(CubicInterpolation, FollowsACurveBetterThanLinearAndLinearBetterThanNearest) {
  const auto wall = [](double x, double y) { return 30 + 8 * std::sin(x / 9) * std::cos(y / 11); };
  const auto error = [&](Interpolation kind) {
    return LargestError(Interpolate(Corners(wall), kSize, kind), wall, 1);
  };
  EXPECT_LT(error(Interpolation::kCubic), 0.5 * error(Interpolation::kLinear));
  EXPECT_LT(error(Interpolation::kLinear), 0.5 * error(Interpolation::kNearest));
}

// Eq. 5.15 and 5.16 for one pixel, with the corner before the first one repeated.
TEST(CubicInterpolation, RepeatsTheBorder) {
  const cv::Mat corners = Corners([](double x, double) { return x * x; });
  const cv::Mat pixels = Interpolate(corners, kSize, Interpolation::kCubic);
  // Half way between 0 and 64, beside 0 (repeated) and 256.
  EXPECT_FLOAT_EQ(pixels.at<float>(20, 4), 0.5625F * (0 + 64) - 0.0625F * (0 + 256));
}

TEST(Interpolation, FallsBackNearACornerWithoutDisparity) {
  const auto curve = [](double x, double y) { return 10 + 0.02 * x * x + 0.01 * y * y; };
  cv::Mat corners = Corners(curve);
  corners.at<float>(3, 4) = kNaN;  // at pixel (32, 24)
  const cv::Mat pixels = Interpolate(corners, kSize, Interpolation::kCubic);
  const cv::Mat linear = Interpolate(corners, kSize, Interpolation::kLinear);
  const auto nearest = [&](int x, int y) { return corners.at<float>((y + 3) / 8, (x + 3) / 8); };
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const int blocks_x = x < 32 ? (31 - x) / 8 : (x - 32) / 8;
      const int blocks_y = y < 24 ? (23 - y) / 8 : (y - 24) / 8;
      const int blocks = std::max(blocks_x, blocks_y);
      const float pixel = pixels.at<float>(y, x);
      if (blocks == 0) {
        EXPECT_TRUE(pixel == nearest(x, y) || (std::isnan(pixel) && std::isnan(nearest(x, y))))
            << x << ", " << y;
      } else if (blocks == 1) {
        EXPECT_EQ(pixel, linear.at<float>(y, x)) << x << ", " << y;
      } else {
        EXPECT_FALSE(std::isnan(pixel));
      }
    }
  }
}

TEST(Interpolation, OfNothingIsNothing) {
  for (const auto kind : {Interpolation::kNearest, Interpolation::kLinear, Interpolation::kCubic}) {
    const cv::Mat pixels = Interpolate(Corners([](double, double) { return kNaN; }), kSize, kind);
    EXPECT_EQ(CountDisparities({pixels}), 0);
  }
}

TEST(Interpolation, RefusesCornersThatDoNotFit) {
  EXPECT_THROW((void)Interpolate(cv::Mat(7, 8, CV_32F), kSize, Interpolation::kCubic),
               std::invalid_argument);
  EXPECT_THROW((void)Interpolate(cv::Mat(7, 9, CV_64F), kSize, Interpolation::kCubic),
               std::invalid_argument);
  EXPECT_THROW((void)Interpolate({}, {0, 0}, Interpolation::kCubic), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception::stereo
