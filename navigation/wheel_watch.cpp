#include "navigation/wheel_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kantaro::navigation {
namespace {

constexpr double kFastest_m_s = 0.5;  ///< twice what the motors can do
constexpr double kGrace_m = 0.02;     ///< of a single reading
constexpr double kLeastTold_m = 0.05;

}  // namespace

std::optional<std::string> WheelWatch::Feel(robot::RunTime at, double travel_m) {
  if (entries_.empty()) {
    entries_.push_back({at, 0.0, travel_m});
    return {};
  }
  const Entry& last = entries_.back();
  const double step_s = std::max(0.0, robot::Seconds(at - last.at));
  const double step_m = travel_m - last.felt_m;
  if (std::abs(step_m) > kFastest_m_s * step_s + kGrace_m) {
    return fmt::format("the encoders jumped by {:.2f} m", step_m);
  }
  entries_.push_back({at, last.told_m + told_m_s_ * step_s, travel_m});
  while (robot::Seconds(at - entries_.front().at) > window_s_) entries_.pop_front();
  const double told_m = entries_.back().told_m - entries_.front().told_m;
  const double felt_m = travel_m - entries_.front().felt_m;
  if (std::abs(told_m) < kLeastTold_m || felt_m * told_m > least_share_ * told_m * told_m)
    return {};
  return fmt::format("told to roll {:.2f} m, the wheels rolled {:.2f} m by their encoders", told_m,
                     felt_m);
}

}  // namespace kantaro::navigation
