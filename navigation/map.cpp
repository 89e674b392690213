#include "navigation/map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "network/pipe_axis.hpp"

namespace kantaro::navigation {
namespace {

using network::Manhole;
using network::Network;
using network::Pipe;

/// Default centre-line radius of a curved channel, in shaft radii (as sewers are built here,
/// docs/network_format.md).
constexpr double kChannelRadiusRatio = 0.66;
/// Inlets within 1.5 h of the crown open the laser's top window, not a side.
constexpr double kHighest_h = 4.5;

std::vector<MapLandmark> Landmarks(const Pipe& pipe, bool downstream, double length_m,
                                   double factor) {
  std::vector<MapLandmark> landmarks;
  const auto add = [&](LandmarkKind kind, double chainage_m) {
    landmarks.push_back({kind, factor * (downstream ? chainage_m : length_m - chainage_m)});
  };
  for (const network::Joint& joint : pipe.joints) add(LandmarkKind::kJoint, joint.chainage_m);
  for (const network::Inlet& inlet : pipe.inlets) {
    if (std::abs(inlet.clock_h - 6.0) > kHighest_h) continue;
    const bool right = (inlet.clock_h < 6.0) == downstream;
    add(right ? LandmarkKind::kInletRight : LandmarkKind::kInletLeft, inlet.chainage_m);
  }
  std::stable_sort(
      landmarks.begin(), landmarks.end(),
      [](const MapLandmark& a, const MapLandmark& b) { return a.distance_m < b.distance_m; });
  return landmarks;
}

bool GoesStraightOn(const Network& network, const MapLeg& leg) {
  const Manhole& manhole = network.ManholeNamed(leg.end_manhole);
  const Pipe& from = network.PipeNamed(leg.pipe);
  const std::vector<std::size_t> pipes = network.PipesAt(manhole.name);
  return std::any_of(pipes.begin(), pipes.end(), [&](std::size_t to) {
    const double turn = network::TurnInto(network, manhole, from, network.pipes[to]);
    return std::abs(turn) < kStraightOn_rad;
  });
}

MapLeg MakeLeg(const Network& network, const network::RouteLeg& route_leg, double factor) {
  const Pipe& pipe = network.PipeNamed(route_leg.pipe);
  const double length_m = network::PipeAxis(network, pipe).length_m();
  MapLeg leg;
  leg.pipe = pipe.name;
  leg.downstream = route_leg.downstream;
  leg.length_m = factor * length_m;
  leg.diameter_m = pipe.diameter_m;
  leg.landmarks = Landmarks(pipe, leg.downstream, length_m, factor);
  leg.end_manhole = leg.downstream ? pipe.downstream : pipe.upstream;
  const Manhole& end = network.ManholeNamed(leg.end_manhole);
  leg.end_kind = network::KindOf(network, end);
  leg.end_shaft_radius_m = network.ShaftDiameter(end) / 2.0;
  leg.straight_on = GoesStraightOn(network, leg);
  return leg;
}

void PlanTurn(const Network& network, MapLeg& leg, const MapLeg& next) {
  const Manhole& manhole = network.ManholeNamed(leg.end_manhole);
  const double turn = network::TurnInto(network, manhole, network.PipeNamed(leg.pipe),
                                        network.PipeNamed(next.pipe));
  if (std::abs(turn) < kStraightOn_rad) return;
  leg.turn_rad = turn;
  const double wanted =
      manhole.channel_radius_m.value_or(kChannelRadiusRatio * leg.end_shaft_radius_m);
  leg.channel_radius_m = std::min(wanted, leg.end_shaft_radius_m / std::tan(std::abs(turn) / 2.0));
}

}  // namespace

double MapLeg::StraightBeforeTurn_m() const {
  return end_shaft_radius_m - channel_radius_m * std::tan(std::abs(turn_rad) / 2.0);
}

double MapLeg::ThroughManhole_m() const {
  return 2.0 * StraightBeforeTurn_m() + channel_radius_m * std::abs(turn_rad);
}

MapRoute MakeRoute(const Network& network, const std::vector<std::string>& manholes,
                   const std::map<std::string, double>& length_factor) {
  if (manholes.size() < 2) throw std::invalid_argument("a route needs a start and a goal");
  MapRoute route{manholes.front(), {}};
  const auto legs = network::ShortestRoute(network, manholes);
  if (legs.empty()) {
    throw std::invalid_argument(
        fmt::format("there is no way for the robot over {}", fmt::join(manholes, ", ")));
  }
  for (const network::RouteLeg& leg : legs) {
    const auto factor = length_factor.find(leg.pipe);
    route.legs.push_back(
        MakeLeg(network, leg, factor == length_factor.end() ? 1.0 : factor->second));
  }
  for (std::size_t i = 0; i + 1 < route.legs.size(); ++i)
    PlanTurn(network, route.legs[i], route.legs[i + 1]);
  return route;
}

}  // namespace kantaro::navigation
