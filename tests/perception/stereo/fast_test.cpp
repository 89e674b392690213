// Fast stereo (thesis section 5.4) against its equations, corner by corner.
#include "perception/stereo/fast.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "tests/perception/stereo/stereo_pair.hpp"

namespace kantaro::perception::stereo {
namespace {

/// The measures of one corner for every candidate, in floating point.
struct Measures {
  std::vector<double> ssd, correlation, combined;  ///< SSD′, Cor, Com by candidate
  double omega{};
};

Measures ByHand(const Pair& pair, const Parameters& p, int x, int y) {
  const int radius = p.window_px / 2;
  const double area = p.window_px * p.window_px;
  const auto at = [&](const cv::Mat& image, int i, int j) {
    return static_cast<double>(image.at<std::uint8_t>(y + j, x + i));
  };
  Measures measures;
  measures.omega = std::abs(at(pair.left, 0, 0) - at(pair.left, -1, 0)) / p.gradient_scale;
  for (int k = 0; k < p.disparities; ++k) {
    const int d = p.min_disparity_px + k;
    double ssd = 0, left = 0, right = 0, left2 = 0, right2 = 0, product = 0;
    for (int j = -radius; j <= radius; ++j) {
      for (int i = -radius; i <= radius; ++i) {
        const double l = at(pair.left, i, j), r = at(pair.right, i - d, j);
        ssd += (l - r) * (l - r);
        left += l;
        right += r;
        left2 += l * l;
        right2 += r * r;
        product += l * r;
      }
    }
    const double scale = std::sqrt((left2 - left * left / area) * (right2 - right * right / area));
    measures.ssd.push_back(1 - ssd / (area * p.ssd_scale * p.ssd_scale));
    measures.correlation.push_back(scale > 1e-9 ? (product - left * right / area) / scale : 0);
    measures.combined.push_back(
        (measures.ssd.back() + measures.omega * measures.correlation.back()) /
        (1 + measures.omega));
  }
  return measures;
}

double Largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// Calls with each corner that can be matched: its place in the map of corners and in the image.
void ForEachCorner(const Pair& pair, const Parameters& p,
                   const std::function<void(cv::Point corner, cv::Point pixel)>& use) {
  const int radius = p.window_px / 2;
  for (int v = 0; v < CornersAlong(pair.left.rows); ++v) {
    for (int u = 0; u < CornersAlong(pair.left.cols); ++u) {
      const cv::Point pixel{std::clamp(8 * u, radius, pair.left.cols - 1 - radius),
                            std::clamp(8 * v, radius, pair.left.rows - 1 - radius)};
      if (pixel.x - radius >= p.min_disparity_px + p.disparities - 1) use({u, v}, pixel);
    }
  }
}

class CornerMatching : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] Parameters WithWindow() const {
    Parameters parameters = Small(Method::kFastNearest);
    parameters.window_px = GetParam();
    return parameters;
  }
};

TEST_P(CornerMatching, MaximisesTheCombinedMeasure) {
  for (const Pair& pair : {Noise({100, 53}, 1), CoarseNoise({100, 53}, 2)}) {
    const Parameters p = WithWindow();
    const cv::Mat corners = MatchCorners(Frame(pair.left, pair.right, p));
    int count = 0;
    ForEachCorner(pair, p, [&](cv::Point corner, cv::Point pixel) {
      const Measures measures = ByHand(pair, p, pixel.x, pixel.y);
      const float found = corners.at<float>(corner);
      ASSERT_FALSE(std::isnan(found)) << pixel.x << ", " << pixel.y;
      const auto k = static_cast<std::size_t>(found) - p.min_disparity_px;
      EXPECT_GE(measures.combined.at(k), Largest(measures.combined) - 1e-5)
          << pixel.x << ", " << pixel.y;
      ++count;
    });
    EXPECT_GT(count, 70);
    EXPECT_EQ(CountDisparities({corners}), count);
  }
}

TEST_P(CornerMatching, AveragesTheTwoDisparitiesIfAsked) {
  const Pair pair = Noise({100, 53}, 3);
  Parameters p = WithWindow();
  p.corner_disparity = CornerDisparity::kAverage;
  const cv::Mat corners = MatchCorners(Frame(pair.left, pair.right, p));
  ForEachCorner(pair, p, [&](cv::Point corner, cv::Point pixel) {
    const Measures m = ByHand(pair, p, pixel.x, pixel.y);
    const auto argmax = [](const std::vector<double>& values) {
      return static_cast<double>(std::max_element(values.begin(), values.end()) - values.begin());
    };
    const double expected =
        p.min_disparity_px + (argmax(m.ssd) + m.omega * argmax(m.correlation)) / (1 + m.omega);
    EXPECT_NEAR(corners.at<float>(corner), expected, 1e-4) << pixel.x << ", " << pixel.y;
  });
}

INSTANTIATE_TEST_SUITE_P(Windows, CornerMatching, testing::Values(3, 7, 11));

// ω is 0 where the image does not change from the left, and large where it does: SSD alone in the
// one, correlation alone in the other.
TEST(CornerMatching, TrustsCorrelationByTheGradient) {
  const auto nine = [](int, int) { return 9.0; };
  Pair pair = Surface({160, 96}, nine, 4);
  pair.right.convertTo(pair.right, CV_8U, 0.5, 20);
  Parameters p;
  p.disparities = 32;
  const auto right = [&](double gradient_scale) {
    p.gradient_scale = gradient_scale;
    const cv::Mat corners = MatchCorners(Frame(pair.left, pair.right, p));
    return cv::countNonZero(corners == 9) / static_cast<double>(CountDisparities({corners}));
  };
  EXPECT_GT(right(0.001), 0.9);
  EXPECT_LT(right(1e6), 0.6);
}

TEST(CornerMatching, SeesTheLowestOfEqualCandidates) {
  Pair pair{cv::Mat(16, 64, CV_8U), cv::Mat(16, 64, CV_8U)};
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      // Repeats every 6 px: disparities 3, 9 and 15 match alike.
      pair.right.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(100 + 8 * std::abs(x % 6 - 3));
      pair.left.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(100 + 8 * std::abs((x + 3) % 6 - 3));
    }
  }
  Parameters p = Small(Method::kFastNearest);
  p.disparities = 16;
  const cv::Mat corners = MatchCorners(Frame(pair.left, pair.right, p));
  EXPECT_EQ(cv::countNonZero(corners == 3), CountDisparities({corners}));
  EXPECT_GT(CountDisparities({corners}), 10);
}

/// Corners of a plane that changes by `slope` [px/px] along the rows.
cv::Mat Plane(double slope) {
  cv::Mat corners(7, 9, CV_32F);
  for (int y = 0; y < corners.rows; ++y) {
    for (int x = 0; x < corners.cols; ++x)
      corners.at<float>(y, x) = static_cast<float>(20.0 + slope * 8 * x);
  }
  return corners;
}

TEST(SupportOfCorners, LeavesAWallAlone) {
  for (const double slope : {0.0, 0.3, -0.55})
    EXPECT_EQ(CountDisparities({KeepSupported(Plane(slope), Parameters{})}), 63) << slope;
}

// Of a corner's neighbours only those above and below it agree: the others are 7.2 px off.
TEST(SupportOfCorners, TakesAWallAwayThatNoPipeHas) {
  EXPECT_EQ(CountDisparities({KeepSupported(Plane(0.9), Parameters{})}), 0);
  Parameters p;
  p.steepest_wall = 1.0;
  EXPECT_EQ(CountDisparities({KeepSupported(Plane(0.9), p)}), 63);
}

TEST(SupportOfCorners, TakesAWrongCornerAwayAndNoOther) {
  cv::Mat corners = Plane(0.4);
  corners.at<float>(3, 4) += 20;
  const cv::Mat kept = KeepSupported(corners, Parameters{});
  EXPECT_TRUE(std::isnan(kept.at<float>(3, 4)));
  EXPECT_EQ(CountDisparities({kept}), 62);
  Parameters thesis;
  thesis.corner_support = 0;
  EXPECT_EQ(CountDisparities({KeepSupported(corners, thesis)}), 63);
}

// Along a straight edge a corner still has five neighbours on its own side.
TEST(SupportOfCorners, KeepsBothSidesOfAnEdge) {
  cv::Mat corners(7, 9, CV_32F, cv::Scalar(20));
  corners.colRange(4, 9).setTo(60);
  const cv::Mat kept = KeepSupported(corners, Parameters{});
  EXPECT_EQ(CountDisparities({kept}), 63);
}

TEST(SupportOfCorners, DoesNotComeFromCornersWithoutDisparity) {
  cv::Mat corners(7, 9, CV_32F, cv::Scalar(kNone));
  corners(cv::Rect(2, 2, 2, 2)).setTo(20);  // three neighbours each
  EXPECT_EQ(CountDisparities({KeepSupported(corners, Parameters{})}), 0);
}

// On a plane each pair of opposite neighbours has the corner's own disparity for its mean.
TEST(BridgedCorners, ContinueTheWall) {
  const cv::Mat plane = Plane(0.4);
  cv::Mat holed = plane.clone();
  for (const cv::Point hole : {cv::Point(4, 3), {1, 5}, {7, 1}}) holed.at<float>(hole) = kNone;
  EXPECT_LT(cv::norm(Bridge(holed, Parameters{}), plane, cv::NORM_INF), 1e-4);
}

// 20 px on the left, 60 on the right, and an unknown column between: only above and below it are
// corners of one wall, unknown ones.
TEST(BridgedCorners, DoNotSpanFromOneWallToAnother) {
  cv::Mat corners(7, 9, CV_32F, cv::Scalar(20));
  corners.colRange(5, 9).setTo(60);
  corners.col(4).setTo(kNone);
  EXPECT_EQ(CountDisparities({Bridge(corners, Parameters{})}), 56);
}

// A spot that only the left camera sees, about one corner of a wall at 12 px: what its window
// matches by chance reaches 16 px far, or its neighbours stand for it.
TEST(FastStereo, BridgesACornerThatItsNeighboursContradict) {
  const auto twelve = [](int, int) { return 12.0; };
  Pair pair = Surface({160, 96}, twelve, 6);
  const Pair other = Surface(
      {160, 96}, [](int, int) { return 27.0; }, 7);
  const cv::Rect spot(104 - 4, 48 - 4, 9, 9);
  other.left(spot).copyTo(pair.left(spot));
  const auto worst_px = [&](int support, const cv::Rect& around) {
    Parameters p;
    p.method = Method::kFastCubic;
    p.disparities = 32;
    p.gaussian_window_px = 1;  // so that the spot stays within its corner's window
    p.corner_support = support;
    const DisparityMap map = Match(pair.left, pair.right, p);
    double worst = 0;
    for (int y = around.y; y < around.y + around.height; ++y) {
      for (int x = around.x; x < around.x + around.width; ++x) {
        const float found = map.disparity_px.at<float>(y, x);
        worst = std::max(worst, std::isnan(found) ? 100.0 : std::abs(found - 12.0));
      }
    }
    return worst;
  };
  const cv::Rect block(96, 40, 16, 16), all(64, 16, 80, 64);
  EXPECT_GT(worst_px(0, block), 2.0);
  EXPECT_LT(worst_px(4, all), 0.5);
}

// The order of Table 5.2 on a wall that curves as a pipe's does.
TEST(FastStereo, ErrsLeastWithCubicAndMostWithNearest) {
  const auto wall = [](int x, int y) {
    return 16 + 6 * std::cos((x - 80) / 18.0) + 3 * std::cos((y - 48) / 15.0);
  };
  const Pair pair = Surface({160, 96}, wall, 5);
  const auto mean_error = [&](Method method) {
    Parameters p;
    p.method = method;
    p.disparities = 32;
    p.subpixel = true;
    const DisparityMap map = Match(pair.left, pair.right, p);
    double sum = 0;
    for (int y = 16; y < 80; ++y) {
      for (int x = 56; x < 144; ++x) sum += std::abs(map.disparity_px.at<float>(y, x) - wall(x, y));
    }
    return sum / (64.0 * 88.0);
  };
  const double nearest = mean_error(Method::kFastNearest), linear = mean_error(Method::kFastLinear),
               cubic = mean_error(Method::kFastCubic);
  EXPECT_LT(linear, 0.8 * nearest);
  EXPECT_LE(cubic, linear);
}

}  // namespace
}  // namespace kantaro::perception::stereo
