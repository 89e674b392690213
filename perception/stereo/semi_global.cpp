#include "perception/stereo/semi_global.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "perception/stereo/window_matching.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr int kRadius = 3;   ///< of the census
constexpr int kPlaces = 48;  ///< that it compares
/// Price, in places, of a disparity that differs by one pixel from the path's last, and by more.
constexpr std::int16_t kStep = 4, kJump = 40;
constexpr std::int16_t kNever = 16000;
constexpr int kLeftRight_px = 1;
constexpr int kAround = 2;  ///< half of the square whose censuses must agree

/// Which of the neighbours are darker than the pixel, one bit each.
class Census {
 public:
  explicit Census(const cv::Mat& image) : width_(image.cols), bits_(image.total()) {
    cv::Mat framed;
    cv::copyMakeBorder(image, framed, kRadius, kRadius, kRadius, kRadius,
                       cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    for (int y = 0; y < image.rows; ++y) {
      std::uint64_t* const row = bits_.data() + static_cast<std::size_t>(y) * width_;
      const std::uint8_t* const middle = image.ptr(y);
      for (int j = 0; j <= 2 * kRadius; ++j) {
        for (int i = 0; i <= 2 * kRadius; ++i) {
          const std::uint8_t* const neighbour = framed.ptr(y + j) + i;
          for (int x = 0; x < width_; ++x) row[x] = 2 * row[x] + (neighbour[x] < middle[x] ? 1 : 0);
        }
      }
    }
  }
  [[nodiscard]] const std::uint64_t* Row(int y) const {
    return bits_.data() + static_cast<std::size_t>(y) * width_;
  }

 private:
  int width_;
  std::vector<std::uint64_t> bits_;
};

/// Numbers of each pixel of the frame's columns and each candidate, a pixel's side by side.
template <typename Number>
class Volume {
 public:
  explicit Volume(const Frame& frame)
      : first_(frame.first_column),
        columns_(frame.end_column - frame.first_column),
        candidates_(frame.parameters.disparities),
        numbers_(static_cast<std::size_t>(frame.left.rows) * columns_ * candidates_) {}
  [[nodiscard]] Number* At(int y, int x) {
    return numbers_.data() + (static_cast<std::size_t>(y) * columns_ + (x - first_)) * candidates_;
  }

 private:
  int first_, columns_, candidates_;
  std::vector<Number> numbers_;
};

Volume<std::uint8_t> Costs(const Frame& frame) {
  const Census left(frame.left), right(frame.right);
  Volume<std::uint8_t> costs(frame);
  for (int y = 0; y < frame.left.rows; ++y) {
    for (int x = frame.first_column; x < frame.end_column; ++x) {
      const std::uint64_t here = left.Row(y)[x];
      const std::uint64_t* const there = right.Row(y) + x - frame.parameters.min_disparity_px;
      std::uint8_t* const cost = costs.At(y, x);
      for (int i = 0; i < frame.parameters.disparities; ++i)
        cost[i] = static_cast<std::uint8_t>(std::popcount(here ^ there[-i]));
    }
  }
  return costs;
}

/// The least costs of all paths of one direction that end at a row's pixels. All 0 starts a path.
class PathRow {
 public:
  explicit PathRow(const Frame& frame)
      : first_(frame.first_column),
        stride_(frame.parameters.disparities + 2),
        costs_(static_cast<std::size_t>(frame.end_column - first_ + 2) * stride_),
        least_(frame.end_column - first_ + 2) {
    for (std::size_t pixel = 0; pixel < least_.size(); ++pixel)
      costs_[pixel * stride_] = costs_[(pixel + 1) * stride_ - 1] = kNever;
  }
  /// By candidate, −1 and one beyond the last being never; a column beside the frame's may be
  /// asked.
  [[nodiscard]] std::int16_t* Costs(int x) {
    return costs_.data() + static_cast<std::size_t>(x - first_ + 1) * stride_ + 1;
  }
  [[nodiscard]] std::int16_t& Least(int x) { return least_[x - first_ + 1]; }

 private:
  int first_, stride_;
  std::vector<std::int16_t> costs_, least_;
};

/// One pixel further on a path.
std::int16_t Extend(const std::int16_t* last, std::int16_t least, const std::uint8_t* cost,
                    int candidates, std::int16_t* path, std::int16_t* sum) {
  const auto jump = static_cast<std::int16_t>(least + kJump);
  std::int16_t best = kNever;
  for (int i = 0; i < candidates; ++i) {
    const auto step = static_cast<std::int16_t>(std::min(last[i - 1], last[i + 1]) + kStep);
    const std::int16_t way = std::min(std::min(last[i], step), jump);
    const auto total = static_cast<std::int16_t>(cost[i] + way - least);
    path[i] = total;
    sum[i] = static_cast<std::int16_t>(sum[i] + total);
    best = std::min(best, total);
  }
  return best;
}

/// Adds the costs of the four paths that come from the left, from above and from between, seen with
/// the image upright or upside down.
void AddPaths(const Frame& frame, bool upside_down, Volume<std::uint8_t>& costs,
              Volume<std::int16_t>& sums) {
  constexpr std::array<int, 3> kFromAbove{-1, 0, 1};
  const int rows = frame.left.rows, columns = frame.end_column - frame.first_column;
  const int candidates = frame.parameters.disparities, sign = upside_down ? -1 : 1;
  std::array<PathRow, kFromAbove.size()> above{PathRow(frame), PathRow(frame), PathRow(frame)};
  std::array<PathRow, kFromAbove.size()> now = above;
  for (int j = 0; j < rows; ++j) {
    const int y = upside_down ? rows - 1 - j : j;
    PathRow along(frame);
    for (int i = 0; i < columns; ++i) {
      const int x = upside_down ? frame.end_column - 1 - i : frame.first_column + i;
      const std::uint8_t* const cost = costs.At(y, x);
      std::int16_t* const sum = sums.At(y, x);
      along.Least(x) = Extend(along.Costs(x - sign), along.Least(x - sign), cost, candidates,
                              along.Costs(x), sum);
      for (std::size_t k = 0; k < kFromAbove.size(); ++k) {
        const int from = x + kFromAbove[k];
        now[k].Least(x) = Extend(above[k].Costs(from), above[k].Least(from), cost, candidates,
                                 now[k].Costs(x), sum);
      }
    }
    std::swap(above, now);
  }
}

/// The candidates of a row that cost least, by the left image's columns and by the right one's.
class RowWinners {
 public:
  explicit RowWinners(const Frame& frame)
      : frame_(frame), left_(frame.left.cols), right_(frame.left.cols), costs_(frame.left.cols) {}

  void Find(Volume<std::int16_t>& sums, int y) {
    std::fill(costs_.begin(), costs_.end(), kNever);
    for (int x = frame_.first_column; x < frame_.end_column; ++x) {
      const std::int16_t* const sum = sums.At(y, x);
      left_[x] = static_cast<int>(std::min_element(sum, sum + frame_.parameters.disparities) - sum);
      for (int i = 0; i < frame_.parameters.disparities; ++i) {
        const int there = x - frame_.parameters.min_disparity_px - i;
        if (sum[i] >= costs_[there]) continue;
        costs_[there] = sum[i];
        right_[there] = i;
      }
    }
  }
  [[nodiscard]] int Left(int x) const { return left_[x]; }
  /// The right image's choice at the left one's.
  [[nodiscard]] int Back(int x) const {
    return right_[x - frame_.parameters.min_disparity_px - left_[x]];
  }

 private:
  const Frame& frame_;
  std::vector<int> left_, right_;
  std::vector<std::int16_t> costs_;  ///< of right_
};

/// Where two equally steep straight lines through three costs at −1, 0 and 1 meet, the middle one
/// being the least: −0.5 … 0.5. Places that differ grow with the distance, not with its square, and
/// a parabola would draw everything towards whole pixels.
double WedgeOffset(int before, int middle, int after) {
  const int steepness = std::max(before, after) - middle;
  return steepness > 0 ? 0.5 * (before - after) / steepness : 0.0;
}

/// Whether what is around a pixel looks like what its candidate shows.
bool Agrees(const Frame& frame, Volume<std::uint8_t>& costs, int x, int y, int candidate) {
  int sum = 0, count = 0;
  for (int j = std::max(0, y - kAround); j <= std::min(frame.left.rows - 1, y + kAround); ++j) {
    for (int i = std::max(frame.first_column, x - kAround);
         i <= std::min(frame.end_column - 1, x + kAround); ++i) {
      sum += costs.At(j, i)[candidate];
      ++count;
    }
  }
  return 3 * sum < kPlaces * count;
}

}  // namespace

cv::Mat MatchSemiGlobal(const Frame& frame) {
  const cv::Mat textured = Textured(frame);
  Volume<std::uint8_t> costs = Costs(frame);
  Volume<std::int16_t> sums(frame);
  AddPaths(frame, false, costs, sums);
  AddPaths(frame, true, costs, sums);
  cv::Mat disparities = frame.NoDisparities();
  RowWinners winners(frame);
  for (int y = frame.radius; y < frame.left.rows - frame.radius; ++y) {
    winners.Find(sums, y);
    for (int x = frame.first_column; x < frame.end_column; ++x) {
      const int best = winners.Left(x);
      if (textured.at<std::uint8_t>(y, x) == 0 ||
          std::abs(winners.Back(x) - best) > kLeftRight_px || !Agrees(frame, costs, x, y, best))
        continue;
      const std::int16_t* const sum = sums.At(y, x);
      double disparity = frame.parameters.min_disparity_px + best;
      if (best > 0 && best + 1 < frame.parameters.disparities)
        disparity += WedgeOffset(sum[best - 1], sum[best], sum[best + 1]);
      disparities.at<float>(y, x) = static_cast<float>(disparity);
    }
  }
  return disparities;
}

}  // namespace kantaro::perception::stereo
