#include "perception/ring_votes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>

namespace kantaro::perception {
namespace {

constexpr int kCenterStep = 2;               // of the search [px]
constexpr double kVotesPerContrast = 500.0;  // 144 directions of the largest line fit 16 bits
constexpr double kLeastVisible = 0.35;       // share of a circle that must lie in the image
constexpr int kLanes = cv::v_int16x8::nlanes;

/// Where the votes of a direction for a circle about `offset` lie, from the circle's column.
int Shift(cv::Point offset, int direction, double radius_px, int pad) {
  const cv::Point2d u = Directions()[direction];
  const double along = offset.x * u.x + offset.y * u.y;
  const double across = offset.x * u.y - offset.y * u.x;
  return std::clamp(static_cast<int>(std::lround(along - across * across / (2 * radius_px))), -pad,
                    pad);
}

}  // namespace

const std::array<cv::Point2d, kDirections>& Directions() {
  static const auto directions = [] {
    std::array<cv::Point2d, kDirections> result;
    for (int t = 0; t < kDirections; ++t) {
      const double clock_rad = 2 * std::numbers::pi * t / kDirections;
      result[t] = {std::sin(clock_rad), -std::cos(clock_rad)};
    }
    return result;
  }();
  return directions;
}

RingVotes::RingVotes(const Groups& groups, int search_px, const VoteColumns& columns)
    : groups_(groups), columns_(columns) {
  for (int dy = -search_px; dy <= search_px; dy += kCenterStep) {
    for (int dx = -search_px; dx <= search_px; dx += kCenterStep) centres_.emplace_back(dx, dy);
  }
  for (const auto& group : groups_)
    blocks_of_group_.push_back((group.size() + kShared - 1) / kShared);
  const int first_px = columns_.radius_of_first_px;
  for (int begin = columns_.pad, end = 0; begin <= columns_.last; begin = end + 1) {
    end = std::clamp(static_cast<int>((begin + first_px) * 1.4) - first_px, begin, columns_.last);
    bands_.push_back(MakeBand(begin, end));
  }
}

/// Sums reach as far as a first direction's shift does, and to whole vectors.
int RingVotes::Width(const Band& band) const {
  return band.end - band.begin + 1 + 2 * columns_.pad + kLanes;
}

RingVotes::Band RingVotes::MakeBand(int begin, int end) const {
  const double radius_px = columns_.radius_of_first_px + (begin + end) / 2.0;
  Band band{begin, end, {}, 0, {}};
  for (const auto& group : groups_) {
    for (std::size_t i = 0; i < group.size(); i += kShared) {
      Block& block = band.blocks.emplace_back();
      block.directions.assign(
          group.begin() + static_cast<std::ptrdiff_t>(i),
          group.begin() + static_cast<std::ptrdiff_t>(std::min(i + kShared, group.size())));
    }
  }
  const std::size_t blocks = band.blocks.size();
  band.places.resize(centres_.size() * blocks);
  const int width = Width(band);
  for (std::size_t b = 0; b < blocks; ++b) {
    Block& block = band.blocks[b];
    block.first_row = band.rows;
    std::map<std::array<int, kShared>, int> rows;
    for (std::size_t c = 0; c < centres_.size(); ++c) {
      const int first = Shift(centres_[c], block.directions[0], radius_px, columns_.pad);
      std::array<int, kShared> pattern{};
      for (std::size_t i = 1; i < block.directions.size(); ++i)
        pattern[i] = Shift(centres_[c], block.directions[i], radius_px, columns_.pad) - first;
      const auto [found, is_new] = rows.try_emplace(pattern, band.rows);
      if (is_new) {
        block.patterns.push_back(pattern);
        ++band.rows;
      }
      band.places[c * blocks + b] = found->second * width + columns_.pad + first;
    }
  }
  return band;
}

/// The table of sums: a row for each pattern of each block; column 0 is `pad` before the band.
std::vector<std::int16_t> RingVotes::Share(const Band& band, const cv::Mat& votes) const {
  const int width = Width(band);
  std::vector<std::int16_t> sums(static_cast<std::size_t>(band.rows) * width);
  for (const Block& block : band.blocks) {
    std::int16_t* row = sums.data() + static_cast<std::ptrdiff_t>(block.first_row) * width;
    for (const auto& pattern : block.patterns) {
      for (std::size_t i = 0; i < block.directions.size(); ++i) {
        const auto* from = votes.ptr<std::int16_t>(block.directions[i]) + Margin() + band.begin -
                           columns_.pad + pattern[i];
        for (int k = 0; k < width; ++k) row[k] = static_cast<std::int16_t>(row[k] + from[k]);
      }
      row += width;
    }
  }
  return sums;
}

/// Keeps for each column the first centre that has most votes.
void RingVotes::Vote(const Band& band, const std::vector<std::int16_t>& sums,
                     std::vector<std::int16_t>& most, std::vector<std::int16_t>& centre) const {
  const int* place = band.places.data();
  for (std::size_t c = 0; c < centres_.size(); ++c, place += band.blocks.size()) {
    const cv::v_int16x8 here = cv::v_setall_s16(static_cast<std::int16_t>(c));
    for (int k = 0; k <= band.end - band.begin; k += kLanes) {
      cv::v_int16x8 total = cv::v_setzero_s16();
      const int* block = place;
      for (const std::size_t blocks : blocks_of_group_) {
        cv::v_int16x8 group = cv::v_setzero_s16();
        for (std::size_t b = 0; b < blocks; ++b)
          group = cv::v_add_wrap(group, cv::v_load(sums.data() + *block++ + k));
        total = cv::v_add_wrap(total, cv::v_reinterpret_as_s16(cv::v_abs(group)));
      }
      const cv::v_int16x8 before = cv::v_load(&most[k]);
      const cv::v_int16x8 more = total > before;
      cv::v_store(&most[k], cv::v_max(total, before));
      cv::v_store(&centre[k], cv::v_select(more, here, cv::v_load(&centre[k])));
    }
  }
}

std::vector<BestCircle> RingVotes::Count(const cv::Mat& contrast,
                                         const std::vector<int>& visible) const {
  cv::Mat votes;
  contrast.convertTo(votes, CV_16S, kVotesPerContrast);
  cv::copyMakeBorder(votes, votes, 0, 0, Margin(), Margin() + kLanes, cv::BORDER_CONSTANT, 0.0);
  std::size_t all = 0;
  for (const auto& group : groups_) all += group.size();
  std::vector<BestCircle> best(static_cast<std::size_t>(columns_.last - columns_.pad + 1));
  for (const Band& band : bands_) {
    const std::vector<std::int16_t> sums = Share(band, votes);
    std::vector<std::int16_t> most(static_cast<std::size_t>(band.end - band.begin + 1 + kLanes));
    std::vector<std::int16_t> centre(most.size());
    Vote(band, sums, most, centre);
    for (int k = band.begin; k <= band.end; ++k) {
      const std::int16_t votes_here = most[k - band.begin];
      if (visible[k] < kLeastVisible * static_cast<double>(all) || votes_here == 0) continue;
      best[k - columns_.pad] = {votes_here / (kVotesPerContrast * visible[k]),
                                centres_[centre[k - band.begin]]};
    }
  }
  return best;
}

}  // namespace kantaro::perception
