#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "navigation/executive.hpp"
#include "tests/navigation/puppet.hpp"
#include "tests/navigation/sewers.hpp"

namespace kantaro::navigation {

inline perception::LaserObservation Windows(robot::RunTime at,
                                            const std::vector<perception::WindowEdge>& edges) {
  perception::LaserObservation laser;
  laser.captured_at = at;
  laser.edges = edges;
  return laser;
}

inline robot::RunTime At(double time_s) {
  return robot::RunTime(static_cast<robot::RunTime::rep>(time_s * 1e9));
}

inline Executive Robot(const network::Network& network, const std::vector<std::string>& manholes,
                       double map_factor = 1.0, double start_distance_m = 0.6) {
  std::map<std::string, double> factors;
  for (const network::Pipe& pipe : network.pipes) factors[pipe.name] = map_factor;
  return {MakeRoute(network, manholes, factors), start_distance_m, Kantaro(), ShippedParameters()};
}

/// Drives a route with a true map; the puppet tells what came of it.
inline Puppet Drive(const network::Network& network, const std::vector<std::string>& manholes,
                    const PuppetSetup& setup = {}, double map_factor = 1.0) {
  Puppet puppet(network, manholes, setup);
  Executive executive = Robot(network, manholes, map_factor, setup.start_distance_m);
  puppet.Drive(executive);
  return puppet;
}

}  // namespace kantaro::navigation
