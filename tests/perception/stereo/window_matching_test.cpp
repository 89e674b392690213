// The conventional methods against sums by hand, pixel by pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "tests/perception/stereo/stereo_pair.hpp"

namespace kantaro::perception::stereo {
namespace {

/// Cost of matching left pixel (x, y) with disparity d.
using Cost = std::function<double(const Pair& pair, int x, int y, int d, int radius)>;

double At(const cv::Mat& image, int x, int y) { return image.at<std::uint8_t>(y, x); }

double SsdByHand(const Pair& pair, int x, int y, int d, int radius) {
  double sum = 0;
  for (int j = y - radius; j <= y + radius; ++j) {
    for (int i = x - radius; i <= x + radius; ++i)
      sum += std::pow(At(pair.left, i, j) - At(pair.right, i - d, j), 2);
  }
  return sum;
}

double MinusCorrelationByHand(const Pair& pair, int x, int y, int d, int radius) {
  const double count = std::pow(2 * radius + 1, 2);
  double left_mean = 0, right_mean = 0;
  for (int j = -radius; j <= radius; ++j) {
    for (int i = -radius; i <= radius; ++i) {
      left_mean += At(pair.left, x + i, y + j) / count;
      right_mean += At(pair.right, x + i - d, y + j) / count;
    }
  }
  double product = 0, left_square = 0, right_square = 0;
  for (int j = -radius; j <= radius; ++j) {
    for (int i = -radius; i <= radius; ++i) {
      const double left = At(pair.left, x + i, y + j) - left_mean;
      const double right = At(pair.right, x + i - d, y + j) - right_mean;
      product += left * right;
      left_square += left * left;
      right_square += right * right;
    }
  }
  const double scale = std::sqrt(left_square * right_square);
  return scale < 1e-9 ? 0.0 : -product / scale;
}

double GradientByHand(const Pair& pair, int x, int y, int d, int radius) {
  const auto gradient = [](const cv::Mat& image, int i, int j) {
    const auto at = [&](int u, int v) {
      return At(image, std::clamp(u, 0, image.cols - 1), std::clamp(v, 0, image.rows - 1));
    };
    return cv::Point2d((at(i + 1, j) - at(i - 1, j)) / 2, (at(i, j + 1) - at(i, j - 1)) / 2);
  };
  double sum = 0;
  for (int j = y - radius; j <= y + radius; ++j) {
    for (int i = x - radius; i <= x + radius; ++i) {
      const cv::Point2d left = gradient(pair.left, i, j), right = gradient(pair.right, i - d, j);
      sum -= (cv::norm(left) + cv::norm(right)) / 2 - cv::norm(left - right);
    }
  }
  return sum;
}

/// The disparity map is as good as the best by hand: each disparity's cost is within `tolerance` of
/// the least, and where `lowest`, no lower disparity has the same.
void ExpectLeastCost(const Pair& pair, const Parameters& p, const Cost& cost, double tolerance,
                     bool lowest) {
  const DisparityMap map = Match(pair.left, pair.right, p);
  const int radius = p.window_px / 2, last = p.min_disparity_px + p.disparities - 1;
  for (int y = 0; y < pair.left.rows; ++y) {
    for (int x = 0; x < pair.left.cols; ++x) {
      const float found = map.disparity_px.at<float>(y, x);
      const bool fits = y >= radius && y + radius < pair.left.rows && x - radius - last >= 0 &&
                        x + radius < pair.left.cols;
      ASSERT_EQ(std::isnan(found), !fits) << x << ", " << y;
      if (!fits) continue;
      double least = std::numeric_limits<double>::infinity();
      int best = -1;
      for (int d = p.min_disparity_px; d <= last; ++d) {
        const double here = cost(pair, x, y, d, radius);
        if (here < least) {
          least = here;
          best = d;
        }
      }
      ASSERT_LE(cost(pair, x, y, static_cast<int>(found), radius), least + tolerance)
          << x << ", " << y;
      if (lowest) {
        ASSERT_EQ(found, static_cast<float>(best)) << x << ", " << y;
      }
    }
  }
}

const Pair& Textured() {
  static const Pair pair = Noise({41, 23}, 1);
  return pair;
}
const Pair& Tied() {
  static const Pair pair = CoarseNoise({41, 23}, 2);
  return pair;
}

TEST(PlainSsd, IsTheLeastSumOfSquaresAndTheLowestOfEquals) {
  ExpectLeastCost(Textured(), Small(Method::kSsdPlain), SsdByHand, 0, true);
  ExpectLeastCost(Tied(), Small(Method::kSsdPlain), SsdByHand, 0, true);
}

TEST(SlidingSsd, IsTheLeastSumOfSquaresAndTheLowestOfEquals) {
  ExpectLeastCost(Textured(), Small(Method::kSsd), SsdByHand, 0, true);
  ExpectLeastCost(Tied(), Small(Method::kSsd), SsdByHand, 0, true);
}

TEST(SlidingSsd, EqualsPlainSsdToTheBit) {
  for (const bool subpixel : {false, true}) {
    for (const int window : {3, 7, 11}) {
      const Pair pair = Noise({97, 45}, 3);
      Parameters parameters;
      parameters.disparities = 29;
      parameters.window_px = window;
      parameters.subpixel = subpixel;
      parameters.method = Method::kSsdPlain;
      const DisparityMap plain = Match(pair.left, pair.right, parameters);
      parameters.method = Method::kSsd;
      ExpectSame(Match(pair.left, pair.right, parameters).disparity_px, plain.disparity_px);
    }
  }
}

// The largest sums there are: black against white.
TEST(SlidingSsd, HoldsTheLargestSums) {
  Pair pair = Noise({60, 30}, 4);
  pair.right.setTo(0);
  cv::threshold(pair.left, pair.left, 10, 255, cv::THRESH_BINARY);
  Parameters parameters = Small(Method::kSsd);
  parameters.window_px = 11;
  ExpectLeastCost(pair, parameters, SsdByHand, 0, true);
}

TEST(Ncc, HasTheGreatestCorrelation) {
  ExpectLeastCost(Textured(), Small(Method::kNcc), MinusCorrelationByHand, 1e-5, false);
  ExpectLeastCost(Tied(), Small(Method::kNcc), MinusCorrelationByHand, 1e-5, false);
}

TEST(Ncc, HoldsTheLargestSums) {
  Pair pair = Noise({60, 30}, 5);
  for (cv::Mat* image : {&pair.left, &pair.right})
    cv::threshold(*image, *image, 25, 255, cv::THRESH_BINARY);
  Parameters parameters = Small(Method::kNcc);
  parameters.window_px = 11;
  ExpectLeastCost(pair, parameters, MinusCorrelationByHand, 1e-5, false);
}

// The sums are kept in 64ths of a grey level, so each of 25 pixels may be one off.
TEST(GradientMatching, HasTheMostAlikeGradients) {
  ExpectLeastCost(Textured(), Small(Method::kGradient), GradientByHand, 2 * 25 / 64.0, false);
  ExpectLeastCost(Tied(), Small(Method::kGradient), GradientByHand, 2 * 25 / 64.0, false);
}

TEST(SubpixelRefinement, IsTheLowestPointOfTheParabola) {
  Pair pair{cv::Mat(3, 8, CV_8U, cv::Scalar(0)), cv::Mat(3, 8, CV_8U, cv::Scalar(0))};
  // One bright pixel in each image, black elsewhere: few squares to add up.
  pair.left.at<std::uint8_t>(1, 6) = 10;
  pair.right.at<std::uint8_t>(1, 4) = 9;
  Parameters parameters = Small(Method::kSsd);
  parameters.min_disparity_px = 1;
  parameters.disparities = 3;
  parameters.window_px = 3;
  parameters.subpixel = true;
  // d = 1: (10 − 0)² + (0 − 9)² = 181;  d = 2: (10 − 9)² = 1;  d = 3: (10 − 0)² + 9² = 181.
  EXPECT_FLOAT_EQ(Match(pair.left, pair.right, parameters).disparity_px.at<float>(1, 6), 2.0F);
  // With 4 beside it: d = 1: (10 − 4)² + 9² = 117; d = 2: 1 + 4² = 17; d = 3: 10² + 9² = 181.
  pair.right.at<std::uint8_t>(1, 5) = 4;
  EXPECT_FLOAT_EQ(Match(pair.left, pair.right, parameters).disparity_px.at<float>(1, 6),
                  static_cast<float>(2.0 + (117.0 - 181.0) / (2.0 * (117.0 - 34.0 + 181.0))));
}

}  // namespace
}  // namespace kantaro::perception::stereo
