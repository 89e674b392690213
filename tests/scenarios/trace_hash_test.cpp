#include "scenarios/trace_hash.hpp"

#include <gtest/gtest.h>

namespace kantaro::scenarios {
namespace {

std::string HashOf(const robot::Reading& reading) {
  TraceHash hash;
  hash.Add(reading);
  return hash.HexDigest();
}

robot::Reading Image(const cv::Mat& image) {
  return {robot::RunTime(5), robot::RunTime(6), robot::FrontImage{image}};
}

TEST(TraceHash, CoversEveryPixel) {
  cv::Mat image(4, 5, CV_8UC3, cv::Scalar(1, 2, 3));
  const std::string before = HashOf(Image(image));
  EXPECT_EQ(HashOf(Image(image.clone())), before);
  image.at<cv::Vec3b>(3, 4)[2] = 4;
  EXPECT_NE(HashOf(Image(image)), before);
}

TEST(TraceHash, CoversThePixelsOfAViewAlone) {
  const cv::Mat image(4, 5, CV_8UC3, cv::Scalar(1, 2, 3));
  const cv::Mat view = image(cv::Rect(1, 1, 3, 2));
  EXPECT_EQ(HashOf(Image(view)), HashOf(Image(view.clone())));
}

TEST(TraceHash, CoversTimesAndKinds) {
  robot::Reading encoders{robot::RunTime(5), robot::RunTime(5), robot::WheelEncoders()};
  const std::string before = HashOf(encoders);
  encoders.captured_at = robot::RunTime(6);
  EXPECT_NE(HashOf(encoders), before);
}

TEST(TraceHash, CoversTheOrder) {
  TraceHash one, other;
  one.Add(robot::Command{1.0, 1.0, 1.0});
  one.Add(robot::Command{2.0, 1.0, 1.0});
  other.Add(robot::Command{2.0, 1.0, 1.0});
  other.Add(robot::Command{1.0, 1.0, 1.0});
  EXPECT_NE(one.HexDigest(), other.HexDigest());
}

}  // namespace
}  // namespace kantaro::scenarios
