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
constexpr double kSquareWithin = 30.0 * std::numbers::pi / 180.0;
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

/// Walking distance to each manhole from the nearest of some, infinite if out of reach (Dijkstra).
std::vector<double> WalkFrom(const Network& network, const NetworkIndex& index,
                             const std::vector<std::size_t>& starts) {
  std::vector<double> distances_m(network.manholes.size(), kInfinity);
  using Stop = std::pair<double, std::size_t>;
  std::priority_queue<Stop, std::vector<Stop>, std::greater<>> open;
  for (const std::size_t start : starts) {
    distances_m[start] = 0.0;
    open.emplace(0.0, start);
  }
  while (!open.empty()) {
    const auto [distance_m, manhole] = open.top();
    open.pop();
    if (distance_m > distances_m[manhole]) continue;
    for (const std::size_t pipe : index.pipes_at[manhole]) {
      const std::size_t other = OtherEnd(index, pipe, manhole);
      const double there_m = distance_m + WalkingLength(network, index, pipe);
      if (there_m >= distances_m[other]) continue;
      distances_m[other] = there_m;
      open.emplace(there_m, other);
    }
  }
  return distances_m;
}

/// Horizontal unit direction in which a pipe leaves one of its manholes for the other.
Eigen::Vector2d Direction(const Pipe& pipe, const Manhole& from, const Manhole& to) {
  Eigen::Vector2d next = to.p_WM.head<2>();
  if (!pipe.bends.empty()) {
    next = pipe.upstream == from.name ? pipe.bends.front().p_W : pipe.bends.back().p_W;
  }
  return (next - from.p_WM.head<2>()).normalized();
}

bool RunStraight(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.dot(b) <= -std::cos(kStraightWithin);
}

/// Two of three run straight through, the third leaves about square to them.
bool IsTee(const std::vector<Eigen::Vector2d>& directions) {
  for (std::size_t branch = 0; branch < 3; ++branch) {
    const Eigen::Vector2d &a = directions[(branch + 1) % 3], &b = directions[(branch + 2) % 3];
    if (!RunStraight(a, b)) continue;
    if (std::abs((a - b).normalized().dot(directions[branch])) <= std::sin(kSquareWithin)) {
      return true;
    }
  }
  return false;
}

ManholeKind KindBy(const std::vector<Eigen::Vector2d>& directions) {
  switch (directions.size()) {
    case 1:
      return ManholeKind::kEnd;
    case 2:
      return RunStraight(directions[0], directions[1]) ? ManholeKind::kStraight
                                                       : ManholeKind::kCurve;
    case 3:
      return IsTee(directions) ? ManholeKind::kTee : ManholeKind::kWye;
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

double TurnFrom(const Eigen::Vector2d& in, const Eigen::Vector2d& out) {
  return std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
}

/// Dijkstra's algorithm over pipes driven one way or the other, because where one may turn depends
/// on where one comes from; and over how many of the stops are behind.
class RouteFinder {
 public:
  RouteFinder(const Network& network, const NetworkIndex& index,
              const std::vector<std::size_t>& stops, Turns turns)
      : network_(network),
        index_(index),
        stops_(stops),
        turns_(turns),
        distances_m_(2 * network.pipes.size() * stops.size(), kInfinity),
        came_from_(distances_m_.size()) {}

  std::vector<RouteLeg> Find() {
    Leave(stops_.front(), 0, 0.0, std::nullopt);
    while (!open_.empty()) {
      const auto [distance_m, drive] = open_.top();
      open_.pop();
      if (distance_m > distances_m_[drive]) continue;
      if (Passed(drive) + 1 == stops_.size()) return WayTo(drive);
      Leave(EndOf(drive), Passed(drive), distance_m, drive);
    }
    return {};
  }

 private:
  // A drive is numbered by the stops passed at its end, its pipe, and whether it goes downstream.
  [[nodiscard]] std::size_t Passed(std::size_t drive) const {
    return drive / (2 * network_.pipes.size());
  }
  [[nodiscard]] std::size_t PipeOf(std::size_t drive) const {
    return drive / 2 % network_.pipes.size();
  }
  [[nodiscard]] std::size_t EndOf(std::size_t drive) const {
    return drive % 2 == 1 ? index_.downstream[PipeOf(drive)] : index_.upstream[PipeOf(drive)];
  }

  void Leave(std::size_t manhole, std::size_t passed, double distance_m,
             std::optional<std::size_t> arrived_by) {
    for (const std::size_t pipe : index_.pipes_at[manhole]) {
      if (!IsEnterable(network_.pipes[pipe])) continue;
      if (arrived_by && !MayTurn(PipeOf(*arrived_by), pipe, manhole)) continue;
      const std::size_t end = OtherEnd(index_, pipe, manhole);
      const std::size_t passed_then = end == stops_[passed + 1] ? passed + 1 : passed;
      const std::size_t drive = (passed_then * network_.pipes.size() + pipe) * 2 +
                                (index_.downstream[pipe] == end ? 1 : 0);
      const double there_m = distance_m + WalkingLength(network_, index_, pipe);
      if (there_m >= distances_m_[drive]) continue;
      distances_m_[drive] = there_m;
      came_from_[drive] = arrived_by;
      open_.emplace(there_m, drive);
    }
  }

  [[nodiscard]] bool MayTurn(std::size_t from, std::size_t into, std::size_t manhole) const {
    if (turns_ == Turns::kAny) return true;
    const auto leaving = [&](std::size_t pipe) {
      return Direction(network_.pipes[pipe], network_.manholes[manhole],
                       network_.manholes[OtherEnd(index_, pipe, manhole)]);
    };
    // A hair of grace for drawings that mean 120°.
    return std::abs(TurnFrom(-leaving(from), leaving(into))) <= kSharpestTurn_rad + 1e-9;
  }

  [[nodiscard]] std::vector<RouteLeg> WayTo(std::size_t goal) const {
    std::vector<RouteLeg> route;
    for (std::optional<std::size_t> drive = goal; drive; drive = came_from_[*drive]) {
      route.push_back({network_.pipes[PipeOf(*drive)].name, *drive % 2 == 1});
    }
    std::reverse(route.begin(), route.end());
    return route;
  }

  const Network& network_;
  const NetworkIndex& index_;
  const std::vector<std::size_t>& stops_;
  Turns turns_;
  std::vector<double> distances_m_;
  std::vector<std::optional<std::size_t>> came_from_;
  std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                      std::greater<>>
      open_;
};

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
    case ManholeKind::kWye:
      return "wye";
    case ManholeKind::kCross:
      return "cross";
    case ManholeKind::kOther:
      break;
  }
  return "other";
}

double TurnInto(const Network& network, const Manhole& manhole, const Pipe& arriving,
                const Pipe& leaving) {
  return TurnFrom(-DirectionFrom(network, arriving, manhole),
                  DirectionFrom(network, leaving, manhole));
}

std::vector<RouteLeg> ShortestRoute(const Network& network,
                                    const std::vector<std::string>& manholes, Turns turns) {
  const NetworkIndex index(network);
  std::vector<std::size_t> stops;
  for (const std::string& name : manholes) {
    const std::size_t stop = IndexOf(index, name);
    if (stops.empty() || stops.back() != stop) stops.push_back(stop);
  }
  if (stops.size() < 2) return {};
  return RouteFinder(network, index, stops, turns).Find();
}

const std::string& EndOf(const Network& network, const RouteLeg& leg) {
  const Pipe& pipe = network.PipeNamed(leg.pipe);
  return leg.downstream ? pipe.downstream : pipe.upstream;
}

Network Neighbourhood(const Network& network, const std::vector<std::string>& manholes,
                      double reach_m) {
  const NetworkIndex index(network);
  std::vector<std::size_t> starts;
  starts.reserve(manholes.size());
  for (const std::string& name : manholes) starts.push_back(IndexOf(index, name));
  const std::vector<double> distances_m = WalkFrom(network, index, starts);

  Network part;
  part.name = network.name;
  part.remarks = network.remarks;
  std::vector<bool> wanted(network.manholes.size(), false);
  for (const std::size_t start : starts) wanted[start] = true;
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const std::size_t up = index.upstream[i], down = index.downstream[i];
    if (std::min(distances_m[up], distances_m[down]) > reach_m) continue;
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
