// What EncodePng makes of an image, as read by OpenCV's libpng.
#include "robot/recording/png.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/random.hpp"

namespace kantaro::robot {
namespace {

void ExpectReadsBack(const cv::Mat& image) {
  const cv::Mat back = cv::imdecode(EncodePng(image), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(back.size(), image.size());
  ASSERT_EQ(back.type(), CV_8UC3);
  EXPECT_EQ(cv::norm(back, image, cv::NORM_INF), 0.0) << image.size();
}

cv::Mat Noise(cv::Size size, double deviation) {
  RandomStream random(1, "png");
  cv::Mat image(size, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < 3 * image.cols; ++x)
      image.ptr(y)[x] = cv::saturate_cast<std::uint8_t>(100.0 + random.Normal(deviation));
  }
  return image;
}

TEST(EncodePng, LosesNothing) {
  for (const cv::Size size : {cv::Size(704, 480), cv::Size(640, 33), cv::Size(1, 1),
                              cv::Size(1, 100), cv::Size(7, 32), cv::Size(300, 1)}) {
    ExpectReadsBack(Noise(size, 3.0));
    ExpectReadsBack(Noise(size, 90.0));
    ExpectReadsBack(cv::Mat(size, CV_8UC3, cv::Scalar(7, 0, 255)));
  }
}

TEST(EncodePng, TakesAPartOfAnImage) { ExpectReadsBack(Noise({90, 60}, 20.0)({10, 5, 70, 50})); }

// White noise of deviation s has log2(s √(2πe)) bits a byte. The mean of two neighbours has half of
// its variance, so what is left has 1.5 of it: 3.92 bits for s = 3. A seventh more is allowed for
// speed.
TEST(EncodePng, NeedsLittleMoreThanTheNoiseItself) {
  const cv::Mat image = Noise({640, 480}, 3.0);
  const double bits =
      8.0 * static_cast<double>(EncodePng(image).size()) / static_cast<double>(3 * image.total());
  EXPECT_GT(bits, 3.9);
  EXPECT_LT(bits, 4.48);
}

TEST(EncodePng, RefusesWhatIsNoColourPicture) {
  EXPECT_THROW((void)EncodePng({}), std::invalid_argument);
  EXPECT_THROW((void)EncodePng(cv::Mat(4, 4, CV_8U)), std::invalid_argument);
  EXPECT_THROW((void)EncodePng(cv::Mat(4, 4, CV_16UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::robot
