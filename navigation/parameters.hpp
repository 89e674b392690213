#pragma once

#include <filesystem>
#include <string>

#include "robot/description.hpp"

namespace kantaro::navigation {

/// Where the sensors and axles sit along the robot [m from the base's origin, positive forward].
struct RobotGeometry {
  double laser_x_m{};
  double infrared_x_m{};
  double camera_x_m{};
  double front_axle_x_m{};
  double tyre_radius_m{};  ///< nominal: wheel speed = speed / radius

  [[nodiscard]] static RobotGeometry Of(const robot::Description& description);
};

/// The executive remembers the wheels' travel of so long.
inline constexpr double kTravelMemory_s = 2.0;

/// models/kantaro/navigation.yaml: what each number is for stands there.
struct Parameters {
  double cruise_m_s{}, approach_m_s{}, reverse_m_s{}, turn_m_s{};
  double approach_distance_m{};  ///< before the end wall: slow down
  double gate_deviations{};
  double turn_ratio{};          ///< inner wheels run at (1 − ratio), outer at (1 + ratio)
  double turn_easing_rad{};     ///< the ratio fades over the last so much of the turn
  double upright_gain{};        ///< steering (share of speed) per roll [1/rad]
  double upright_damping_s{};   ///< and per roll rate [s/rad]
  double heading_gain{};        ///< steering per heading error while crossing a manhole [1/rad]
  double turn_lead_m{};         ///< steering begins this far before the front axle reaches the bend
  double turn_tolerance_rad{};  ///< the turn ends this much short of its angle: the channel does
                                ///< the rest
  double map_error{};           ///< standard deviation of a pipe's length over its length
  double travel_error{};  ///< of the wheels' travel over the travel: slip that is not constant
  double scale_error{};   ///< of the constant part, before anything was learned
  double start_error_m{};
  double wall_error_m{};  ///< of a shaft wall found by laser or IR
  double inlet_error_m{};
  double ring_error_m{};  ///< of a ring's distance in the camera, at 1 m; grows with the distance
  double silence_s{};     ///< a sensor that says nothing for so long is taken as lost
  double wheel_silence_s{};    ///< encoders; without them the robot stops
  double gyro_silence_s{};     ///< without a gyro it does not turn
  double stale_s{};            ///< what laser, IR or camera saw longer ago is not used
  double wheel_window_s{};     ///< encoders are compared with the command over so long
  double least_wheel_share{};  ///< of the way told
  double gyro_bias_rad_s{};    ///< a gyro that is off by more is not believed
  double longest_inlet_m{};    ///< an opening that closes again within so much is no manhole's
  double longest_opening_m{};  ///< a sensor to which the crown is gone for longer is not believed
  double reverse_slip{};       ///< share of the way back that may be the wheels' spinning
  double spinning_m{};         ///< backing up: how much farther than it should take, at most
  double battery_reserve{};    ///< charge, 0 to 1, at which the robot stops
};

/// @throws InputError
[[nodiscard]] Parameters ReadParameters(const std::filesystem::path& file);
/// The same from text; complaints name `name` as the file.
[[nodiscard]] Parameters ParseParameters(const std::string& text,
                                         const std::filesystem::path& name);

}  // namespace kantaro::navigation
