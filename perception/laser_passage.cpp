#include "perception/laser_passage.hpp"

#include <algorithm>
#include <cmath>

#include "perception/laser_landmarks.hpp"

namespace kantaro::perception {
namespace {

constexpr double kShortestBranch = 0.2;  ///< of what was seen of a shaft's side
constexpr double kShortest_m = 0.05;     ///< half the narrowest inlet

}  // namespace

std::optional<PassedLandmark> LaserPassage::Update(const LaserObservation& observation,
                                                   double travelled_m) {
  const auto is_open = [](const Window& window) { return window.open; };
  const auto was_open = [](const Window& window) { return window.opened; };
  const double step_m = std::abs(travelled_m - last_m_.value_or(travelled_m));
  last_m_ = travelled_m;
  if (std::ranges::any_of(windows_, is_open)) {
    const std::array known{observation.right_known, observation.top_known, observation.left_known};
    for (std::size_t i = 0; i < windows_.size(); ++i) {
      if (!known[i]) continue;
      windows_[i].seen_m += step_m;
      if (windows_[i].open) windows_[i].open_m += step_m;
    }
  }
  for (const WindowEdge& edge : observation.edges) {
    Window& window = windows_[static_cast<std::size_t>(edge.window)];
    if (edge.open) {
      if (!window.opened) {
        window.from = edge.at;
        window.from_m = travelled_m;
      }
    } else if (window.open) {
      window.to = edge.at;
      window.to_m = travelled_m;
    }
    window.open = edge.open;
    window.opened = window.opened || edge.open;
  }
  if (std::ranges::any_of(windows_, is_open) || std::ranges::none_of(windows_, was_open)) return {};

  auto& [right, top, left] = windows_;
  for (Window* side : {&right, &left})
    side->opened = side->opened && (!top.opened || side->open_m >= kShortestBranch * side->seen_m);
  PassedLandmark passed;
  passed.kind = ClassifyWindows(top.opened, left.opened, right.opened, left.open_m, right.open_m);
  const Window& place = top.opened ? top : passed.kind == LaserStatus::kInletLeft ? left : right;
  passed.opened_at = place.from;
  passed.closed_at = place.to;
  const bool long_enough = std::abs(place.to_m - place.from_m) >= kShortest_m;
  windows_ = {};
  if (!long_enough) return {};
  return passed;
}

}  // namespace kantaro::perception
