#include "perception/stereo/cooperative.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "perception/stereo/linear_computation.hpp"
#include "perception/stereo/window_matching.hpp"

namespace kantaro::perception::stereo {
namespace {

/// The least cost of each column at candidates not adjacent to the winner, and where.
struct RunnersUp {
  std::vector<std::int32_t> cost, candidate;

  void Find(const Frame& frame, const CostRow<std::int32_t>& costs,
            const std::vector<std::int32_t>& winner) {
    cost.assign(frame.left.cols, std::numeric_limits<std::int32_t>::max());
    candidate.assign(frame.left.cols, -1);
    const std::int32_t* const best = winner.data();
    std::int32_t* const least = cost.data();
    std::int32_t* const index = candidate.data();
    for (int i = 0; i < frame.parameters.disparities; ++i) {
      const std::int32_t* const here = costs[i];
      for (int x = frame.first_column; x < frame.end_column; ++x) {
        const std::int32_t away = i - best[x];
        const bool better = (away > 1 || away < -1) & (here[x] < least[x]);
        least[x] = better ? here[x] : least[x];
        index[x] = better ? i : index[x];
      }
    }
  }
};

class Cooperative {
 public:
  explicit Cooperative(const Frame& frame)
      : frame_(frame),
        textured_(Textured(frame)),
        disparities_(frame.NoDisparities()),
        lc_(frame) {}

  void Row(int y, const CostRow<std::int32_t>& costs) {
    const Parameters& p = frame_.parameters;
    FindWinners(frame_, costs, best_, winner_);
    if (p.function_value_constraint != FunctionValueConstraint::kOff)
      runners_up_.Find(frame_, costs, winner_);
    lc_.StartRow(y);
    const std::uint8_t* const textured = textured_.ptr(y);
    auto* const out = disparities_.ptr<float>(y);
    for (int x = frame_.first_column; x < frame_.end_column; ++x) {
      if (lc_.Difference(x) >= p.feature_threshold) {
        out[x] = lc_.Disparity(x, out[x - 1]);
      } else if (textured[x] != 0) {
        const int candidate = Questioned(x);
        if (candidate < 0) continue;
        out[x] = ConstrainToNeighbour(DisparityOf(frame_, costs, candidate, x), out[x - 1],
                                      p.neighbour_threshold_px);
      }
    }
  }
  [[nodiscard]] const cv::Mat& disparities() const { return disparities_; }

 private:
  /// The function-value constraint (eq. 5.5). @returns a candidate, or −1 for none. A perfect match
  /// (E1 = 0) has no ratio and stays.
  [[nodiscard]] int Questioned(int x) const {
    const Parameters& p = frame_.parameters;
    const int winner = winner_[x];
    if (p.function_value_constraint == FunctionValueConstraint::kOff) return winner;
    const int runner_up = runners_up_.candidate[x];
    if (runner_up < 0) return winner;
    const double e1 = best_[x], e2 = runners_up_.cost[x];
    const bool distinct = e2 - e1 > p.peak_ratio * e1;
    if (p.function_value_constraint == FunctionValueConstraint::kInverted)
      return distinct ? winner : -1;
    return distinct && e1 > 0 ? runner_up : winner;
  }

  const Frame& frame_;
  cv::Mat textured_, disparities_;
  LinearComputation lc_;
  std::vector<std::int32_t> best_, winner_;
  RunnersUp runners_up_;
};

}  // namespace

float ConstrainToNeighbour(float current, float previous, double threshold) {
  const double jump = static_cast<double>(current) - previous;
  if (!(std::abs(jump) > threshold)) return current;  // so if there is no neighbour
  return static_cast<float>(previous + std::copysign(threshold / 2, jump));
}

cv::Mat MatchCooperative(const Frame& frame) {
  Cooperative cooperative(frame);
  ForEachSsdRow(frame, [&](int y, const auto& costs) { cooperative.Row(y, costs); });
  return cooperative.disparities();
}

}  // namespace kantaro::perception::stereo
