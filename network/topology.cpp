#include "network/topology.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <stdexcept>
#include <utility>

#include "network/network_index.hpp"

namespace kantaro::network {
namespace {

constexpr double kStraightWithin = 15.0 * std::numbers::pi / 180.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Way from manhole centre to manhole centre along the drawing, corners not rounded.
double WalkingLength(const Network& network, const NetworkIndex& index, std::size_t pipe) {
  Eigen::Vector2d from = network.manholes[index.upstream[pipe]].p_WM.head<2>();
  double length_m = 0.0;
  for (const Bend& bend : network.pipes[pipe].bends) {
    length_m += (bend.p_W - from).norm();
    from = bend.p_W;
  }
  return length_m + (network.manholes[index.downstream[pipe]].p_WM.head<2>() - from).norm();
}

std::size_t OtherEnd(const NetworkIndex& index, std::size_t pipe, std::size_t manhole) {
  return index.upstream[pipe] == manhole ? index.downstream[pipe] : index.upstream[pipe];
}

struct Walk {
  std::vector<double> distance_m;                   // to each manhole, infinite if out of reach
  std::vector<std::optional<std::size_t>> came_by;  // the pipe it is reached through
};

/// Dijkstra's algorithm. Of equally short ways the one by earlier manholes wins, on every machine.
Walk WalkFrom(const Network& network, const NetworkIndex& index,
              const std::vector<std::size_t>& starts, bool enterable_only) {
  Walk walk{std::vector<double>(network.manholes.size(), kInfinity),
            std::vector<std::optional<std::size_t>>(network.manholes.size())};
  using Stop = std::pair<double, std::size_t>;
  std::priority_queue<Stop, std::vector<Stop>, std::greater<>> open;
  for (const std::size_t start : starts) {
    walk.distance_m[start] = 0.0;
    open.emplace(0.0, start);
  }
  while (!open.empty()) {
    const auto [distance_m, manhole] = open.top();
    open.pop();
    if (distance_m > walk.distance_m[manhole]) continue;
    for (const std::size_t pipe : index.pipes_at[manhole]) {
      if (enterable_only && !IsEnterable(network.pipes[pipe])) continue;
      const std::size_t other = OtherEnd(index, pipe, manhole);
      const double there_m = distance_m + WalkingLength(network, index, pipe);
      if (there_m >= walk.distance_m[other]) continue;
      walk.distance_m[other] = there_m;
      walk.came_by[other] = pipe;
      open.emplace(there_m, other);
    }
  }
  return walk;
}

/// Horizontal unit direction in which a pipe leaves one of its manholes for the other.
Eigen::Vector2d Direction(const Pipe& pipe, const Manhole& from, const Manhole& to) {
  Eigen::Vector2d next = to.p_WM.head<2>();
  if (!pipe.bends.empty()) {
    next = pipe.upstream == from.name ? pipe.bends.front().p_W : pipe.bends.back().p_W;
  }
  return (next - from.p_WM.head<2>()).normalized();
}

ManholeKind KindBy(const std::vector<Eigen::Vector2d>& directions) {
  switch (directions.size()) {
    case 1:
      return ManholeKind::kEnd;
    case 2:
      return directions[0].dot(directions[1]) <= -std::cos(kStraightWithin) ? ManholeKind::kStraight
                                                                            : ManholeKind::kCurve;
    case 3:
      return ManholeKind::kTee;
    case 4:
      return ManholeKind::kCross;
    default:
      return ManholeKind::kOther;
  }
}

std::size_t IndexOf(const NetworkIndex& index, const std::string& manhole) {
  const auto found = index.manholes.find(manhole);
  if (found == index.manholes.end()) throw std::out_of_range("no manhole is named " + manhole);
  return found->second;
}

}  // namespace

Eigen::Vector2d DirectionFrom(const Network& network, const Pipe& pipe, const Manhole& manhole) {
  const bool leaves = pipe.upstream == manhole.name;
  return Direction(pipe, manhole, network.ManholeNamed(leaves ? pipe.downstream : pipe.upstream));
}

ManholeKind KindOf(const Network& network, const Manhole& manhole) {
  std::vector<Eigen::Vector2d> directions;
  for (const std::size_t pipe : network.PipesAt(manhole.name)) {
    directions.push_back(DirectionFrom(network, network.pipes[pipe], manhole));
  }
  return KindBy(directions);
}

ManholeKind KindOf(const Network& network, const NetworkIndex& index, std::size_t manhole) {
  std::vector<Eigen::Vector2d> directions;
  for (const std::size_t pipe : index.pipes_at[manhole]) {
    directions.push_back(Direction(network.pipes[pipe], network.manholes[manhole],
                                   network.manholes[OtherEnd(index, pipe, manhole)]));
  }
  return KindBy(directions);
}

std::string ToString(ManholeKind kind) {
  switch (kind) {
    case ManholeKind::kEnd:
      return "end";
    case ManholeKind::kStraight:
      return "straight";
    case ManholeKind::kCurve:
      return "curve";
    case ManholeKind::kTee:
      return "tee";
    case ManholeKind::kCross:
      return "cross";
    case ManholeKind::kOther:
      break;
  }
  return "other";
}

std::vector<RouteLeg> ShortestRoute(const Network& network, const std::string& from,
                                    const std::string& to) {
  const NetworkIndex index(network);
  const std::size_t start = IndexOf(index, from), goal = IndexOf(index, to);
  const Walk walk = WalkFrom(network, index, {start}, /*enterable_only=*/true);
  std::vector<RouteLeg> route;
  for (std::size_t at = goal; walk.came_by[at];) {
    const std::size_t pipe = *walk.came_by[at];
    const bool downstream = index.downstream[pipe] == at;
    route.push_back({network.pipes[pipe].name, downstream});
    at = downstream ? index.upstream[pipe] : index.downstream[pipe];
  }
  std::reverse(route.begin(), route.end());
  return route;
}

Network Neighbourhood(const Network& network, const std::vector<std::string>& manholes,
                      double reach_m) {
  const NetworkIndex index(network);
  std::vector<std::size_t> starts;
  starts.reserve(manholes.size());
  for (const std::string& name : manholes) starts.push_back(IndexOf(index, name));
  const Walk walk = WalkFrom(network, index, starts, /*enterable_only=*/false);

  Network part;
  part.name = network.name;
  part.remarks = network.remarks;
  std::vector<bool> wanted(network.manholes.size(), false);
  for (const std::size_t start : starts) wanted[start] = true;
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const std::size_t up = index.upstream[i], down = index.downstream[i];
    if (std::min(walk.distance_m[up], walk.distance_m[down]) > reach_m) continue;
    wanted[up] = wanted[down] = true;
    part.pipes.push_back(network.pipes[i]);
  }
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    if (!wanted[i]) continue;
    part.manholes.push_back(network.manholes[i]);
    // The default goes by the largest pipe there, which may have been left out.
    part.manholes.back().shaft_diameter_m = index.shaft_diameter_m[i];
  }
  for (const SkippedLink& link : network.skipped) {
    const auto up = index.manholes.find(link.upstream), down = index.manholes.find(link.downstream);
    if (up != index.manholes.end() && down != index.manholes.end() && wanted[up->second] &&
        wanted[down->second]) {
      part.skipped.push_back(link);
    }
  }
  return part;
}

}  // namespace kantaro::network
