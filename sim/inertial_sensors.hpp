#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/random.hpp"
#include "robot/readings.hpp"
#include "robot/sensor_parameters.hpp"

namespace kantaro::sim {

/// Gyro and accelerometer. The bias is drawn at power-on; the gyro's wanders from reading to
/// reading.
class InertialSensor {
 public:
  InertialSensor(const robot::InertialUnit& unit, std::uint64_t seed);

  /// @param turning_rad_s  of B in W, in B. @param force_m_s2  specific force, in B. Once for each
  /// reading.
  [[nodiscard]] robot::InertialReading Measure(const Eigen::Vector3d& turning_rad_s,
                                               const Eigen::Vector3d& force_m_s2);
  /// What the gyro says at rest, without its noise.
  [[nodiscard]] const Eigen::Vector3d& gyro_bias_rad_s() const { return gyro_bias_rad_s_; }

 private:
  robot::InertialUnit unit_;
  RandomStream noise_, wandering_;
  Eigen::Vector3d gyro_bias_rad_s_, accelerometer_bias_m_s2_;
};

/// A damped pendulum of two axes, without inertia of its own: what it hangs along follows the
/// apparent gravity with one time constant.
class InclinationSensor {
 public:
  InclinationSensor(const robot::Inclinometer& inclinometer, std::uint64_t seed);

  /// @param force_m_s2  specific force in B over the next `step_s`. The first hangs it up at rest.
  void Follow(const Eigen::Vector3d& force_m_s2, double step_s);
  /// @throws std::logic_error before it was hung up.
  [[nodiscard]] robot::Inclination Measure();

 private:
  [[nodiscard]] double Told(double angle_rad);

  robot::Inclinometer inclinometer_;
  RandomStream noise_;
  Eigen::Vector3d hangs_along_{Eigen::Vector3d::Zero()};
};

}  // namespace kantaro::sim
