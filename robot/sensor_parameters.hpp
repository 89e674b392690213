#pragma once

#include <map>

#include "base/yaml.hpp"

namespace kantaro::robot {

/// Gyro and accelerometer, every axis alike. What they say is the truth, a bias that is drawn when
/// they are switched on, the gyro's slow wandering of it, and white noise; cut at the range.
struct InertialUnit {
  double rate_Hz{};
  double gyro_noise_rad_s{};  ///< standard deviation of one reading
  double gyro_bias_rad_s{};   ///< standard deviation of the bias at power-on
  double gyro_walk_rad_s{};   ///< and of its change within one second (random walk)
  double gyro_range_rad_s{};  ///< ±
  double accelerometer_noise_m_s2{};
  double accelerometer_bias_m_s2{};
  double accelerometer_range_m_s2{};  ///< ±
};

/// A damped pendulum: it follows the apparent gravity, and so each acceleration, with a lag.
struct Inclinometer {
  double rate_Hz{};
  double lag_s{};           ///< time constant
  double noise_rad{};       ///< standard deviation
  double resolution_rad{};  ///< step of what it says
  double range_rad{};       ///< ±
};

/// A magnetometer of three axes that knows how strong the earth's field is.
struct Compass {
  double rate_Hz{};
  double noise_rad{};           ///< standard deviation of the heading
  double strength_tolerance{};  ///< a field that is off by a larger share is said to be disturbed
  double earth_horizontal_T{};  ///< the earth's field where the robot drives
  double earth_down_T{};
  double motor_field_T_per_A{};  ///< along −By, for each ampere that the motors draw
};

/// The pack, and what draws from it.
struct Battery {
  double rate_Hz{};
  double capacity_As{};
  double resistance_ohm{};
  /// Open-circuit voltage by charge, from 0 to 1; straight lines in between.
  std::map<double, double> voltage_V;
  double cutoff_V{};                ///< below it the pack switches itself off
  double electronics_W{};           ///< computer, controller, cameras
  double laser_W{};                 ///< while its mirror turns
  double lights_W{};                ///< all LEDs at full brightness
  double motor_efficiency{};        ///< of gear and bridge, 0 to 1
  double motor_copper_W_per_Nm2{};  ///< lost in a winding for each square newton metre at the wheel
  double motor_idle_W{};            ///< of each motor's bridge and encoder

  /// Straight between the points. @param charge  0 to 1
  [[nodiscard]] double OpenVoltage(double charge) const;
};

/// Each reads one section of the companion file, strictly. @throws InputError
[[nodiscard]] InertialUnit ReadInertialUnit(const YamlNode& node);
[[nodiscard]] Inclinometer ReadInclinometer(const YamlNode& node);
[[nodiscard]] Compass ReadCompass(const YamlNode& node);
[[nodiscard]] Battery ReadBattery(const YamlNode& node);

}  // namespace kantaro::robot
