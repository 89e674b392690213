#include "perception/tried_distance.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::perception {
namespace {

constexpr double kTogether_m = 0.03;  ///< what lies so close to a distance speaks for it

}  // namespace

RangedLandmark Likeliest(const std::vector<TriedDistance>& tried) {
  double most = -HUGE_VAL;
  for (const TriedDistance& one : tried) most = std::max(most, one.log_odds);
  std::vector<double> share;  // distances tried lie closer together where they are short
  for (const TriedDistance& one : tried)
    share.push_back(one.distance_m * std::exp(one.log_odds - most));
  double all = 0.0, best = -1.0, mean_m = 0.0;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    all += share[i];
    double sum = 0.0, first = 0.0;
    for (std::size_t j = 0; j < tried.size(); ++j) {
      if (std::abs(tried[j].distance_m - tried[i].distance_m) > kTogether_m) continue;
      sum += share[j];
      first += share[j] * tried[j].distance_m;
    }
    if (sum <= best) continue;
    best = sum;
    mean_m = first / sum;
  }
  double variance = 0.0;
  for (std::size_t i = 0; i < tried.size(); ++i)
    variance += share[i] / all * std::pow(tried[i].distance_m - mean_m, 2.0);
  return {mean_m, std::sqrt(variance)};
}

}  // namespace kantaro::perception
