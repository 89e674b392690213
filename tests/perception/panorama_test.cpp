#include "perception/panorama.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace kantaro::perception {
namespace {

// Four dots at 3, 6, 9 and 12 o'clock land at the quarters of the panorama's width.
TEST(UnrollRing, RunsClockwiseFromTheCrown) {
  cv::Mat image = cv::Mat::zeros(401, 401, CV_8UC1);
  const cv::Point middle(200, 200);
  const auto dot = [&](cv::Point off, int level) { cv::circle(image, middle + off, 3, level, -1); };
  dot({0, -120}, 50);
  dot({120, 0}, 100);
  dot({0, 120}, 150);
  dot({-120, 0}, 200);
  const cv::Mat panorama = UnrollRing(image, {{200, 200}, 100, 150}, {942, 50});
  ASSERT_EQ(panorama.size(), cv::Size(942, 50));
  const int row = 30;  // 150 − 30 = 120 px
  EXPECT_EQ(panorama.at<std::uint8_t>(row, 0), 50);
  EXPECT_NEAR(panorama.at<std::uint8_t>(row, 235), 100, 2);  // 942 / 4 = 235.5
  EXPECT_EQ(panorama.at<std::uint8_t>(row, 471), 150);
  EXPECT_NEAR(panorama.at<std::uint8_t>(row, 706), 200, 2);
}

TEST(UnrollRing, StartsAtTheOuterCircle) {
  cv::Mat image = cv::Mat::zeros(401, 401, CV_8UC1);
  cv::circle(image, {200, 200}, 125, 200, -1);  // bright inside 125 px
  const cv::Mat panorama = UnrollRing(image, {{200, 200}, 100, 150}, {942, 50});
  EXPECT_EQ(panorama.at<std::uint8_t>(0, 400), 0);
  EXPECT_EQ(panorama.at<std::uint8_t>(22, 400), 0);
  EXPECT_EQ(panorama.at<std::uint8_t>(27, 400), 200);
  EXPECT_EQ(panorama.at<std::uint8_t>(49, 400), 200);
}

TEST(UnrollRing, RefusesARingThatLeavesTheImage) {
  const cv::Mat image = cv::Mat::zeros(401, 401, CV_8UC1);
  EXPECT_THROW((void)UnrollRing(image, {{200, 200}, 100, 201}, {942, 50}), std::invalid_argument);
  EXPECT_THROW((void)UnrollRing(image, {{140, 200}, 100, 150}, {942, 50}), std::invalid_argument);
  EXPECT_THROW((void)UnrollRing(image, {{200, 200}, 150, 100}, {942, 50}), std::invalid_argument);
  EXPECT_THROW((void)UnrollRing(image, {{200, 200}, 0, 100}, {942, 50}), std::invalid_argument);
}

TEST(UnrollRing, RefusesColour) {
  EXPECT_THROW((void)UnrollRing(cv::Mat(401, 401, CV_8UC3), {{200, 200}, 100, 150}, {942, 50}),
               std::invalid_argument);
}

TEST(FitInside, MovesARingNoFartherThanNeeded) {
  const Ring ring = FitInside({{10, 300}, 50, 100}, {640, 480});
  EXPECT_DOUBLE_EQ(ring.center_px.x, 100);
  EXPECT_DOUBLE_EQ(ring.center_px.y, 300);
  EXPECT_NO_THROW((void)UnrollRing(cv::Mat::zeros(480, 640, CV_8UC1), ring, {942, 50}));
  EXPECT_THROW((void)FitInside({{320, 240}, 50, 240}, {640, 480}), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
