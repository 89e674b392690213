#pragma once

#include <string>

#include "scenarios/conditions.hpp"
#include "scenarios/mission_trace.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// A tee of 300 mm pipes: S (0, 0) -> M1 (4, 0), straight -> M2 (7, 0), tee -> E (11, 0), and B (7,
/// 4) -> M2 beside it. Shafts measure 800 mm, so the pipes are 3.2, 2.2, 3.2 and 3.2 m long. Pipe
/// "S-M1" has a crack at 1.5 m, 3 o'clock.
[[nodiscard]] network::Network TeeNetwork();

/// S to B over it, starting 0.5 m into the first pipe.
[[nodiscard]] Scenario TeeScenario();

/// The run of a robot that does it all right at 0.12 m/s: it follows the axes, turns on the spot in
/// M2, finds the crack and knows where it is to the centimetre. Made by geometry, without physics.
[[nodiscard]] MissionTrace PerfectMission();

}  // namespace kantaro::scenarios
