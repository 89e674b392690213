#include "robot/flat_field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>

namespace kantaro::robot {
namespace {

const Eigen::Matrix3d kStraight = Eigen::Matrix3d::Identity();

/// 60 degrees across, without distortion.
Camera Pinhole() {
  Camera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.focal_px = 554.0;
  camera.center_x_px = 319.5;
  camera.center_y_px = 239.5;
  return camera;
}

cv::Mat Even(int level) { return {480, 640, CV_8U, cv::Scalar(level)}; }

// cos of the angle is 1 / √(1 + (r / f)²), and a fourth of the light makes 0.25^(1/2.2) of a level.
TEST(FlatField, ShowsAnEvenWallEvenly) {
  cv::Mat wall = Even(0);
  for (int y = 0; y < wall.rows; ++y) {
    for (int x = 0; x < wall.cols; ++x) {
      const double tangent2 = (std::pow(x - 319.5, 2) + std::pow(y - 239.5, 2)) / (554.0 * 554.0);
      wall.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
          std::lround(180.0 * std::pow(std::pow(1.0 + tangent2, -2.0), 1.0 / 2.2)));
    }
  }
  ASSERT_LT(wall.at<std::uint8_t>(0, 0), 140);
  const cv::Mat flat = FlatField(Pinhole(), kStraight).Flatten(wall);
  double least = 0, most = 0;
  cv::minMaxLoc(flat, &least, &most);
  EXPECT_GE(least, 179);
  EXPECT_LE(most, 181);
}

// Askew by 0.1 rad the axis pierces the rectified picture 554 tan 0.1 = 55.6 px beside its middle.
TEST(FlatField, KnowsWhereTheAxisIsInTheRectifiedPicture) {
  const Eigen::Matrix3d R_RC(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  const cv::Mat flat = FlatField(Pinhole(), R_RC).Flatten(Even(100));
  EXPECT_EQ(flat.at<std::uint8_t>(240, 375), 100);
  // At 0.35 rad from the axis on either side: 100 cos^(-4/2.2) 0.35 = 112.0.
  EXPECT_NEAR(flat.at<std::uint8_t>(240, std::lround(319.5 + 554.0 * std::tan(0.45))), 112.0, 1.0);
  EXPECT_NEAR(flat.at<std::uint8_t>(240, std::lround(319.5 + 554.0 * std::tan(-0.25))), 112.0, 1.0);
}

// Half a diagonal from the lens' centre 1 − 0.4 of the light: 100 · 0.6^(−1/2.2) = 126.1.
TEST(FlatField, TakesAMeasuredFalloff) {
  Camera camera = Pinhole();
  camera.sensor.vignetting = {-0.4, 0.0, 0.0};
  const cv::Mat flat = FlatField(camera, kStraight).Flatten(Even(100));
  EXPECT_EQ(flat.at<std::uint8_t>(240, 320), 100);
  for (const cv::Point corner : {cv::Point(0, 0), {639, 0}, {0, 479}, {639, 479}})
    EXPECT_NEAR(flat.at<std::uint8_t>(corner), 126.1, 1.0);
}

TEST(FlatField, StaysWhiteWhereThePictureIs) {
  const cv::Mat flat = FlatField(Pinhole(), kStraight).Flatten(Even(250));
  EXPECT_EQ(flat.at<std::uint8_t>(240, 320), 250);
  EXPECT_EQ(flat.at<std::uint8_t>(0, 0), 255);
}

TEST(FlatField, RefusesPicturesOfAnotherSizeOrType) {
  const FlatField field(Pinhole(), kStraight);
  EXPECT_THROW((void)field.Flatten(cv::Mat(480, 641, CV_8U)), std::invalid_argument);
  EXPECT_THROW((void)field.Flatten(cv::Mat(480, 640, CV_8UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::robot
