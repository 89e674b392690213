#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "network/network.hpp"
#include "network/topology.hpp"

namespace kantaro::navigation {

enum class LandmarkKind { kJoint, kInletLeft, kInletRight };

/// A landmark of a pipe in driving direction.
struct MapLandmark {
  LandmarkKind kind{LandmarkKind::kJoint};
  double distance_m{};  ///< from the wall of the manhole where the leg begins
};

/// One pipe as it is driven, with the manhole it ends in.
struct MapLeg {
  std::string pipe;
  bool downstream{true};  ///< driven with the flow
  double length_m{};      ///< wall to wall, as the map has it: the truth may differ by some percent
  double diameter_m{};
  std::vector<MapLandmark> landmarks;  ///< in driving order
  std::string end_manhole;
  network::ManholeKind end_kind{network::ManholeKind::kEnd};
  double end_shaft_radius_m{};
  bool straight_on{};  ///< some pipe leaves the end manhole straight ahead, wherever the route goes
  /// Turn to be made in the end manhole to reach the next leg [rad], positive to the left; 0 on the
  /// last leg.
  double turn_rad{};
  double channel_radius_m{};  ///< of the centre line of the channel for that turn; 0 if straight

  /// Length of the channel through the end manhole, from wall to wall.
  [[nodiscard]] double ThroughManhole_m() const;
  /// From the wall to where the channel begins to bend.
  [[nodiscard]] double StraightBeforeTurn_m() const;
};

/// A route as the robot knows it: a chain of legs.
struct MapRoute {
  std::string start_manhole;
  std::vector<MapLeg> legs;
};

/// Turns below this are driven straight on.
inline constexpr double kStraightOn_rad = 0.26;

/// The map of a route from manhole to manhole, over the manholes in between if any are named.
/// Lengths and landmark distances of a pipe are multiplied by its `length_factor` (1 where absent):
/// real maps are some percent off.
/// @throws std::invalid_argument if there is no way (see network::ShortestRoute); std::out_of_range
/// for unknown names.
[[nodiscard]] MapRoute MakeRoute(const network::Network& network,
                                 const std::vector<std::string>& manholes,
                                 const std::map<std::string, double>& length_factor);

}  // namespace kantaro::navigation
