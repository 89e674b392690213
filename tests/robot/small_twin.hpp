#pragma once

#include <memory>

#include "network/formats.hpp"
#include "sim/twin.hpp"

namespace kantaro::robot {

/// The twin in the shortest sewer there is, with ten seconds to live.
template <bool cameras>
std::unique_ptr<Hardware> MakeSmallTwin() {
  static const sim::World world = sim::BuildWorld(
      network::ReadNetwork(KANTARO_SOURCE_DIR "/tests/apps/short_network.yaml"), 1, cameras);
  sim::Conditions conditions;
  conditions.start = {"P", 0.8, true, 0.0, 0.0};
  conditions.time_limit_s = 10.0;
  return std::make_unique<sim::Twin>(world, ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro"),
                                     conditions);
}

}  // namespace kantaro::robot
