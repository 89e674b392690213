#include "sim/inertial_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_m_s2 = 9.81;

/// Without errors, but for what a test sets.
robot::InertialUnit Perfect() {
  robot::InertialUnit unit;
  unit.rate_Hz = 100.0;
  unit.gyro_range_rad_s = 4.0;
  unit.accelerometer_range_m_s2 = 20.0;
  return unit;
}

TEST(InertialSensor, TellsTheTruthWithinItsRange) {
  InertialSensor sensor(Perfect(), 1);
  const auto reading = sensor.Measure({0.1, -0.2, 5.0}, {0.5, -30.0, kGravity_m_s2});
  EXPECT_EQ(reading.angular_velocity_rad_s, Vector3d(0.1, -0.2, 4.0));
  EXPECT_EQ(reading.specific_force_m_s2, Vector3d(0.5, -20.0, kGravity_m_s2));
}

// The turn-on bias of many units scatters by its deviation: of 3000 draws that is known to 1.3 %.
TEST(InertialSensor, IsSwitchedOnWithABiasOfItsOwn) {
  robot::InertialUnit unit = Perfect();
  unit.gyro_bias_rad_s = 0.01;
  unit.accelerometer_bias_m_s2 = 0.05;
  double gyro = 0.0, accelerometer = 0.0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    InertialSensor sensor(unit, seed);
    const auto reading = sensor.Measure(Vector3d::Zero(), Vector3d::Zero());
    gyro += reading.angular_velocity_rad_s.squaredNorm();
    accelerometer += reading.specific_force_m_s2.squaredNorm();
    EXPECT_EQ(reading.angular_velocity_rad_s,
              sensor.Measure(Vector3d::Zero(), Vector3d::Zero()).angular_velocity_rad_s);
  }
  EXPECT_NEAR(std::sqrt(gyro / 3000.0), 0.01, 0.0005);
  EXPECT_NEAR(std::sqrt(accelerometer / 3000.0), 0.05, 0.0025);
}

// A random walk: after 4 s its deviation is twice that after 1 s.
TEST(InertialSensor, DriftsAsARandomWalk) {
  robot::InertialUnit unit = Perfect();
  unit.gyro_walk_rad_s = 0.01;
  double after_1s = 0.0, after_4s = 0.0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    InertialSensor sensor(unit, seed);
    for (int i = 1; i <= 400; ++i) {
      const auto reading = sensor.Measure(Vector3d::Zero(), Vector3d::Zero());
      if (i == 100) after_1s += reading.angular_velocity_rad_s.squaredNorm();
      if (i == 400) after_4s += reading.angular_velocity_rad_s.squaredNorm();
    }
  }
  EXPECT_NEAR(std::sqrt(after_1s / 3000.0), 0.01, 0.0005);
  EXPECT_NEAR(std::sqrt(after_4s / 3000.0), 0.02, 0.001);
}

robot::Inclinometer Pendulum() {
  robot::Inclinometer inclinometer;
  inclinometer.lag_s = 0.3;
  inclinometer.resolution_rad = 1e-9;
  inclinometer.range_rad = 0.7;
  return inclinometer;
}

/// What an accelerometer feels at rest in a base rolled about x, or pitched about y.
Vector3d Rolled(double a) {
  return {0.0, kGravity_m_s2 * std::sin(a), kGravity_m_s2 * std::cos(a)};
}
Vector3d Pitched(double a) {
  return {-kGravity_m_s2 * std::sin(a), 0.0, kGravity_m_s2 * std::cos(a)};
}

TEST(InclinationSensor, ReadsRollAndPitchAtRest) {
  InclinationSensor rolled(Pendulum(), 1), pitched(Pendulum(), 1);
  rolled.Follow(Rolled(0.2), 0.002);
  pitched.Follow(Pitched(-0.1), 0.002);
  EXPECT_NEAR(rolled.Measure().roll_rad, 0.2, 1e-8);
  EXPECT_NEAR(rolled.Measure().pitch_rad, 0.0, 1e-8);
  EXPECT_NEAR(pitched.Measure().pitch_rad, -0.1, 1e-8);  // nose high
}

// Tilted at once, it has gone 1 − 1/e of the way after one time constant.
TEST(InclinationSensor, LagsBehind) {
  InclinationSensor sensor(Pendulum(), 1);
  sensor.Follow(Rolled(0.0), 0.002);
  for (int i = 0; i < 150; ++i) sensor.Follow(Rolled(0.1), 0.002);
  EXPECT_NEAR(sensor.Measure().roll_rad, 0.1 * (1.0 - std::exp(-1.0)), 0.0002);
}

// Speeding up by a tenth of gravity looks like a nose lifted by atan(0.1).
TEST(InclinationSensor, TakesAccelerationForATilt) {
  InclinationSensor sensor(Pendulum(), 1);
  for (int i = 0; i < 3000; ++i) sensor.Follow({0.1 * kGravity_m_s2, 0.0, kGravity_m_s2}, 0.002);
  EXPECT_NEAR(sensor.Measure().pitch_rad, -std::atan(0.1), 1e-6);
}

TEST(InclinationSensor, SpeaksInStepsUpToItsRange) {
  robot::Inclinometer inclinometer = Pendulum();
  inclinometer.resolution_rad = 0.05;
  InclinationSensor sensor(inclinometer, 1);
  sensor.Follow(Rolled(0.12), 0.002);
  EXPECT_NEAR(sensor.Measure().roll_rad, 0.10, 1e-12);
  InclinationSensor fallen(inclinometer, 1);
  fallen.Follow(Rolled(1.2), 0.002);
  EXPECT_EQ(fallen.Measure().roll_rad, 0.7);
}

TEST(InclinationSensor, SaysNothingBeforeItHangs) {
  InclinationSensor sensor(Pendulum(), 1);
  EXPECT_THROW((void)sensor.Measure(), std::logic_error);
}

}  // namespace
}  // namespace kantaro::sim
