#include "scenarios/twin_conditions.hpp"

#include <algorithm>

namespace kantaro::scenarios {

sim::Conditions TwinConditions(const Scenario& scenario, const Conditions& conditions) {
  const std::vector<network::RouteLeg> route = PlannedRoute(scenario);
  sim::Conditions twin;
  twin.start = {scenario.start.pipe, conditions.start_chainage_m, route.front().downstream, 0.0,
                conditions.start_yaw_rad};
  twin.seed = conditions.seed;
  twin.wheel_friction = conditions.friction;
  twin.friction_factor = conditions.friction_factor;
  twin.left_right_mismatch = conditions.motor_mismatch;
  twin.light = conditions.light * scenario.cameras.illumination;
  twin.cameras = {conditions.stereo_yaw_error_rad, scenario.cameras.drops_on_lens,
                  scenario.cameras.dropped_share, scenario.cameras.exposure_factor,
                  scenario.cameras.gain_factor};
  // For the widest pipe of the route: set lower, its crown would lie beyond the laser's threshold.
  twin.mast_diameter_m = 0.0;
  for (const network::RouteLeg& leg : route) {
    twin.mast_diameter_m =
        std::max(twin.mast_diameter_m, scenario.network.PipeNamed(leg.pipe).diameter_m);
  }
  twin.battery_charge = scenario.battery_charge;
  twin.time_limit_s = scenario.time_limit_s;
  return twin;
}

}  // namespace kantaro::scenarios
