#include "sim/compass_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

robot::Compass InJapan() {
  robot::Compass compass;
  compass.strength_tolerance = 0.1;
  compass.earth_horizontal_T = 32.4e-6;
  compass.earth_down_T = 34.6e-6;
  return compass;
}

Eigen::Matrix3d Facing(double clockwise_from_north_rad) {  // B's x from W's y
  return Eigen::AngleAxisd(std::numbers::pi / 2.0 - clockwise_from_north_rad, Vector3d::UnitZ())
      .toRotationMatrix();
}

/// Two manholes 20 m apart along x, covers 2 m up; a pipe of this material between them.
Sewer Street(network::Material material) {
  Sewer sewer;
  network::Manhole a, b;
  a.name = "A";
  b.name = "B";
  b.p_WM.x() = 20.0;
  sewer.network.manholes = {a, b};
  network::Pipe pipe;
  pipe.name = "P";
  pipe.upstream = "A";
  pipe.downstream = "B";
  pipe.material = material;
  sewer.network.pipes = {pipe};
  return sewer;
}

TEST(CompassSensor, ReadsTheHeadingClockwiseFromNorth) {
  CompassSensor compass(InJapan(), 1);
  const Vector3d earth(0.0, 32.4e-6, -34.6e-6);
  for (const double heading_deg : {0.5, 90.0, 200.0, 315.0}) {
    const auto reading = compass.Measure(Facing(heading_deg * kDegree), earth, 0.0);
    EXPECT_NEAR(reading.heading_rad, heading_deg * kDegree, 1e-9);
    EXPECT_FALSE(reading.disturbed);
  }
}

// A field turned to the east by atan(10 / 32.4) takes as much off the heading; 3 % stronger, it
// is not noticed.
TEST(CompassSensor, IsTurnedByIron) {
  CompassSensor compass(InJapan(), 1);
  const auto reading = compass.Measure(Facing(90.0 * kDegree), {10e-6, 32.4e-6, -34.6e-6}, 0.0);
  EXPECT_NEAR(reading.heading_rad, 90.0 * kDegree - std::atan(10.0 / 32.4), 1e-9);
  EXPECT_FALSE(reading.disturbed);
}

TEST(CompassSensor, SaysWhenTheFieldIsNotTheEarths) {
  CompassSensor compass(InJapan(), 1);
  // 47.4 µT; 52.2 and 42.6 are 10 % off.
  EXPECT_TRUE(compass.Measure(Facing(0.0), {0.0, 32.4e-6, -42e-6}, 0.0).disturbed);   // 53.0
  EXPECT_FALSE(compass.Measure(Facing(0.0), {0.0, 32.4e-6, -40e-6}, 0.0).disturbed);  // 51.5
  EXPECT_TRUE(compass.Measure(Facing(0.0), {0.0, 32.4e-6, -26e-6}, 0.0).disturbed);   // 41.5
}

// Facing north with motors' leads along: 4 A of 1 µT/A to the right (east) turn the needle there.
TEST(CompassSensor, IsTurnedByTheMotors) {
  robot::Compass leads = InJapan();
  leads.motor_field_T_per_A = 1e-6;
  CompassSensor compass(leads, 1);
  const auto reading = compass.Measure(Facing(0.0), {0.0, 32.4e-6, -34.6e-6}, 4.0);
  EXPECT_NEAR(reading.heading_rad, 2.0 * std::numbers::pi - std::atan(4.0 / 32.4), 1e-9);
}

TEST(MagneticField, IsTheEarthsFarFromIron) {
  const Sewer sewer = Street(network::Material::kPvc);
  const MagneticField field(sewer, InJapan());
  const Vector3d middle = field.At({10.0, 0.0, 0.0}, 0, 10.0);
  EXPECT_LT((middle - Vector3d(0.0, 32.4e-6, -34.6e-6)).norm(), 0.01e-6);
}

// On the axis of a dipole: 2 · 1e-7 · m / r³ = 4e-6 / 8 = 0.5 µT, 2 m under a cover.
TEST(MagneticField, IsStrongerUnderACover) {
  const Sewer sewer = Street(network::Material::kPvc);
  const MagneticField field(sewer, InJapan());
  const Vector3d under = field.At({0.0, 0.0, 0.0}, {}, 0.0);
  EXPECT_NEAR(under.z(), -34.6e-6 - 0.5e-6, 0.01e-6);
  const Vector3d near = field.At({0.0, 0.0, 1.0}, {}, 0.0);  // r = 1 m: eight times as much
  EXPECT_NEAR(near.z(), -34.6e-6 - 4.0e-6, 0.01e-6);
}

TEST(MagneticField, ChangesFromLengthToLengthOfAConcretePipe) {
  const Sewer sewer = Street(network::Material::kConcrete);
  const MagneticField field(sewer, InJapan());
  const Vector3d earth(0.0, 32.4e-6, -34.6e-6);
  const auto iron = [&](double x) -> Vector3d { return field.At({x, 0.0, 0.0}, 0, x) - earth; };
  // In the middle of a length, 1 m, 3 m …, its own magnetisation alone.
  EXPECT_NEAR(iron(9.0).norm(), 15e-6, 0.05e-6);
  EXPECT_NEAR(iron(11.0).norm(), 15e-6, 0.05e-6);
  EXPECT_LT((iron(10.0) - 0.5 * (iron(9.0) + iron(11.0))).norm(), 0.05e-6);
  EXPECT_GT((iron(9.0) - iron(11.0)).norm(), 1e-6);
  EXPECT_EQ(iron(9.3), iron(9.3));
}

}  // namespace
}  // namespace kantaro::sim
