#include "perception/laser_passage.hpp"

#include <algorithm>

#include "perception/laser_landmarks.hpp"

namespace kantaro::perception {
namespace {

constexpr int kShortestBranch = 8;  ///< times it fits into a shaft

}  // namespace

std::optional<PassedLandmark> LaserPassage::Update(const LaserObservation& observation) {
  for (const WindowEdge& edge : observation.edges) {
    Window& window = windows_[static_cast<std::size_t>(edge.window)];
    if (edge.open) {
      if (!window.opened) window.from = edge.at;
      window.since = edge.at;
    } else if (window.open) {
      window.to = edge.at;
      window.time += edge.at - window.since;
    }
    window.open = edge.open;
    window.opened = window.opened || edge.open;
  }
  const auto is_open = [](const Window& window) { return window.open; };
  const auto was_open = [](const Window& window) { return window.opened; };
  if (std::ranges::any_of(windows_, is_open) || std::ranges::none_of(windows_, was_open)) return {};

  auto& [right, top, left] = windows_;
  for (Window* side : {&right, &left})
    side->opened = side->opened && (!top.opened || kShortestBranch * side->time >= top.time);
  PassedLandmark passed;
  passed.kind = ClassifyWindows(top.opened, left.opened, right.opened, robot::Seconds(left.time),
                                robot::Seconds(right.time));
  const Window& place = top.opened ? top : passed.kind == LaserStatus::kInletLeft ? left : right;
  passed.opened_at = place.from;
  passed.closed_at = place.to;
  windows_ = {};
  return passed;
}

}  // namespace kantaro::perception
