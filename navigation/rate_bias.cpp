#include "navigation/rate_bias.hpp"

#include <algorithm>
#include <vector>

namespace kantaro::navigation {

void RateBias::Learn(robot::RunTime at, double rate_rad_s) {
  if (count_ == 0) began_ = at;
  sum_rad_s_ += rate_rad_s;
  ++count_;
  if (robot::Seconds(at - began_) < kMean_s) return;
  means_rad_s_.push_back(sum_rad_s_ / count_);
  if (means_rad_s_.size() > kMost) means_rad_s_.pop_front();
  sum_rad_s_ = 0.0;
  count_ = 0;
  if (means_rad_s_.size() < kLeast) return;
  std::vector<double> sorted(means_rad_s_.begin(), means_rad_s_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  bias_rad_s_ = *middle;
}

}  // namespace kantaro::navigation
