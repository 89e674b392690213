#include "perception/laser_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace kantaro::perception {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

double Range(const robot::LaserSample& sample) {
  switch (sample.status) {
    case robot::RangeStatus::kTooFar:
      return kFar;
    case robot::RangeStatus::kTooNear:
      return 0.0;
    case robot::RangeStatus::kValid:
      break;
  }
  return sample.range_m;
}

std::optional<double> WindowMedian(const robot::LaserRevolution& revolution, double middle_rad,
                                   double width_rad) {
  std::vector<double> ranges_m;
  for (const robot::LaserSample& sample : revolution.samples) {
    const double off_rad = std::remainder(sample.angle_rad - middle_rad, 2 * std::numbers::pi);
    if (std::abs(off_rad) <= width_rad / 2) ranges_m.push_back(Range(sample));
  }
  if (ranges_m.empty()) return std::nullopt;
  const auto middle = ranges_m.begin() + static_cast<std::ptrdiff_t>(ranges_m.size() / 2);
  std::nth_element(ranges_m.begin(), middle, ranges_m.end());
  return *middle;
}

}  // namespace

LaserStatus ClassifyWindows(bool top_open, bool left_open, bool right_open, double left_m,
                            double right_m) {
  if (top_open) {
    if (left_open && right_open) return LaserStatus::kOutsideThePipe;
    return left_open || right_open ? LaserStatus::kManholeWithJunction : LaserStatus::kManhole;
  }
  if (left_open && right_open) {
    return right_m > left_m ? LaserStatus::kInletRight : LaserStatus::kInletLeft;
  }
  if (left_open) return LaserStatus::kInletLeft;
  return right_open ? LaserStatus::kInletRight : LaserStatus::kNoLandmark;
}

std::optional<LaserObservation> ReadWindows(const robot::LaserRevolution& revolution,
                                            robot::RunTime captured_at,
                                            const LaserParameters& parameters) {
  const auto right = WindowMedian(revolution, 0.0, parameters.window_rad);
  const auto top = WindowMedian(revolution, std::numbers::pi / 2, parameters.window_rad);
  const auto left = WindowMedian(revolution, std::numbers::pi, parameters.window_rad);
  if (!right || !top || !left) return std::nullopt;

  LaserObservation observation;
  observation.captured_at = captured_at;
  observation.top_open = *top > parameters.threshold_m;
  observation.left_open = *left > parameters.threshold_m;
  observation.right_open = *right > parameters.threshold_m;
  observation.status = ClassifyWindows(observation.top_open, observation.left_open,
                                       observation.right_open, *left, *right);
  observation.top_m = std::min(*top, parameters.far_limit_m);
  observation.left_m = std::min(*left, parameters.far_limit_m);
  observation.right_m = std::min(*right, parameters.far_limit_m);
  return observation;
}

LaserTracker::LaserTracker(int revolutions) : revolutions_(revolutions), windows_{} {
  if (revolutions < 1) throw std::invalid_argument("a laser tracker needs at least one revolution");
}

std::vector<WindowEdge> LaserTracker::Update(const LaserObservation& observation) {
  const std::array<bool, 3> seen{observation.right_open, observation.top_open,
                                 observation.left_open};
  std::vector<WindowEdge> edges;
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    Window& window = windows_[i];
    if (seen[i] == window.open) {
      window.run = 0;
      continue;
    }
    if (window.run++ == 0) window.since = observation.captured_at;
    if (window.run < revolutions_) continue;
    window.open = seen[i];
    window.run = 0;
    edges.push_back({static_cast<LaserWindow>(i), window.open, window.since});
  }
  return edges;
}

bool LaserTracker::IsOpen(LaserWindow window) const {
  return windows_[static_cast<std::size_t>(window)].open;
}

}  // namespace kantaro::perception
