#pragma once

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
  double distance_m{};      ///< from the wall of the manhole where the leg begins
};

/// One pipe as it is driven, with the manhole it ends in.
struct MapLeg {
  std::string pipe;
  bool downstream{true};              ///< driven with the flow
  double length_m{};                  ///< wall to wall, as the map has it: the truth may differ by some percent
  double diameter_m{};
  std::vector<MapLandmark> landmarks; ///< in driving order
  std::string end_manhole;
  double end_shaft_diameter_m{};
  network::ManholeKind end_kind{network::ManholeKind::kEnd};
  /// Turn to be made in the end manhole to reach the next leg [rad], positive to the left; absent on the last leg.
  std::optional<double> turn_rad;
  /// Centre-line radius of the channel for that turn [m]; 0 if straight.
  double channel_radius_m{};
};

/// A route as the robot knows it: a chain of legs.
struct MapRoute {
  std::string start_manhole;
  std::vector<MapLeg> legs;
};

/// How far the robot's map is from the truth.
struct MapError {
  /// Factor on every length, by pipe name; 1 where absent.
  std::vector<std::pair<std::string, double>> length_factor;
};

/// The map of a route. @throws std::invalid_argument if there is no route.
[[nodiscard]] MapRoute MakeRoute(const network::Network& network, const std::string& from, const std::string& to,
                                 const MapError& error);

}  // namespace kantaro::navigation
