#include "perception/brightness.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <stdexcept>

namespace kantaro::perception {
namespace {

TEST(Brightness, WeighsRedGreenAndBlueAsEquation32) {
  const cv::Mat image(3, 4, CV_8UC3, cv::Scalar(/*B=*/10, /*G=*/100, /*R=*/200));
  const cv::Mat brightness = Brightness(image);
  ASSERT_EQ(brightness.type(), CV_8UC1);
  EXPECT_EQ(brightness.size(), image.size());
  EXPECT_EQ(brightness.at<std::uint8_t>(2, 3), 121);  // 0.3·200 + 0.6·100 + 0.1·10
}

TEST(Brightness, KeepsWhiteWhite) {
  EXPECT_EQ(Brightness(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(255))).at<std::uint8_t>(0), 255);
}

TEST(Brightness, RefusesOtherTypesAndEmptyImages) {
  EXPECT_THROW((void)Brightness(cv::Mat()), std::invalid_argument);
  EXPECT_THROW((void)Brightness(cv::Mat(2, 2, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW((void)Brightness(cv::Mat(2, 2, CV_16UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
