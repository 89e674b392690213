#include "perception/repetition.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace kantaro::perception {
namespace {

template <typename Value>
robot::Reading At(int ms, Value value) {
  return {std::chrono::milliseconds(ms), std::chrono::milliseconds(ms), std::move(value)};
}

TEST(Repetition, CountsEqualReadingsInARow) {
  Repetition repetition(3);
  EXPECT_FALSE(repetition.IsStuck(At(0, robot::IrRanges{{0.5}, {0.4}, {0.3}})));
  EXPECT_FALSE(repetition.IsStuck(At(1, robot::IrRanges{{0.5}, {0.4}, {0.3}})));
  EXPECT_TRUE(repetition.IsStuck(At(2, robot::IrRanges{{0.5}, {0.4}, {0.3}})));
  EXPECT_TRUE(repetition.IsStuck(At(3, robot::IrRanges{{0.5}, {0.4}, {0.3}})));
  EXPECT_FALSE(repetition.IsStuck(At(4, robot::IrRanges{{0.5}, {0.41}, {0.3}})));
}

TEST(Repetition, LooksAtEachSensorByItself) {
  Repetition repetition(2);
  const robot::Reading leaning = At(0, robot::Inclination{0.1, 0.2});
  EXPECT_FALSE(repetition.IsStuck(leaning));
  EXPECT_FALSE(repetition.IsStuck(At(0, robot::InertialReading{})));
  EXPECT_TRUE(repetition.IsStuck(leaning));
}

TEST(Repetition, ComparesImagesPixelByPixel) {
  Repetition repetition(2);
  cv::Mat image(4, 4, CV_8UC1, cv::Scalar(7));
  EXPECT_FALSE(repetition.IsStuck(At(0, robot::FrontImage{image})));
  EXPECT_TRUE(repetition.IsStuck(At(1, robot::FrontImage{image.clone()})));
  cv::Mat other = image.clone();
  other.at<unsigned char>(3, 3) = 8;
  EXPECT_FALSE(repetition.IsStuck(At(2, robot::FrontImage{other})));
}

TEST(Repetition, LetsStandingWheelsAndABatteryRepeatThemselves) {
  Repetition repetition(2);
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(repetition.IsStuck(At(i, robot::WheelEncoders{})));
    EXPECT_FALSE(repetition.IsStuck(At(i, robot::BatteryState{12.0, 1.0, 0.5})));
    EXPECT_FALSE(repetition.IsStuck(At(i, robot::CompassHeading{})));
    EXPECT_FALSE(repetition.IsStuck(At(i, robot::LaserRevolution{})));  // nothing was said
  }
}

TEST(Repetition, NeedsTwo) { EXPECT_THROW(Repetition(1), std::invalid_argument); }

}  // namespace
}  // namespace kantaro::perception
