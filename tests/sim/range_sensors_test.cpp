#include "sim/range_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "robot/mirror_angle.hpp"
#include "sim/surface_mesh.hpp"
#include "tests/network/sewers.hpp"

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
  laser.speed_rpm = 1800.0;
  laser.mirror_counts = 4096;
  laser.beam_radius_m = 0.0005;
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

std::vector<LaserScanner::Completed> ScanAt(double speed_rpm, const RayCaster& rays) {
  robot::Laser laser = Table51();
  laser.speed_rpm = speed_rpm;
  LaserScanner scanner(laser, rays, RandomStream(1, "laser"));
  return scanner.Scan(0.0, 1.0, At(2.0, 0.0, 0.0), At(2.0, 0.0, 0.0));
}

// 10080 beams a second whatever the mirror does: 60 * 10080 / rpm to a turn.
TEST(LaserScanner, HasMoreBeamsToASlowerTurn) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  const auto slow = ScanAt(600.0, rays);
  ASSERT_EQ(slow.size(), 10u);
  for (const auto& turn : slow) EXPECT_EQ(turn.revolution.samples.size(), 1008u);
  EXPECT_NEAR(slow[0].time_s, 0.1, 1e-12);
  // 1700 rpm: 355.76 beams; every turn has 355 or 356, and none is lost.
  std::size_t all = 0;
  for (const auto& turn : ScanAt(1700.0, rays)) {
    EXPECT_NEAR(static_cast<double>(turn.revolution.samples.size()), 355.76, 1.0);
    all += turn.revolution.samples.size();
  }
  EXPECT_NEAR(static_cast<double>(all), 28 * 355.76, 1.0);
}

TEST(LaserScanner, CompletesNoTurnWhileItsMirrorStandsStill) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  EXPECT_TRUE(ScanAt(0.0, rays).empty());
}

// Beam j of 336 leaves at j / 336 of a turn; told is the last of 4096 counts before that.
TEST(LaserScanner, TellsTheCountItsMirrorHasReached) {
  const std::vector<VoidPrimitive> pipe{Pipe(0.150)};
  const RayCaster rays(Tessellate(pipe));
  const auto samples = ScanAt(1800.0, rays)[4].revolution.samples;
  for (std::size_t j = 0; j < samples.size(); ++j) {
    const auto count = static_cast<std::uint32_t>(j * 4096 / 336);
    EXPECT_EQ(samples[j].angle_rad, robot::MirrorAngle(count, 4096));
    EXPECT_EQ(robot::MirrorCount(samples[j].angle_rad, 4096), count);
    EXPECT_EQ(robot::MirrorCount(static_cast<float>(samples[j].angle_rad), 4096), count);
  }
}

/// Two pipes of 120 and 160 mm radius that meet at x = 2, seen from so far before the step: a beam
/// of 0.5 mm radius reaches over it.
double RangeAtStep(double before_m) {
  VoidPrimitive narrow = Pipe(0.120);
  narrow.length_m = 2.0;
  VoidPrimitive wide = Pipe(0.160);
  wide.X_WS.translation().x() = 2.0;
  const std::vector<VoidPrimitive> voids{narrow, wide};
  const RayCaster rays(Tessellate(voids));
  robot::Laser laser = Table51();
  laser.accuracy_m = 1e-9;
  LaserScanner scanner(laser, rays, RandomStream(1, "laser"));
  const Eigen::Isometry3d X_WL = At(2.0 - before_m, 0.0, 0.0);
  const auto turns = scanner.Scan(0.0, 1.0 / 30.0, X_WL, X_WL);
  return turns.at(0).revolution.samples.at(84).range_m;
}

// At an edge the range is the mean over the disc. A step h before its middle leaves beyond it the
// segment of a circle: share = (acos(h / r) − (h / r) sqrt(1 − (h / r)²)) / pi; at h = r / 2 that
// is (1.0472 − 0.4330) / 3.1416 = 0.1955.
TEST(LaserScanner, MixesNearAndFarAtAnEdge) {
  EXPECT_NEAR(RangeAtStep(0.0010), 0.120, 0.0002);
  EXPECT_NEAR(RangeAtStep(0.00025), 0.120 + 0.1955 * 0.040, 0.0025);
  EXPECT_NEAR(RangeAtStep(0.0), 0.140, 0.0025);
  EXPECT_NEAR(RangeAtStep(-0.00025), 0.160 - 0.1955 * 0.040, 0.0025);
  EXPECT_NEAR(RangeAtStep(-0.0010), 0.160, 0.0002);
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
    EXPECT_NEAR(MeasureInfrared(sensor, rays, {}, X_WS, noise).value, 1.0 / (1.0 + ratio * ratio),
                0.002);
  }
}

// 150 mm of plain pipe: s is the wall's share alone, and the value s / (1 + s).
TEST(Infrared, DimsWithTheWallsMaterialAndCondition) {
  robot::Infrared sensor;
  sensor.half_range_m = 0.150;
  sensor.noise = 0.0;
  RandomStream noise(1, "infrared");
  const GripTable grips = ReadGripTable(KANTARO_SOURCE_DIR "/models/materials.yaml");
  const auto value = [&](network::Material material, network::WallCondition condition) {
    network::Network network = network::OnePipe();
    network.pipes[0].diameter_m = 0.300;
    network.pipes[0].material = material;
    network.pipes[0].condition = condition;
    const Sewer sewer = BuildSewer(network);
    const VoidField field(sewer.voids, sewer.solids);
    const RayCaster rays(Tessellate(sewer.voids, sewer.solids));
    const SewerGround ground(sewer, field, grips);
    Eigen::Isometry3d X_WS = sewer.axes[0].PoseAt(5.0);
    X_WS.rotate(Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitY()));  // x up
    return MeasureInfrared(sensor, rays, ground, X_WS, noise).value;
  };
  using network::Material;
  using network::WallCondition;
  EXPECT_NEAR(value(Material::kPvc, WallCondition::kDry), 0.5, 0.002);
  for (const Material material : {Material::kClay, Material::kConcrete, Material::kLined}) {
    double before = 0.5;
    for (const WallCondition condition : {WallCondition::kDry, WallCondition::kWet}) {
      const double share = grips.At(GroundOf(material), condition).infrared_return;
      const double dimmed = value(material, condition);
      EXPECT_NEAR(dimmed, share / (1.0 + share), 0.002);
      EXPECT_LT(dimmed, before);
      EXPECT_GT(dimmed, 0.25 + 5 * 0.01);  // the threshold, and five times the noise
      before = dimmed;
    }
  }
}

/// The beam of a sensor across a pipe's axis towards the crown, before a step from 150 to 450 mm.
double InfraredAtStep(double cone_rad, double before_m) {
  VoidPrimitive narrow = Pipe(0.150);
  narrow.length_m = 2.0;
  VoidPrimitive wide = Pipe(0.450);
  wide.X_WS.translation().x() = 2.0;
  const std::vector<VoidPrimitive> voids{narrow, wide};
  const RayCaster rays(Tessellate(voids));
  robot::Infrared sensor;
  sensor.half_range_m = 0.150;
  sensor.cone_half_angle_rad = cone_rad;
  RandomStream noise(1, "infrared");
  Eigen::Isometry3d X_WS = At(2.0 - before_m, 0.0, 0.0);
  X_WS.linear() =
      Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return MeasureInfrared(sensor, rays, {}, X_WS, noise).value;
}

// A cone of 10° reaches 26 mm to each side of a spot 150 mm away; where half of it meets the far
// wall, s = (1 + 1/9) / 2 = 0.556 and the value 0.357. A thin beam knows no halves.
TEST(Infrared, SeesTheWallOverTheWidthOfItsBeam) {
  constexpr double kCone_rad = 10.0 * std::numbers::pi / 180.0;
  EXPECT_NEAR(InfraredAtStep(kCone_rad, 0.030), 0.5, 0.01);
  EXPECT_NEAR(InfraredAtStep(kCone_rad, 0.0), 0.357, 0.04);
  EXPECT_NEAR(InfraredAtStep(kCone_rad, -0.090), 0.1, 0.01);
  EXPECT_NEAR(InfraredAtStep(0.0, 0.005), 0.5, 0.002);
  EXPECT_NEAR(InfraredAtStep(0.0, -0.005), 0.1, 0.002);
}

}  // namespace
}  // namespace kantaro::sim
