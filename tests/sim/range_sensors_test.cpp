#include "sim/range_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/surface_mesh.hpp"

namespace kantaro::sim {
namespace {

VoidPrimitive Pipe(double radius_m) {
  VoidPrimitive pipe;
  pipe.length_m = 4.0;
  pipe.radius_m = radius_m;
  return pipe;
}

robot::Laser Table51() {
  robot::Laser laser;
  laser.revolutions_Hz = 30.0;
  laser.samples_Hz = 10080.0;
  laser.range_min_m = 0.070;
  laser.range_max_m = 0.190;
  laser.accuracy_m = 0.001;
  return laser;
}

Eigen::Isometry3d At(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

std::vector<LaserScanner::Completed> ScanOneSecond(const RayCaster& rays,
                                                   const Eigen::Isometry3d& X_WL) {
  LaserScanner scanner(Table51(), rays, RandomStream(1, "laser"));
  return scanner.Scan(0.0, 1.0, X_WL, X_WL);
}

// On the axis every beam of a revolution travels exactly one radius, but for the accuracy of
// Table 5.1.
TEST(LaserScanner, ReadsThePipeRadiusOnItsAxis) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  const auto revolutions = ScanOneSecond(rays, At(2.0, 0.0, 0.0));
  ASSERT_EQ(revolutions.size(), 30u);
  EXPECT_NEAR(revolutions.back().time_s, 1.0, 1e-9);
  double sum = 0.0;
  for (const robot::LaserSample& sample : revolutions[3].revolution.samples) {
    EXPECT_EQ(sample.status, robot::RangeStatus::kValid);
    EXPECT_NEAR(sample.range_m, 0.150, 0.001 + 0.0002);  // accuracy and mesh sagitta
    sum += sample.range_m;
  }
  EXPECT_EQ(revolutions[3].revolution.samples.size(), 336u);
  EXPECT_NEAR(sum / 336.0, 0.150, 0.0003);
}

TEST(LaserScanner, TurnsFromTheRightOverTheTopToTheLeft) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  // 30 mm to the left of the axis (+y): near on the left, far on the right.
  const auto samples = ScanOneSecond(rays, At(2.0, 0.030, 0.0))[0].revolution.samples;
  EXPECT_EQ(samples[0].angle_rad, 0.0);
  EXPECT_NEAR(samples[0].range_m, 0.180, 0.0013);
  EXPECT_NEAR(samples[168].angle_rad, std::numbers::pi, 1e-9);
  EXPECT_NEAR(samples[168].range_m, 0.120, 0.0013);
  EXPECT_NEAR(samples[84].range_m, std::sqrt(0.150 * 0.150 - 0.030 * 0.030), 0.0013);
}

TEST(LaserScanner, SaysTooNearAndTooFar) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  // 90 mm above the axis: 60 mm to the crown, 240 mm to the invert.
  const auto samples = ScanOneSecond(rays, At(2.0, 0.0, 0.090))[0].revolution.samples;
  EXPECT_EQ(samples[84].status, robot::RangeStatus::kTooNear);
  EXPECT_EQ(samples[84].range_m, 0.070);
  EXPECT_EQ(samples[252].status, robot::RangeStatus::kTooFar);
  EXPECT_EQ(samples[252].range_m, 0.190);
}

TEST(LaserScanner, MovesWithTheRobotDuringARevolution) {
  // A pipe that ends: the scanner passes from inside a shaft-like wide void into the pipe halfway
  // through the turn.
  VoidPrimitive wide = Pipe(0.180);
  wide.length_m = 2.0;
  VoidPrimitive narrow = Pipe(0.120);
  narrow.X_WS.translation().x() = 1.999;
  const std::vector<VoidPrimitive> voids{wide, narrow};
  const RayCaster rays(Tessellate(voids));
  LaserScanner scanner(Table51(), rays, RandomStream(1, "laser"));
  const double revolution_s = 1.0 / 30.0;
  const auto turns = scanner.Scan(0.0, revolution_s, At(1.99, 0.0, 0.0), At(2.01, 0.0, 0.0));
  ASSERT_EQ(turns.size(), 1u);
  EXPECT_NEAR(turns[0].revolution.samples[10].range_m, 0.180, 0.0013);
  EXPECT_NEAR(turns[0].revolution.samples[320].range_m, 0.120, 0.0013);
}

TEST(LaserScanner, RefusesARateThatDoesNotDivideARevolution) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  robot::Laser laser = Table51();
  laser.samples_Hz = 10000.0;
  EXPECT_THROW(LaserScanner(laser, rays, RandomStream(1, "laser")), std::invalid_argument);
}

// value = 1 / (1 + (range / half_range)²): a half at 150 mm, a fifth at 300 mm.
TEST(Infrared, FallsWithTheDistance) {
  robot::Infrared sensor;
  sensor.half_range_m = 0.150;
  sensor.noise = 0.0;
  RandomStream noise(1, "infrared");
  for (const double radius : {0.150, 0.300}) {
    const std::vector<VoidPrimitive> pipe{Pipe(radius)};
    const RayCaster rays(Tessellate(pipe));
    Eigen::Isometry3d X_WS = At(2.0, 0.0, 0.0);
    X_WS.linear() = Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitY())
                        .toRotationMatrix();  // x up
    const double ratio = radius / 0.150;
    EXPECT_NEAR(MeasureInfrared(sensor, rays, X_WS, noise).value, 1.0 / (1.0 + ratio * ratio),
                0.002);
  }
}

}  // namespace
}  // namespace kantaro::sim
