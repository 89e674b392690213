// Cooperative stereo (thesis section 5.3) against its equations, pixel by pixel.
#include "perception/stereo/cooperative.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "perception/stereo/linear_computation.hpp"
#include "tests/perception/stereo/stereo_pair.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(GroupClassification, CallsAStepOfTheThresholdAFeature) {
  const cv::Mat image = (cv::Mat_<std::uint8_t>(2, 6) << 50, 59, 69, 80, 70, 61,  //
                         200, 0, 0, 255, 254, 244);
  const cv::Mat expected = (cv::Mat_<std::uint8_t>(2, 6) << 0, 0, 255, 255, 255, 0,  //
                            0, 255, 0, 255, 0, 255);
  EXPECT_EQ(cv::countNonZero(FeaturePixels(image, 10) != expected), 0);
  EXPECT_THROW((void)FeaturePixels(cv::Mat(3, 3, CV_16U), 10), std::invalid_argument);
}

TEST(NeighbourConstraint, LeavesADifferenceOfTheThresholdAndHalvesALargerOne) {
  EXPECT_EQ(ConstrainToNeighbour(30, 20, 10), 30);
  EXPECT_EQ(ConstrainToNeighbour(31, 20, 10), 25);
  EXPECT_EQ(ConstrainToNeighbour(10, 20, 10), 10);
  EXPECT_EQ(ConstrainToNeighbour(9, 20, 10), 15);
  EXPECT_EQ(ConstrainToNeighbour(60, kNaN, 10), 60);  // free
}

int Difference(const cv::Mat& image, int x, int y) {
  return x == 0 ? 0 : image.at<std::uint8_t>(y, x) - image.at<std::uint8_t>(y, x - 1);
}

/// Eq. 5.2 with the two tie-breaks.
float LcByHand(const Pair& pair, const Parameters& p, int x, int y, float neighbour) {
  const int left = Difference(pair.left, x, y);
  int most = 0, least_unlikeness = 0;
  float best = kNaN;
  for (int d = p.min_disparity_px; d < p.min_disparity_px + p.disparities; ++d) {
    const int right = Difference(pair.right, x - d, y);
    const int unlikeness = std::abs(left - right);
    const int measure = std::abs(left) + std::abs(right) - unlikeness;
    if (measure <= 0 || measure < most) continue;
    const float from = std::isnan(neighbour) ? 0.0F : neighbour;
    const bool tie = measure == most && unlikeness == least_unlikeness;
    if (measure > most || unlikeness < least_unlikeness ||
        (tie && std::abs(static_cast<float>(d) - from) < std::abs(best - from))) {
      most = measure;
      least_unlikeness = unlikeness;
      best = static_cast<float>(d);
    }
  }
  return best;
}

TEST(LcMatching, MaximisesTheMeasureAndBreaksTiesByLikenessThenByTheNeighbour) {
  for (const Pair& pair : {Noise({70, 12}, 1), CoarseNoise({70, 12}, 2)}) {
    for (const int disparities : {1, 7, 16, 20, 40}) {
      Parameters parameters = Small(Method::kLc);
      parameters.disparities = disparities;
      const int first = parameters.min_disparity_px + disparities;
      cv::Mat expected(pair.left.size(), CV_32F, cv::Scalar(kNaN));
      for (int y = 0; y < expected.rows; ++y) {
        for (int x = first; x < expected.cols; ++x) {
          expected.at<float>(y, x) = LcByHand(pair, parameters, x, y, expected.at<float>(y, x - 1));
        }
      }
      ExpectSame(Match(pair.left, pair.right, parameters).disparity_px, expected);
    }
  }
}

// A falling edge is no partner of a rising one, however steep.
TEST(LcMatching, FindsNoPartnerOfTheOtherSign) {
  Pair pair{cv::Mat(7, 40, CV_8U, cv::Scalar(0)), cv::Mat(7, 40, CV_8U, cv::Scalar(200))};
  pair.left.colRange(30, 40).setTo(200);
  pair.right.colRange(24, 40).setTo(0);
  EXPECT_EQ(CountDisparities(Match(pair.left, pair.right, Small(Method::kLc))), 0);
  pair.right.colRange(0, 24).setTo(0);
  pair.right.colRange(24, 40).setTo(150);
  const DisparityMap map = Match(pair.left, pair.right, Small(Method::kLc));
  EXPECT_EQ(CountDisparities(map), 7);
  EXPECT_EQ(map.disparity_px.at<float>(3, 30), 6);
}

struct Ssd {
  double least = std::numeric_limits<double>::infinity(), runner_up = least;
  int at = -1, runner_up_at = -1;
};

Ssd SsdByHand(const Pair& pair, const Parameters& p, int x, int y) {
  const auto cost = [&](int d) {
    double sum = 0;
    const int radius = p.window_px / 2;
    for (int j = y - radius; j <= y + radius; ++j) {
      for (int i = x - radius; i <= x + radius; ++i)
        sum +=
            std::pow(pair.left.at<std::uint8_t>(j, i) - pair.right.at<std::uint8_t>(j, i - d), 2);
    }
    return sum;
  };
  Ssd ssd;
  const int end = p.min_disparity_px + p.disparities;
  for (int d = p.min_disparity_px; d < end; ++d) {
    if (cost(d) < ssd.least) {
      ssd.least = cost(d);
      ssd.at = d;
    }
  }
  for (int d = p.min_disparity_px; d < end; ++d) {
    if (std::abs(d - ssd.at) > 1 && cost(d) < ssd.runner_up) {
      ssd.runner_up = cost(d);
      ssd.runner_up_at = d;
    }
  }
  return ssd;
}

float NonFeatureByHand(const Pair& pair, const Parameters& p, int x, int y, float previous) {
  const Ssd ssd = SsdByHand(pair, p, x, y);
  int d = ssd.at;
  if (p.function_value_constraint != FunctionValueConstraint::kOff) {
    const double ratio = ssd.least > 0 ? (ssd.runner_up - ssd.least) / ssd.least
                                       : std::numeric_limits<double>::infinity();
    const bool perfect_twice = ssd.least == 0 && ssd.runner_up == 0;
    if (p.function_value_constraint == FunctionValueConstraint::kAsWritten) {
      if (ssd.least > 0 && ratio > p.peak_ratio) d = ssd.runner_up_at;
    } else if (ratio <= p.peak_ratio || perfect_twice) {
      return kNaN;
    }
  }
  const double jump = d - static_cast<double>(previous);
  if (std::isnan(previous) || std::abs(jump) <= p.neighbour_threshold_px)
    return static_cast<float>(d);
  const double sign = jump >= 0 ? 1 : -1;
  return static_cast<float>(previous + sign * p.neighbour_threshold_px / 2);
}

class CooperativeMatching : public testing::TestWithParam<FunctionValueConstraint> {};

TEST_P(CooperativeMatching, IsLcOnFeaturesAndConstrainedSsdElsewhere) {
  for (const Pair& pair : {Noise({50, 20}, 3), CoarseNoise({50, 20}, 4)}) {
    Parameters p = Small(Method::kCooperative);
    p.feature_threshold = 15;
    p.neighbour_threshold_px = 3;
    p.function_value_constraint = GetParam();
    const cv::Mat features = FeaturePixels(pair.left, p.feature_threshold);
    const int first = p.min_disparity_px + p.disparities - 1 + 2;
    cv::Mat expected(pair.left.size(), CV_32F, cv::Scalar(kNaN));
    int feature_pixels = 0;
    for (int y = 2; y < expected.rows - 2; ++y) {
      for (int x = first; x < expected.cols - 2; ++x) {
        const float previous = expected.at<float>(y, x - 1);
        const bool feature = features.at<std::uint8_t>(y, x) != 0;
        feature_pixels += feature ? 1 : 0;
        expected.at<float>(y, x) =
            feature ? LcByHand(pair, p, x, y, previous) : NonFeatureByHand(pair, p, x, y, previous);
      }
    }
    EXPECT_GT(feature_pixels, 50);
    ExpectSame(Match(pair.left, pair.right, p).disparity_px, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryConstraint, CooperativeMatching,
                         testing::Values(FunctionValueConstraint::kAsWritten,
                                         FunctionValueConstraint::kOff,
                                         FunctionValueConstraint::kInverted));

// Stripes of 6 px match at 3, 9 and 15 alike: ambiguous.
TEST(FunctionValueConstraint, InvertedRefusesWhatRepeats) {
  Pair pair{cv::Mat(20, 60, CV_8U), cv::Mat(20, 60, CV_8U)};
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 60; ++x) {
      const auto stripes = [](int column) { return 100 + 8 * std::abs(column % 6 - 3); };
      pair.right.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(stripes(x));
      pair.left.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(stripes(x + 3));
    }
  }
  Parameters parameters = Small(Method::kCooperative);
  parameters.disparities = 16;
  parameters.function_value_constraint = FunctionValueConstraint::kOff;
  EXPECT_GT(CountDisparities(Match(pair.left, pair.right, parameters)), 500);
  parameters.function_value_constraint = FunctionValueConstraint::kInverted;
  EXPECT_EQ(CountDisparities(Match(pair.left, pair.right, parameters)), 0);
}

// Why the thesis' own rule hurts: it throws away just the minima that stand out. Sensor noise keeps
// even the true match above 0.
TEST(FunctionValueConstraint, AsWrittenDiscardsDistinctMinima) {
  const auto nine = [](int, int) { return 9.0; };
  Pair pair = Surface({160, 96}, nine, 5);
  pair.right = pair.right + 2;
  Parameters parameters;
  parameters.method = Method::kCooperative;
  parameters.disparities = 32;
  const cv::Rect inside{48, 8, 104, 80};
  const auto right = [&](FunctionValueConstraint constraint) {
    parameters.function_value_constraint = constraint;
    return ShareWithin(Match(pair.left, pair.right, parameters), inside, nine, 0.01);
  };
  const double off = right(FunctionValueConstraint::kOff);
  EXPECT_GT(off, 0.6);
  EXPECT_LT(right(FunctionValueConstraint::kAsWritten), off - 0.3);
}

}  // namespace
}  // namespace kantaro::perception::stereo
