#include "scenarios/experiments/stereo_methods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/input_error.hpp"
#include "base/random.hpp"

namespace kantaro::scenarios {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

perception::stereo::Parameters From(int min_disparity_px) {
  perception::stereo::Parameters parameters;
  parameters.min_disparity_px = min_disparity_px;
  parameters.disparities = 32;
  return parameters;
}

// Six pixels: right, off by exactly 1, by 1.5, by 3, no answer, no truth; and one that does not
// count.
TEST(BadPixels, AreThoseTooFarOffAndThoseWithoutAnswer) {
  const cv::Mat truth = (cv::Mat_<float>(1, 7) << 10, 10, 10, 10, 10, kNaN, 10);
  const cv::Mat found = (cv::Mat_<float>(1, 7) << 10, 11, 8.5, 13, kNaN, 10, 40);
  const cv::Mat region = (cv::Mat_<std::uint8_t>(1, 7) << 255, 255, 255, 255, 255, 255, 0);
  const BadPixels bad = CountBadPixels(found, truth, region);
  EXPECT_EQ(bad.pixels, 5u);
  EXPECT_EQ(bad.answered, 4u);
  EXPECT_EQ(bad.off_1px, 3u);
  EXPECT_EQ(bad.off_2px, 2u);
  EXPECT_DOUBLE_EQ(bad.error_px, (0 + 1 + 1.5 + 3) / 4);
  EXPECT_THROW((void)CountBadPixels(found, truth, truth), std::invalid_argument);
  EXPECT_THROW((void)CountBadPixels(found.colRange(0, 3), truth, region), std::invalid_argument);
}

// OpenCV counts in sixteenths from a least disparity; here it speaks as ours do.
TEST(StereoMethods, OfOpenCvAndOursAgreeOnAKnownShift) {
  RandomStream random(1, "stereo methods");
  cv::Mat wall(96, 240, CV_8U);
  for (std::uint8_t& pixel : cv::Mat_<std::uint8_t>(wall))
    pixel = static_cast<std::uint8_t>(random.Index(256));
  cv::GaussianBlur(wall, wall, {5, 5}, 1.0);
  const cv::Mat left = wall.colRange(0, 200), right = wall.colRange(21, 221);
  const cv::Mat truth(left.size(), CV_32F, cv::Scalar(21));
  cv::Mat region(left.size(), CV_8U, cv::Scalar(0));
  region(cv::Rect(70, 16, 110, 64)).setTo(255);
  for (const StereoMethod& method : StereoMethods(From(8))) {
    if (method.name == "lc") continue;  // single pixels tie
    const cv::Mat disparity = method.match(left, right);
    const BadPixels bad = CountBadPixels(disparity, truth, region);
    EXPECT_LT(bad.off_1px, bad.pixels / 20) << method.name;
    EXPECT_LT(bad.error_px, 0.3) << method.name;
    EXPECT_TRUE(std::isnan(disparity.at<float>(48, 5))) << method.name;
  }
}

TEST(StereoMethods, AreChosenByName) {
  EXPECT_EQ(ChosenMethods(StereoMethods(From(0)), {}).size(), 12u);
  const auto chosen = ChosenMethods(StereoMethods(From(0)), {"stereobm", "lc"});
  ASSERT_EQ(chosen.size(), 2u);
  EXPECT_EQ(chosen[0].name, "lc");
  EXPECT_EQ(chosen[1].name, "stereobm");
  EXPECT_THROW((void)ChosenMethods(StereoMethods(From(0)), {"census"}), InputError);
}

}  // namespace
}  // namespace kantaro::scenarios
