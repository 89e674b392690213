#include "perception/laser_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace kantaro::perception {
namespace {

using std::numbers::pi;

constexpr double kFar = std::numeric_limits<double>::infinity();

// Of the openings past a PipeSlice.
/// So far beyond the circle there is no wall: more than any joint, or a robot swaying, makes.
constexpr double kOpening_m = 0.025;
/// A manhole whose benching reaches the crown opens all above its channel's walls: those are 25 mm
/// beyond the circle 34° above the side in a 250 mm pipe. A 150 mm inlet at the crown opens 74°.
constexpr double kTopHalfWidth_rad = 55.0 * pi / 180.0;
constexpr double kTopShare = 0.8;
constexpr double kSideReach_rad = 20.0 * pi / 180.0;
constexpr double kBranchBelow_rad = 10.0 * pi / 180.0;
constexpr double kBranchFloor_rad = 45.0 * pi / 180.0;
constexpr double kSideStep_rad = 2.5 * pi / 180.0;
/// Before the scanner's own far limit: three times its noise, and so many times the circle's.
constexpr double kReachMargin_m = 0.001;
constexpr double kDoubt = 3.0;

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
    const double off_rad = std::remainder(sample.angle_rad - middle_rad, 2 * pi);
    if (std::abs(off_rad) <= width_rad / 2) ranges_m.push_back(Range(sample));
  }
  if (ranges_m.empty()) return std::nullopt;
  const auto middle = ranges_m.begin() + static_cast<std::ptrdiff_t>(ranges_m.size() / 2);
  std::nth_element(ranges_m.begin(), middle, ranges_m.end());
  return *middle;
}

/// What the beams of a window say.
struct Votes {
  int open{}, known{}, all{};
  [[nodiscard]] bool Tell() const { return 2 * known >= all && known > 0; }
  [[nodiscard]] bool Agree(double share) const { return Tell() && open >= share * known; }
};

Votes CountOpen(const robot::LaserRevolution& revolution, const PipeSlice& slice, double middle_rad,
                double half_width_rad, double far_limit_m) {
  Votes votes;
  for (const robot::LaserSample& sample : revolution.samples) {
    if (std::abs(std::remainder(sample.angle_rad - middle_rad, 2 * pi)) > half_width_rad) continue;
    ++votes.all;
    const double wall_m = slice.RangeAt(sample.angle_rad);
    const bool far = sample.status == robot::RangeStatus::kTooFar;
    const double doubt_m = kReachMargin_m + kDoubt * slice.DeviationAt(sample.angle_rad);
    if (far && wall_m > far_limit_m - doubt_m) continue;
    ++votes.known;
    votes.open += far || sample.range_m > wall_m + kOpening_m ? 1 : 0;
  }
  return votes;
}

void ReadOpenings(const robot::LaserRevolution& revolution, const PipeSlice& wall,
                  const LaserParameters& parameters, LaserObservation& observation) {
  const auto count = [&](double middle_rad, double half_width_rad) {
    return CountOpen(revolution, wall, middle_rad, half_width_rad, parameters.far_limit_m);
  };
  const auto open = [&](double middle_rad, double half_width_rad, double share) {
    return count(middle_rad, half_width_rad).Agree(share);
  };
  const Votes top = count(pi / 2, kTopHalfWidth_rad);
  observation.top_known = top.Tell();
  observation.top_open = top.Agree(kTopShare);
  observation.left_known = count(pi, parameters.window_rad / 2).Tell();
  observation.right_known = count(0.0, parameters.window_rad / 2).Tell();
  const auto side = [&](double middle_rad, double down) {
    const double half_rad = parameters.window_rad / 2;
    if (observation.top_open) {
      // In a manhole the channel's walls part above the axis, all the more as the robot rolls;
      // below it they are the pipe's, and a branch is open there, too. Where the scanner hardly
      // reaches the wall, a robot that sways loses it: then the wall further down must be gone as
      // well.
      const auto below = [&](double angle_rad) {
        return open(middle_rad + down * angle_rad, half_rad, 0.5);
      };
      const bool in_reach = wall.RangeAt(middle_rad) < parameters.far_limit_m - kOpening_m;
      return below(kBranchBelow_rad) && (in_reach || below(kBranchFloor_rad));
    }
    for (double off = -kSideReach_rad; off <= kSideReach_rad + 1e-9; off += kSideStep_rad)
      if (open(middle_rad + off, half_rad, 0.5)) return true;
    return false;
  };
  observation.left_open = side(pi, 1.0);
  observation.right_open = side(0.0, -1.0);
  observation.left_known |= observation.left_open;
  observation.right_known |= observation.right_open;
}

/// How long before the end of a turn the mirror looks through each window, on average: the right
/// one is seen at both ends.
double LookBack(LaserWindow window) { return window == LaserWindow::kTop ? 0.75 : 0.5; }

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
                                            const LaserParameters& parameters,
                                            const std::optional<PipeSlice>& wall) {
  const auto right = WindowMedian(revolution, 0.0, parameters.window_rad);
  const auto top = WindowMedian(revolution, pi / 2, parameters.window_rad);
  const auto left = WindowMedian(revolution, pi, parameters.window_rad);
  if (!right || !top || !left) return std::nullopt;

  LaserObservation observation;
  observation.captured_at = captured_at;
  observation.top_open = *top > parameters.threshold_m;
  observation.left_open = *left > parameters.threshold_m;
  observation.right_open = *right > parameters.threshold_m;
  if (parameters.method == LaserMethod::kOurs && wall)
    ReadOpenings(revolution, *wall, parameters, observation);
  observation.status = ClassifyWindows(observation.top_open, observation.left_open,
                                       observation.right_open, *left, *right);
  observation.top_m = std::min(*top, parameters.far_limit_m);
  observation.left_m = std::min(*left, parameters.far_limit_m);
  observation.right_m = std::min(*right, parameters.far_limit_m);
  return observation;
}

LaserTracker::LaserTracker(int revolutions, robot::RunTime turn)
    : revolutions_(revolutions), turn_(turn), windows_{} {
  if (revolutions < 1) throw std::invalid_argument("a laser tracker needs at least one revolution");
}

std::vector<WindowEdge> LaserTracker::Update(const LaserObservation& observation) {
  const std::array<bool, 3> seen{observation.right_open, observation.top_open,
                                 observation.left_open};
  const std::array<bool, 3> known{observation.right_known, observation.top_known,
                                  observation.left_known};
  std::vector<WindowEdge> edges;
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    Window& window = windows_[i];
    if (!known[i]) continue;
    if (seen[i] == window.open) {
      window.run = 0;
      continue;
    }
    if (window.run++ == 0) window.since = observation.captured_at;
    if (window.run < revolutions_) continue;
    window.open = seen[i];
    window.run = 0;
    const auto which = static_cast<LaserWindow>(i);
    const auto ago = std::chrono::duration_cast<robot::RunTime>((LookBack(which) + 0.5) * turn_);
    edges.push_back({which, window.open, window.since - ago});
  }
  return edges;
}

bool LaserTracker::IsOpen(LaserWindow window) const {
  return windows_[static_cast<std::size_t>(window)].open;
}

}  // namespace kantaro::perception
