#include "sim/battery_pack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace kantaro::sim {
namespace {

robot::Battery Plain() {
  robot::Battery battery;
  battery.capacity_As = 3600.0;
  battery.resistance_ohm = 0.5;
  battery.voltage_V = {{0.0, 11.0}, {1.0, 13.0}};
  battery.cutoff_V = 9.0;
  battery.motor_efficiency = 0.5;
  battery.motor_copper_W_per_Nm2 = 4.0;
  battery.motor_idle_W = 0.25;
  return battery;
}

// 13 V behind 0.5 ohm: 25 W are 2.096 A at 11.952 V, for (13 − 0.5 I) I = 25.
TEST(BatteryPack, SagsUnderItsLoad) {
  BatteryPack pack(Plain(), 1.0);
  EXPECT_EQ(pack.state().voltage_V, 13.0);
  pack.Draw(25.0, 0.002);
  const double current_A = 13.0 - std::sqrt(13.0 * 13.0 - 2.0 * 25.0);
  EXPECT_NEAR(pack.state().current_A, current_A, 1e-12);
  EXPECT_NEAR(pack.state().voltage_V * pack.state().current_A, 25.0, 1e-9);
}

// 12 W at about 12 V are 1 A: a tenth of 1 Ah in six minutes.
TEST(BatteryPack, LosesItsChargeToTheCurrent) {
  robot::Battery battery = Plain();
  battery.resistance_ohm = 0.0;
  battery.voltage_V = {{0.0, 12.0}, {1.0, 12.000001}};
  BatteryPack pack(battery, 1.0);
  for (int i = 0; i < 360; ++i) pack.Draw(12.0, 1.0);
  EXPECT_NEAR(pack.state().charge, 0.9, 1e-6);
  EXPECT_FALSE(pack.off());
}

TEST(BatteryPack, IsOffForGoodWhenEmpty) {
  BatteryPack pack(Plain(), 0.001);  // 3.6 As
  for (int i = 0; i < 10; ++i) pack.Draw(12.0, 1.0);
  EXPECT_TRUE(pack.off());
  EXPECT_EQ(pack.state().charge, 0.0);
}

// At half charge, 12 V: 40 W would be 4 A at 10 V; the voltage is 9 V at 6 A and 54 W.
TEST(BatteryPack, SwitchesOffBelowItsCutOffVoltage) {
  BatteryPack pack(Plain(), 0.5);
  pack.Draw(40.0, 0.002);
  EXPECT_NEAR(pack.state().voltage_V, 10.0, 1e-9);
  pack.Draw(53.0, 0.002);
  EXPECT_FALSE(pack.off());
  pack.Draw(55.0, 0.002);
  EXPECT_TRUE(pack.off());
}

TEST(BatteryPack, SwitchesOffWhereNoCurrentIsEnough) {
  robot::Battery battery = Plain();
  battery.cutoff_V = 0.0;
  BatteryPack pack(battery, 0.5);
  pack.Draw(73.0, 0.002);  // 12² / (4 · 0.5) = 72 W is the most
  EXPECT_TRUE(pack.off());
}

TEST(BatteryPack, RefusesAChargeThatIsNone) {
  EXPECT_THROW(BatteryPack(Plain(), 1.1), std::invalid_argument);
}

TEST(MotorPower, IsTheWorkAndTheLosses) {
  // 0.5 Nm at 2 rad/s: 1 W of work through an efficiency of a half, 4 · 0.25 W of heat, 0.25 W.
  EXPECT_DOUBLE_EQ(MotorPower_W(Plain(), 0.5, 2.0), 2.0 + 1.0 + 0.25);
  EXPECT_DOUBLE_EQ(MotorPower_W(Plain(), -0.5, 2.0), 1.0 + 0.25);  // braking gives nothing back
  EXPECT_DOUBLE_EQ(MotorPower_W(Plain(), 0.0, 0.0), 0.25);
}

}  // namespace
}  // namespace kantaro::sim
