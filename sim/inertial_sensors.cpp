#include "sim/inertial_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::sim {
namespace {

Eigen::Vector3d Draw(RandomStream& stream, double deviation) {
  Eigen::Vector3d drawn;
  for (int i = 0; i < 3; ++i) drawn[i] = stream.Normal(deviation);
  return drawn;
}

Eigen::Vector3d Cut(const Eigen::Vector3d& value, double range) {
  return value.cwiseMax(-range).cwiseMin(range);
}

}  // namespace

InertialSensor::InertialSensor(const robot::InertialUnit& unit, std::uint64_t seed)
    : unit_(unit), noise_(seed, "sensor.inertial"), wandering_(seed, "sensor.inertial.bias") {
  gyro_bias_rad_s_ = Draw(wandering_, unit.gyro_bias_rad_s);
  accelerometer_bias_m_s2_ = Draw(wandering_, unit.accelerometer_bias_m_s2);
}

robot::InertialReading InertialSensor::Measure(const Eigen::Vector3d& turning_rad_s,
                                               const Eigen::Vector3d& force_m_s2) {
  gyro_bias_rad_s_ += Draw(wandering_, unit_.gyro_walk_rad_s / std::sqrt(unit_.rate_Hz));
  const Eigen::Vector3d turning =
      turning_rad_s + gyro_bias_rad_s_ + Draw(noise_, unit_.gyro_noise_rad_s);
  const Eigen::Vector3d force =
      force_m_s2 + accelerometer_bias_m_s2_ + Draw(noise_, unit_.accelerometer_noise_m_s2);
  return {Cut(turning, unit_.gyro_range_rad_s), Cut(force, unit_.accelerometer_range_m_s2)};
}

InclinationSensor::InclinationSensor(const robot::Inclinometer& inclinometer, std::uint64_t seed)
    : inclinometer_(inclinometer), noise_(seed, "sensor.inclinometer") {}

void InclinationSensor::Follow(const Eigen::Vector3d& force_m_s2, double step_s) {
  const bool hung_up = hangs_along_ != Eigen::Vector3d::Zero();
  const double share =
      hung_up && inclinometer_.lag_s > 0.0 ? 1.0 - std::exp(-step_s / inclinometer_.lag_s) : 1.0;
  hangs_along_ += share * (force_m_s2 - hangs_along_);
}

robot::Inclination InclinationSensor::Measure() {
  if (hangs_along_ == Eigen::Vector3d::Zero()) throw std::logic_error("nothing hangs yet");
  const Eigen::Vector3d& up = hangs_along_;
  // At rest the force points up: along +y with the left side high, along −x with the nose low.
  const double roll_rad = std::atan2(up.y(), up.z());
  const double pitch_rad = std::atan2(-up.x(), std::hypot(up.y(), up.z()));
  return {Told(roll_rad), Told(pitch_rad)};
}

double InclinationSensor::Told(double angle_rad) {
  const double step = inclinometer_.resolution_rad;
  const double noisy = angle_rad + noise_.Normal(inclinometer_.noise_rad);
  return std::clamp(step * std::round(noisy / step), -inclinometer_.range_rad,
                    inclinometer_.range_rad);
}

}  // namespace kantaro::sim
