#include "perception/attitude.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace kantaro::perception {
namespace {

using std::chrono::milliseconds;

/// At rest, rolled so that the left side is high: gravity's reaction, seen in the base.
robot::InertialReading AtRest(double roll_rad) {
  robot::InertialReading reading;
  reading.specific_force_m_s2 = {0.0, 9.81 * std::sin(roll_rad), 9.81 * std::cos(roll_rad)};
  return reading;
}

TEST(AttitudeFilter, ReadsTheRollOfARobotAtRest) {
  AttitudeFilter filter;
  EXPECT_NEAR(filter.Update(AtRest(0.2), milliseconds(10)).roll_rad, 0.2, 1e-12);
  EXPECT_NEAR(filter.Update(AtRest(0.2), milliseconds(20)).roll_rad, 0.2, 1e-12);
}

TEST(AttitudeFilter, FollowsTheGyroThroughAJolt) {
  AttitudeFilter filter;
  (void)filter.Update(AtRest(0.0), milliseconds(0));
  robot::InertialReading jolt = AtRest(0.0);
  jolt.specific_force_m_s2 = {0.0, 9.81, 9.81};  // 45° if believed
  jolt.angular_velocity_rad_s.x() = 0.5;
  // 10 ms: 0.005 rad from the gyro, and 1/50 of the way to the accelerometer's 0.785 rad.
  EXPECT_NEAR(filter.Update(jolt, milliseconds(10)).roll_rad, 0.005 + (0.785398 - 0.005) / 50.0,
              1e-6);
}

TEST(AttitudeFilter, OutlivesTheGyrosDrift) {
  AttitudeFilter filter;
  robot::InertialReading drifting = AtRest(0.1);
  drifting.angular_velocity_rad_s.x() = 0.01;  // 0.6 rad a minute if only summed
  double roll = 0.0;
  for (int i = 0; i < 6000; ++i) roll = filter.Update(drifting, milliseconds(10 * i)).roll_rad;
  EXPECT_NEAR(roll, 0.1,
              0.01 * AttitudeFilter::kTimeConstant_s + 1e-3);  // rate times time constant
}

TEST(AttitudeFilter, PassesTheTurnRateAboutTheBasesUpwardAxis) {
  AttitudeFilter filter;
  robot::InertialReading turning = AtRest(0.0);
  turning.angular_velocity_rad_s = {0.1, 0.2, 0.3};
  const AttitudeObservation attitude = filter.Update(turning, milliseconds(9));
  EXPECT_EQ(attitude.yaw_rate_rad_s, 0.3);
  EXPECT_EQ(attitude.roll_rate_rad_s, 0.1);
  EXPECT_EQ(attitude.captured_at, milliseconds(9));
}

TEST(AttitudeFilter, RefusesWhatIsNoNumber) {
  AttitudeFilter filter;
  robot::InertialReading broken = AtRest(0.0);
  broken.angular_velocity_rad_s.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)filter.Update(broken, milliseconds(0)), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
