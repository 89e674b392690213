#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// What one seed makes of a scenario's variation. Each value has its own random stream, so that a
/// new kind of variation moves no other.
struct Conditions {
  std::uint64_t seed{};
  double start_chainage_m{};       ///< the scenario's, moved; inside the pipe
  double start_yaw_rad{};          ///< against the way of travel, positive to the left
  std::optional<double> friction;  ///< tyre on wall, everywhere; absent: the ground's
  double friction_factor{1.0};     ///< times the ground's friction
  std::uint64_t texture{};         ///< seed of the wall's look
  double light{1.0};               ///< brightness of the robot's lights against their nominal
  double stereo_yaw_error_rad{};   ///< of the right camera against its calibration
  /// The robot's map: for each pipe of the network, by name, mapped length / true length.
  std::map<std::string, double> map_scale;
  double motor_mismatch{};  ///< left motors turn this share faster than told, right ones slower
};

[[nodiscard]] Conditions DrawConditions(const Scenario& scenario, std::uint64_t seed);

}  // namespace kantaro::scenarios
