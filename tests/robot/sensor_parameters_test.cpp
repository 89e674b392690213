#include "robot/sensor_parameters.hpp"

#include "tests/robot/robot_files.hpp"

namespace kantaro::robot {
namespace {

TEST(Battery, InterpolatesItsVoltageBetweenThePoints) {
  Battery battery;
  battery.voltage_V = {{0.0, 12.0}, {0.5, 14.0}, {1.0, 17.0}};
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(0.0), 12.0);
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(0.25), 13.0);
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(0.9), 16.4);
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(1.0), 17.0);
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(-0.1), 12.0);
  EXPECT_DOUBLE_EQ(battery.OpenVoltage(1.1), 17.0);
}

TEST(SensorParameters, AreReadInTheUnitsOfTheCode) {
  const Description robot = ReadDescription(ModelFolder());
  EXPECT_NEAR(robot.inclinometer.noise_rad, 0.05 * 3.14159265 / 180.0, 1e-9);
  EXPECT_NEAR(robot.compass.earth_horizontal_T, 32.4e-6, 1e-12);
  EXPECT_NEAR(robot.battery.capacity_As, 5.2 * 3600.0, 1e-9);
  EXPECT_NEAR(robot.battery.laser_W, 17.0, 1e-12);  // Table 5.1: 12 * 0.5 * 2 + 5 * 1
  EXPECT_NEAR(robot.ir_up.cone_half_angle_rad, 5.0 * 3.14159265 / 180.0, 1e-9);
}

TEST(SensorParameters, AreRefusedWhereTheyMeanNothing) {
  ExpectError(EditedCompanion("speed_rpm: 1800", "speed_rpm: 1801"), "laser.speed_rpm",
              "outside 0 to 1800");
  ExpectError(EditedCompanion("mirror_counts: 4096", "mirror_counts: 1.5"), "laser.mirror_counts",
              "not a whole number");
  ExpectError(EditedCompanion("beam_radius_mm: 0.5", "beam_radius_mm: wide"),
              "laser.beam_radius_mm", "not a number");
  ExpectError(EditedCompanion("gyro_walk_rad_s", "gyro_walk"), "inertial.gyro_walk", "unknown key");
  ExpectError(EditedCompanion("lag_s: 0.3", "lag_s: -1"), "inclinometer.lag_s", "outside 0 to 10");
  ExpectError(EditedCompanion("strength_tolerance: 0.1", "strength_tolerance: 0"),
              "compass.strength_tolerance", "outside");
  ExpectError(EditedCompanion("[0.2, 14.4]", "[0.2, 13.0]"), "battery.voltage_V[2]", "must rise");
  ExpectError(EditedCompanion("- [0, 12.0]", "- [0.01, 12.0]"), "battery.voltage_V",
              "from charge 0 to charge 1");
  ExpectError(EditedCompanion("cutoff_V: 11.0", "cutoff_V: 20"), "battery.cutoff_V",
              "outside 0 to 16.8");
}

}  // namespace
}  // namespace kantaro::robot
