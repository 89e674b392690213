#include "perception/chamber_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kantaro::perception {
namespace {

using Channel = ChamberModel::Channel;
using Eigen::Vector3d;
using Surface = ChamberModel::Surface;

constexpr double kPipe_m = 0.15, kShaft_m = 0.8, kMouth_m = 1.0;

/// Where a ray from the pipe's axis meets the wall of an endless pipe, this far round from the
/// right upwards.
Vector3d Wall(double up_deg, double z_m) {
  const double up_rad = up_deg * std::numbers::pi / 180.0;
  return {kPipe_m * std::cos(up_rad), -kPipe_m * std::sin(up_rad), z_m};
}

ChamberModel::Hit Trace(const Vector3d& wall_P, Channel channel) {
  return ChamberModel(kPipe_m, kShaft_m).Trace(Vector3d::Zero(), wall_P, kMouth_m, channel);
}

TEST(ChamberModel, ShowsThePipeUpToItsMouth) {
  for (const double up_deg : {0.0, 45.0, 90.0}) {
    const auto hit = Trace(Wall(up_deg, 0.99), Channel::kStraight);
    EXPECT_EQ(hit.surface, Surface::kPipe);
    EXPECT_EQ(hit.along, 1.0);
    EXPECT_TRUE(hit.normal_P.isApprox(-Wall(up_deg, 0.0) / kPipe_m, 1e-9));
    EXPECT_NE(Trace(Wall(up_deg, 1.01), Channel::kStraight).surface, Surface::kPipe);
  }
}

// A ray that leaves through the crown's height just behind the mouth goes on in the shaft to its
// far wall, 0.8 m behind the mouth.
TEST(ChamberModel, ShowsTheFarWallOverTheCrown) {
  const auto hit = Trace(Wall(90.0, 1.2), Channel::kStraight);
  EXPECT_EQ(hit.surface, Surface::kShaft);
  EXPECT_NEAR(hit.along, 1.8 / 1.2, 1e-9);
  EXPECT_TRUE(hit.normal_P.isApprox(-Vector3d::UnitZ(), 1e-9));
}

// At 30° the upright side stands 1 / cos 30° as far as the round wall would.
TEST(ChamberModel, ShowsTheUprightSideOfTheChannel) {
  const auto hit = Trace(Wall(30.0, 1.2), Channel::kStraight);
  EXPECT_EQ(hit.surface, Surface::kChannel);
  EXPECT_NEAR(hit.along, 1.0 / std::cos(std::numbers::pi / 6.0), 1e-9);
  EXPECT_TRUE(hit.normal_P.isApprox(-Vector3d::UnitX(), 1e-9));
}

TEST(ChamberModel, GoesOnAsThePipeBelowTheAxis) {
  const auto hit = Trace(Wall(-20.0, 1.4), Channel::kStraight);
  EXPECT_EQ(hit.surface, Surface::kChannel);
  EXPECT_EQ(hit.along, 1.0);
}

TEST(ChamberModel, EndsInTheNextPipeOrInTheWallOpposite) {
  EXPECT_EQ(Trace(Wall(60.0, 2.5), Channel::kStraight).surface, Surface::kFarPipe);
  const auto end = Trace(Wall(60.0, 2.5), Channel::kEnds);
  EXPECT_EQ(end.surface, Surface::kEndWall);
  EXPECT_NEAR(end.along, 1.8 / 2.5, 1e-9);
  // Between the round pipe and the upright sides there is wall, anyway.
  EXPECT_EQ(Trace(Wall(45.0, 1.7), Channel::kStraight).surface, Surface::kEndWall);
}

// The channel turns about an upright axis as far to the side as 0.66 of the shaft's radius, which
// is as far before the shaft's middle. A ray along the pipe's axis meets its outer side where that
// has turned away from the ray: at the arc's radius of 0.264 + 0.15 m.
TEST(ChamberModel, ShowsTheOuterSideOfATurn) {
  const double turn_m = 0.66 * 0.4, outer_m = turn_m + kPipe_m;
  const double there_m = 1.0 + 0.4 - turn_m + std::sqrt(outer_m * outer_m - turn_m * turn_m);
  const Vector3d wall_P(1e-6, -kPipe_m, 40.0);  // all but along the axis
  for (const auto channel : {Channel::kRight, Channel::kLeft}) {
    const auto hit = Trace(wall_P, channel);
    EXPECT_EQ(hit.surface, Surface::kChannel);
    EXPECT_NEAR(hit.along * 40.0, there_m, 1e-4);
    const double side = channel == Channel::kRight ? 1.0 : -1.0;
    EXPECT_NEAR(hit.normal_P.x(), side * turn_m / outer_m, 1e-4);
    EXPECT_LT(hit.normal_P.z(), 0.0);
  }
}

TEST(ChamberModel, MirrorsATurn) {
  const Vector3d wall_P = Wall(20.0, 1.9), mirrored_P(-wall_P.x(), wall_P.y(), wall_P.z());
  const auto right = Trace(wall_P, Channel::kRight), left = Trace(mirrored_P, Channel::kLeft);
  EXPECT_EQ(right.surface, left.surface);
  EXPECT_NEAR(right.along, left.along, 1e-12);
  EXPECT_NEAR(right.normal_P.x(), -left.normal_P.x(), 1e-12);
}

}  // namespace
}  // namespace kantaro::perception
