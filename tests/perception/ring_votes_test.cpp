#include "perception/ring_votes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace kantaro::perception {
namespace {

constexpr int kSearch_px = 6;
constexpr VoteColumns kColumns{20, 30, 130};
/// All round with one sign, and an upper arc in three parts, none a multiple of four.
const Groups kGroups{{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, {11, 12, 13, 14, 15}, {143, 142, 141}};

cv::Mat RandomContrast(std::uint64_t seed) {
  cv::Mat contrast(kDirections, kColumns.last + kColumns.pad + 1, CV_32F);
  cv::RNG(seed).fill(contrast, cv::RNG::UNIFORM, -0.4, 0.4);
  return contrast;
}

/// The middle of the band of radii that a column belongs to: bands grow by 1.4.
double BandRadius_px(int column) {
  for (int begin = kColumns.pad, end = 0;; begin = end + 1) {
    end = std::min(std::max(begin, static_cast<int>((begin + kColumns.radius_of_first_px) * 1.4) -
                                       kColumns.radius_of_first_px),
                   kColumns.last);
    if (column <= end) return kColumns.radius_of_first_px + (begin + end) / 2.0;
  }
}

/// Votes of 1/500 of contrast for one circle, from the definition: direction by direction.
int VotesFor(const cv::Mat& contrast, int column, cv::Point centre) {
  int total = 0;
  for (const auto& group : kGroups) {
    int sum = 0;
    for (const int t : group) {
      const double clock_rad = 2 * CV_PI * t / kDirections;
      const double along = centre.x * std::sin(clock_rad) - centre.y * std::cos(clock_rad);
      const double across = -centre.x * std::cos(clock_rad) - centre.y * std::sin(clock_rad);
      const auto shift = std::lround(along - across * across / (2 * BandRadius_px(column)));
      sum += cvRound(contrast.at<float>(t, column + static_cast<int>(shift)) * 500.0F);
    }
    total += std::abs(sum);
  }
  return total;
}

TEST(RingVotes, GiveTheCentreThatADirectCountGives) {
  const RingVotes votes(kGroups, kSearch_px, kColumns);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const cv::Mat contrast = RandomContrast(seed);
    const std::vector<int> visible(static_cast<std::size_t>(contrast.cols), 19);
    const std::vector<BestCircle> best = votes.Count(contrast, visible);
    ASSERT_EQ(best.size(), static_cast<std::size_t>(kColumns.last - kColumns.pad + 1));
    for (std::size_t i = 0; i < best.size(); ++i) {
      const int column = kColumns.pad + static_cast<int>(i);
      int most = 0;
      for (int dy = -kSearch_px; dy <= kSearch_px; dy += 2) {
        for (int dx = -kSearch_px; dx <= kSearch_px; dx += 2)
          most = std::max(most, VotesFor(contrast, column, {dx, dy}));
      }
      EXPECT_DOUBLE_EQ(best[i].contrast, most / (500.0 * 19)) << "column " << column;
      EXPECT_EQ(VotesFor(contrast, column, best[i].offset), most) << "column " << column;
    }
  }
}

// A circle of which less than 35 % of the directions lie in the image is no evidence.
TEST(RingVotes, PassOverCirclesThatHardlyShow) {
  const cv::Mat contrast = RandomContrast(4);
  std::vector<int> visible(static_cast<std::size_t>(contrast.cols), 19);
  visible[50] = 6;  // of 19
  const std::vector<BestCircle> best =
      RingVotes(kGroups, kSearch_px, kColumns).Count(contrast, visible);
  EXPECT_EQ(best[50 - kColumns.pad].contrast, 0.0);
  EXPECT_GT(best[51 - kColumns.pad].contrast, 0.0);
}

}  // namespace
}  // namespace kantaro::perception
