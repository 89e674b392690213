#include "scenarios/conditions.hpp"

#include <algorithm>

#include "base/random.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::scenarios {
namespace {

double Draw(std::uint64_t seed, const std::string& what, double low, double high) {
  return RandomStream(seed, "variation." + what).Uniform(low, high);
}

double DrawEitherWay(std::uint64_t seed, const std::string& what, double bound) {
  return Draw(seed, what, -bound, bound);
}

}  // namespace

Conditions DrawConditions(const Scenario& scenario, std::uint64_t seed) {
  const Variation& variation = scenario.variation;
  const network::Network& network = scenario.network;
  const double start_pipe_m =
      network::PipeAxis(network, network.PipeNamed(scenario.start.pipe)).length_m();
  Conditions conditions;
  conditions.seed = seed;
  conditions.start_chainage_m = std::clamp(
      scenario.start.chainage_m + DrawEitherWay(seed, "start_offset", variation.start_offset_m),
      0.0, start_pipe_m);
  conditions.start_yaw_rad = DrawEitherWay(seed, "start_yaw", variation.start_yaw_rad);
  if (variation.friction)
    conditions.friction = Draw(seed, "friction", variation.friction->low, variation.friction->high);
  conditions.friction_factor =
      Draw(seed, "friction_factor", variation.friction_factor.low, variation.friction_factor.high);
  const std::uint64_t texture_seed = variation.texture ? seed : 0;
  conditions.texture =
      RandomStream(texture_seed, "variation.texture").Index(std::uint64_t{1} << 32);
  conditions.light = Draw(seed, "light", variation.light.low, variation.light.high);
  conditions.stereo_yaw_error_rad =
      DrawEitherWay(seed, "stereo_yaw_error", variation.stereo_yaw_error_rad);
  conditions.motor_mismatch = DrawEitherWay(seed, "motor_mismatch", variation.motor_mismatch);
  // An old plan is wrong as a whole, by its scale, and a little differently in each pipe.
  const double scale_error =
      Draw(seed, "map_error", 0.6 * variation.map_error, 0.9 * variation.map_error);
  const bool too_long = Draw(seed, "map_error.sign", 0.0, 1.0) < 0.5;
  for (const network::Pipe& pipe : network.pipes) {
    conditions.map_scale[pipe.name] =
        1.0 + (too_long ? scale_error : -scale_error) +
        DrawEitherWay(seed, "map_error." + pipe.name, 0.1 * variation.map_error);
  }
  return conditions;
}

}  // namespace kantaro::scenarios
