#include "network/pipe_axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using std::numbers::pi;

/// From (0, 0) along +x to a corner at (5, 0), there by `turn` to the left, 5 m on; level or
/// falling.
Network BentPipe(double turn, double radius_m, double drop_m = 0.0) {
  Network network = OnePipe();
  network.manholes[1].p_WM = {5 + 5 * std::cos(turn), 5 * std::sin(turn), -drop_m};
  network.pipes[0].bends = {{{5, 0}, radius_m}};
  return network;
}

PipeAxis AxisOf(const Network& network) { return {network, network.pipes[0]}; }

void ExpectNear(const Vector3d& actual, const Vector3d& expected, double tolerance) {
  EXPECT_LT((actual - expected).norm(), tolerance)
      << actual.transpose() << " instead of " << expected.transpose();
}

TEST(PipeAxis, RunsFromShaftWallToShaftWallARadiusAboveTheInvert) {
  const PipeAxis axis = AxisOf(OnePipe());
  EXPECT_NEAR(axis.length_m(), 10.0 - 2 * 0.4, 1e-12);  // shafts of 800 mm
  ASSERT_EQ(axis.pieces().size(), 1u);
  ExpectNear(axis.PoseAt(0).translation(), {0.4, 0, 0.15}, 1e-12);
  ExpectNear(axis.PoseAt(axis.length_m()).translation(), {9.6, 0, 0.15}, 1e-12);
  EXPECT_TRUE(axis.PoseAt(3).linear().isIdentity(1e-12));
}

TEST(PipeAxis, SpreadsTheGradeFromInvertToInvert) {
  Network network = OnePipe();
  network.manholes[0].p_WM.z() = 1.0;
  network.pipes[0].upstream_offset_m = 0.046;  // falls 1.046 − 0 over 9.2 m
  const PipeAxis axis = AxisOf(network);
  EXPECT_NEAR(axis.grade(), -1.046 / 9.2, 1e-12);
  EXPECT_NEAR(axis.length_m(), std::hypot(9.2, 1.046), 1e-12);
  ExpectNear(axis.PoseAt(0).translation(), {0.4, 0, 1.196}, 1e-12);
  ExpectNear(axis.PoseAt(axis.length_m()).translation(), {9.6, 0, 0.15}, 1e-12);
  EXPECT_NEAR(axis.PoseAt(1).linear()(2, 0), -1.046 / axis.length_m(), 1e-12);
}

TEST(PipeAxis, RoundsACornerByATangentArc) {
  const double radius_m = 0.45, cut_m = radius_m;  // 90°: the tangent is as long as the radius
  const PipeAxis axis = AxisOf(BentPipe(pi / 2, radius_m));
  const double leg_m = 5 - 0.4 - cut_m;
  EXPECT_NEAR(axis.length_m(), 2 * leg_m + radius_m * pi / 2, 1e-9);
  const Isometry3d X_WA = axis.PoseAt(leg_m + radius_m * pi / 4);  // the arc's middle
  const double side_m = radius_m * std::sqrt(0.5);
  ExpectNear(X_WA.translation(), {5 - cut_m + side_m, radius_m - side_m, 0.15}, 1e-9);
  ExpectNear(X_WA.linear().col(0), {std::sqrt(0.5), std::sqrt(0.5), 0}, 1e-9);
  ExpectNear(axis.PoseAt(axis.length_m()).linear().col(0), {0, 1, 0}, 1e-9);
}

TEST(PipeAxis, TurnsRightWithNegativeCurvature) {
  const PipeAxis axis = AxisOf(BentPipe(-pi / 4, 0.45));
  ASSERT_EQ(axis.pieces().size(), 3u);
  EXPECT_NEAR(axis.pieces()[1].curvature, -1 / 0.45, 1e-9);
  EXPECT_LT(axis.PoseAt(axis.length_m()).translation().y(), -3.0);
}

TEST(PipeAxis, PiecesMeetExactlyAndNearlyTangentOnAGrade) {
  for (const double turn_degrees : {-135.0, -90.0, -30.0, 11.0, 45.0, 120.0}) {
    const Network network = BentPipe(turn_degrees * pi / 180, 0.45, /*drop_m=*/0.5);
    const PipeAxis axis = AxisOf(network);
    for (std::size_t i = 1; i < axis.pieces().size(); ++i) {
      const AxisPiece& before = axis.pieces()[i - 1];
      const AxisPiece& after = axis.pieces()[i];
      EXPECT_NEAR(after.start_m, before.start_m + before.length_m, 1e-12);
      // Just before the meeting point the pose is still on the piece before.
      const Isometry3d X_WE = axis.PoseAt(std::nextafter(after.start_m, 0.0));
      ExpectNear(X_WE.translation(), after.X_WS.translation(), 2e-6);
      const Vector3d end = X_WE.linear().col(0), start = after.X_WS.linear().col(0);
      EXPECT_LT(std::abs(end.z() - start.z()), 0.11 * std::abs(axis.grade()) + 1e-9);  // 2 x 5 %
      EXPECT_NEAR(end.head<2>().normalized().dot(start.head<2>().normalized()), 1.0, 1e-5);
    }
    const Vector3d end = axis.PoseAt(axis.length_m()).translation();
    EXPECT_NEAR(end.z(), -0.5 + 0.15, 1e-9);
    EXPECT_NEAR((end - network.manholes[1].p_WM).head<2>().norm(), 0.4, 1e-9);
  }
}

TEST(PipeAxis, GoesOnStraightBeyondItsEnds) {
  const PipeAxis axis = AxisOf(BentPipe(pi / 2, 0.45));
  ExpectNear(axis.PoseAt(-0.4).translation(), {0, 0, 0.15}, 1e-9);
  ExpectNear(axis.PoseAt(axis.length_m() + 0.4).translation(), {5, 5, 0.15}, 1e-9);
}

TEST(PipeAxis, LocatesWhatItPlaced) {
  for (const double turn : {-2.0, -0.7, 0.3, 1.5}) {
    const PipeAxis axis = AxisOf(BentPipe(turn, 0.45, 0.1));
    for (double chainage_m = -0.35; chainage_m < axis.length_m() + 0.4; chainage_m += 0.173) {
      for (const double clock_h : {0.5, 3.0, 5.9, 9.0, 12.0}) {
        const Vector3d p_W = axis.PoseAt(chainage_m) * (0.1 * ClockDirection(clock_h));
        const PipePosition position = axis.Locate(p_W);
        // On the inside of a bend on a grade pieces fold over each other by the residual: 0.2 mm.
        EXPECT_NEAR(position.chainage_m, chainage_m, 2e-4);
        EXPECT_NEAR(position.offset_m, 0.1, 2e-4);
        EXPECT_NEAR(std::remainder(position.clock_h - clock_h, 12.0), 0.0, 5e-3);
        EXPECT_GT(position.clock_h, 0.0);
        EXPECT_LE(position.clock_h, 12.0);
      }
    }
  }
}

TEST(PipeAxis, LocateAgreesWithASearchAlongTheAxis) {
  const PipeAxis axis = AxisOf(BentPipe(2.0, 1.5, 0.3));
  for (const Vector3d& p_W : {Vector3d{4, 3, 1}, Vector3d{9, -2, 0}, Vector3d{5, 0.5, 0.2}}) {
    double best_m = 1e9;
    for (double s = -5; s < axis.length_m() + 5; s += 0.001) {
      best_m = std::min(best_m, (axis.PoseAt(s).translation() - p_W).norm());
    }
    EXPECT_NEAR(axis.Locate(p_W).offset_m, best_m, 1e-3);
  }
}

TEST(PipeAxis, RefusesWhatDoesNotFit) {
  Network touching = OnePipe();
  touching.manholes[1].p_WM.x() = 0.85;
  EXPECT_THROW(AxisOf(touching), std::invalid_argument);
  EXPECT_THROW(AxisOf(BentPipe(pi / 2, 4.7)), std::invalid_argument);  // tangents of 4.7 m + 0.4 m
  EXPECT_NO_THROW(AxisOf(BentPipe(pi / 2, 4.5)));
  EXPECT_THROW(AxisOf(BentPipe(3.1, 0.01)), std::invalid_argument);  // back on itself
  Network steep = OnePipe();
  steep.manholes[1].p_WM.z() = -9.3;
  EXPECT_THROW(AxisOf(steep), std::invalid_argument);
}

TEST(ClockDirection, FollowsTheClockLookingDownstream) {
  ExpectNear(ClockDirection(12), {0, 0, 1}, 1e-12);
  ExpectNear(ClockDirection(3), {0, -1, 0}, 1e-12);
  ExpectNear(ClockDirection(6), {0, 0, -1}, 1e-12);
  ExpectNear(ClockDirection(9), {0, 1, 0}, 1e-12);
}

}  // namespace
}  // namespace kantaro::network
