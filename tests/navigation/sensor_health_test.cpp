#include "navigation/sensor_health.hpp"

#include <gtest/gtest.h>

namespace kantaro::navigation {
namespace {

using robot::Sensor;
using std::chrono::seconds;

TEST(SensorHealth, CountsSilenceFromTheFirstWordOfAny) {
  SensorHealth health;
  EXPECT_FALSE(health.Silent(Sensor::kLaser, seconds(1000), 2.0));
  health.Hear(Sensor::kEncoders, seconds(1000));
  EXPECT_FALSE(health.Silent(Sensor::kLaser, seconds(1002), 2.0));
  EXPECT_TRUE(health.Silent(Sensor::kLaser, seconds(1003), 2.0));
  health.Hear(Sensor::kLaser, seconds(1003));
  EXPECT_FALSE(health.Silent(Sensor::kLaser, seconds(1005), 2.0));
}

TEST(SensorHealth, IsSilentAtOnceWhenLostUntilItSpeaks) {
  SensorHealth health;
  health.Hear(Sensor::kLaser, seconds(1));
  EXPECT_TRUE(health.Lose(Sensor::kLaser, seconds(1)));
  EXPECT_FALSE(health.Lose(Sensor::kLaser, seconds(1)));  // no news
  EXPECT_TRUE(health.Silent(Sensor::kLaser, seconds(1), 2.0));
  health.Hear(Sensor::kLaser, seconds(2));
  EXPECT_FALSE(health.Silent(Sensor::kLaser, seconds(2), 2.0));
}

// What it measured long ago and tells now is no word of now.
TEST(SensorHealth, CountsFromTheMeasurementNotFromItsArrival) {
  SensorHealth health;
  health.Hear(Sensor::kInertial, seconds(1));
  EXPECT_TRUE(health.Silent(Sensor::kInertial, seconds(2), 0.3));
}

TEST(SensorHealth, KnowsAPowerFailure) {
  SensorHealth health;
  health.Lose(Sensor::kEncoders, seconds(1));
  EXPECT_FALSE(health.PowerLost());
  health.Lose(Sensor::kBattery, seconds(1));
  EXPECT_TRUE(health.PowerLost());
}

}  // namespace
}  // namespace kantaro::navigation
