#include "network/pipe_axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

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

Joint JointAt(double chainage_m) {
  Joint joint;
  joint.chainage_m = chainage_m;
  return joint;
}

Joint Offset(double chainage_m, double offset_m, double clock_h) {
  Joint joint = JointAt(chainage_m);
  joint.offset_m = offset_m;
  joint.offset_clock_h = clock_h;
  return joint;
}

Joint Deflected(double chainage_m, double degrees, double clock_h) {
  Joint joint = JointAt(chainage_m);
  joint.deflection_rad = degrees * pi / 180;
  joint.deflection_clock_h = clock_h;
  return joint;
}

double HeightAt(const PipeAxis& axis, double chainage_m) {
  return axis.PoseAt(chainage_m).translation().z();
}

/// The last pose before a break of the line.
Isometry3d PoseBefore(const PipeAxis& axis, double chainage_m) {
  return axis.PoseAt(chainage_m - 1e-9);
}

TEST(PipeAxis, IsTheDesignLineIfNothingDisplacesIt) {
  Network network = BentPipe(0.9, 0.45, 0.2);
  const PipeAxis bare = AxisOf(network);
  network.pipes[0].joints = {JointAt(2), JointAt(4)};
  const PipeAxis jointed = AxisOf(network);
  EXPECT_EQ(jointed.length_m(), bare.length_m());
  ASSERT_EQ(jointed.pieces().size(), bare.pieces().size());
  for (std::size_t i = 0; i < bare.pieces().size(); ++i) {
    EXPECT_TRUE(jointed.pieces()[i].X_WS.matrix() == bare.pieces()[i].X_WS.matrix());
  }
}

// 9.2 m between walls; half-way the next length lies 10 mm lower. The ends are held, so both
// halves rise by 5 mm.
TEST(PipeAxis, HoldsTheEndsOfAPipeWithAnOffset) {
  Network network = OnePipe();
  network.pipes[0].joints = {Offset(4.6, 0.010, 6)};
  const PipeAxis axis = AxisOf(network);
  EXPECT_NEAR(HeightAt(axis, 0), 0.150, 1e-12);
  EXPECT_NEAR(PoseBefore(axis, 4.6).translation().z(), 0.155, 1e-8);
  EXPECT_NEAR(HeightAt(axis, 4.6), 0.145, 1e-8);
  EXPECT_NEAR(HeightAt(axis, 2.3), 0.1525, 1e-8);
  ExpectNear(axis.PoseAt(axis.length_m()).translation(), {9.6, 0, 0.15}, 1e-9);
  EXPECT_NEAR(axis.length_m(), 2 * std::hypot(4.6, 0.005), 1e-9);
}

TEST(PipeAxis, ShiftsTowardsTheClockLookingDownstream) {
  Network network = OnePipe();
  network.pipes[0].joints = {Offset(4.6, 0.010, 3)};  // to the right: −y
  const PipeAxis axis = AxisOf(network);
  ExpectNear(axis.PoseAt(4.6).translation() - PoseBefore(axis, 4.6).translation(), {0, -0.010, 0},
             1e-8);
}

// A quarter of the way along, the pipe turns 2° to the right. A straight line from end to end
// passes 3/4 of 2° to the right of the first length: the joint stands to the left of it.
TEST(PipeAxis, TurnsAtADeflectedJoint) {
  Network network = OnePipe();
  network.pipes[0].joints = {Deflected(2.3, 2.0, 3)};
  const PipeAxis axis = AxisOf(network);
  const Vector3d before = PoseBefore(axis, 2.3).linear().col(0),
                 after = axis.PoseAt(2.3).linear().col(0);
  EXPECT_NEAR(std::acos(before.dot(after)), 2 * pi / 180, 2e-5);
  EXPECT_LT(after.y(), 0.0);
  EXPECT_GT(before.y(), 0.0);
  EXPECT_NEAR(axis.PoseAt(2.3).translation().y(), 0.75 * std::tan(2 * pi / 180) * 2.3, 1e-4);
  ExpectNear(axis.PoseAt(2.3).translation(), PoseBefore(axis, 2.3).translation(), 1e-8);
  ExpectNear(axis.PoseAt(axis.length_m()).translation(), {9.6, 0, 0.15}, 1e-9);
}

// A sag of 40 mm from 2 to 6 m: at 3 and 5 m the parabola is 30 mm deep, at 4 m 40 mm.
TEST(PipeAxis, SagsAlongChordsFromJointToJoint) {
  Network network = OnePipe();
  for (int i = 1; i <= 8; ++i) network.pipes[0].joints.push_back(JointAt(i));
  network.pipes[0].sags = {{2, 6, 0.040}};
  const PipeAxis axis = AxisOf(network);
  EXPECT_NEAR(HeightAt(axis, 1.5), 0.150, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 2), 0.150, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 2.5), 0.135, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 3), 0.120, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 3.5), 0.115, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 4), 0.110, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 5), 0.120, 1e-9);
  EXPECT_NEAR(HeightAt(axis, 7), 0.150, 1e-9);
}

/// Height of the invert just before and after the step at 4 m from 250 to 300 mm.
std::pair<double, double> InvertsAtStep(const PipeAxis& axis) {
  const Isometry3d before = PoseBefore(axis, 4), after = axis.PoseAt(4);
  return {(before * Vector3d(0, 0, -0.125)).z(), (after * Vector3d(0, 0, -0.150)).z()};
}

TEST(PipeAxis, StepsWhereTheDiameterChanges) {
  Network network = OnePipe();
  network.pipes[0].diameter_m = 0.25;
  network.pipes[0].diameter_changes = {{4, 0.30, Alignment::kInvert}};
  const PipeAxis invert = AxisOf(network);
  EXPECT_NEAR(InvertsAtStep(invert).first, 0.0, 1e-9);
  EXPECT_NEAR(InvertsAtStep(invert).second, 0.0, 1e-9);
  EXPECT_NEAR(invert.grade(), 0.0, 1e-12);

  network.pipes[0].diameter_changes[0].alignment = Alignment::kAxis;
  const PipeAxis centred = AxisOf(network);
  EXPECT_NEAR(centred.grade(), 0.025 / (10 - 0.375 - 0.4), 1e-12);  // from 125 to 150 mm
  ExpectNear(centred.PoseAt(4).translation(), PoseBefore(centred, 4).translation(), 1e-8);

  network.pipes[0].diameter_changes[0].alignment = Alignment::kCrown;
  const PipeAxis crown = AxisOf(network);
  const Isometry3d before = PoseBefore(crown, 4), after = crown.PoseAt(4);
  ExpectNear(before * Vector3d(0, 0, 0.125), after * Vector3d(0, 0, 0.150), 1e-8);
  for (const PipeAxis* axis : {&invert, &centred, &crown}) {
    ExpectNear(axis->PoseAt(0).translation(), {0.375, 0, 0.125}, 1e-12);
    ExpectNear(axis->PoseAt(axis->length_m()).translation(), {9.6, 0, 0.15}, 1e-9);
  }
}

TEST(PipeAxis, MeetsBothInvertsOnASteepGradeWithSteps) {
  Network network = OnePipe();
  network.manholes[0].p_WM.z() = 4.0;
  network.pipes[0].diameter_changes = {{2, 0.20, Alignment::kCrown}, {6, 0.35, Alignment::kInvert}};
  const PipeAxis axis = AxisOf(network);
  ExpectNear(axis.PoseAt(0).translation(), {0.4, 0, 4.15}, 1e-9);
  ExpectNear(axis.PoseAt(axis.length_m()).translation(), {10 - 0.425, 0, 0.175}, 1e-6);
}

/// A pipe with a bend of `turn`, joints every metre displaced at random, a sag and a step.
Network Disturbed(unsigned seed, double turn) {
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Network network = BentPipe(turn, draw(0.45, 3.0), draw(-0.3, 0.3));
  for (int i = 1; i <= 7; ++i) {
    Joint joint = Offset(i, draw(0, 0.015), draw(0.1, 12));
    joint.deflection_rad = draw(0, 0.03);
    joint.deflection_clock_h = draw(0.1, 12);
    network.pipes[0].joints.push_back(joint);
  }
  network.pipes[0].sags = {{draw(0, 2), draw(4, 7), draw(0.005, 0.04)}};
  network.pipes[0].diameter_changes = {{draw(2.2, 2.8), draw(0.25, 0.35), Alignment::kInvert}};
  return network;
}

// Whatever displaces it: the line ends at its manhole, the joints stand at their chainage, and
// there alone the line is broken, by the offset.
TEST(PipeAxis, HoldsTogetherHoweverItIsDisplaced) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const double turn = (seed % 13 - 6.0) * 0.22;
    const Network network = Disturbed(seed, turn);
    const Pipe& pipe = network.pipes[0];
    const PipeAxis axis = AxisOf(network);
    const Vector3d end = axis.PoseAt(axis.length_m()).translation();
    EXPECT_NEAR(end.z(), network.manholes[1].p_WM.z() + pipe.DownstreamDiameter() / 2, 1e-4);
    const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
    EXPECT_LT((end.head<2>() + network.ShaftDiameter(network.manholes[1]) / 2 * along -
               network.manholes[1].p_WM.head<2>())
                  .norm(),
              1e-4);
    std::set<double> breaks;
    for (const Joint& joint : pipe.joints) {
      breaks.insert(joint.chainage_m);
      const Vector3d apart = axis.PoseAt(joint.chainage_m).translation() -
                             PoseBefore(axis, joint.chainage_m).translation();
      EXPECT_NEAR(apart.norm(), joint.offset_m, 1e-6);
    }
    breaks.insert(pipe.diameter_changes[0].chainage_m);
    double gone_m = 0.0;
    for (std::size_t i = 0; i < axis.pieces().size(); ++i) {
      const AxisPiece& piece = axis.pieces()[i];
      EXPECT_NEAR(piece.start_m, gone_m, 1e-9);
      gone_m += piece.length_m;
      if (i == 0) continue;
      const AxisPiece& before = axis.pieces()[i - 1];
      const auto near = breaks.lower_bound(piece.start_m - 1e-8);
      if (near != breaks.end() && *near < piece.start_m + 1e-8) {
        breaks.erase(near);
        continue;
      }
      const Isometry3d X_WE = PoseOn(before, before.length_m);
      ExpectNear(X_WE.translation(), piece.X_WS.translation(), 1e-9);
      EXPECT_LT(std::acos(std::min(1.0, X_WE.linear().col(0).dot(piece.X_WS.linear().col(0)))),
                0.015);  // a few percent of slopes up to 0.15, and of the grade
    }
    EXPECT_TRUE(breaks.empty());
  }
}

TEST(PipeAxis, LocatesWhatItPlacedInADisplacedPipe) {
  const PipeAxis axis = AxisOf(Disturbed(5, 0.6));
  for (double chainage_m = 0.25; chainage_m < axis.length_m(); chainage_m += 0.5) {
    const PipePosition position =
        axis.Locate(axis.PoseAt(chainage_m) * (0.1 * ClockDirection(4.0)));
    EXPECT_NEAR(position.chainage_m, chainage_m, 2e-3);  // lengths fold by 0.1 m · slope
    EXPECT_NEAR(position.offset_m, 0.1, 1e-3);
  }
}

TEST(PipeAxis, RefusesToWindAbout) {
  Network network = OnePipe();
  for (int i = 1; i <= 8; ++i) network.pipes[0].joints.push_back(Deflected(i, 10, 3));
  EXPECT_THROW(AxisOf(network), std::invalid_argument);
  Network bent = BentPipe(pi / 2, 0.2);
  bent.pipes[0].joints = {Deflected(2.0, 9, 3)};  // pushes the bend 0.5 m inwards
  EXPECT_THROW(AxisOf(bent), std::invalid_argument);
}

TEST(DesignLength, ForgetsWhatDisplacesThePipe) {
  Network network = OnePipe();
  network.pipes[0].joints = {Offset(4.6, 0.1, 6)};
  const ShaftEnd a{network.manholes[0].p_WM, 0.4}, b{network.manholes[1].p_WM, 0.4};
  EXPECT_NEAR(DesignLength(a, b, network.pipes[0]), 9.2, 1e-12);
  EXPECT_GT(PipeAxis(a, b, network.pipes[0]).length_m(), 9.2005);
}

TEST(ClockDirection, FollowsTheClockLookingDownstream) {
  ExpectNear(ClockDirection(12), {0, 0, 1}, 1e-12);
  ExpectNear(ClockDirection(3), {0, -1, 0}, 1e-12);
  ExpectNear(ClockDirection(6), {0, 0, -1}, 1e-12);
  ExpectNear(ClockDirection(9), {0, 1, 0}, 1e-12);
}

}  // namespace
}  // namespace kantaro::network
