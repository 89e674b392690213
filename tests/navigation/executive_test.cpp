#include "navigation/executive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/navigation/driven.hpp"
#include "tests/navigation/puppet.hpp"
#include "tests/navigation/sewers.hpp"

namespace kantaro::navigation {
namespace {

using perception::AttitudeObservation;
using perception::IrObservation;
using perception::LaserObservation;
using perception::LaserWindow;
using perception::OdometryObservation;
using robot::RunTime;
using testing::HasSubstr;
using testing::Not;

// By the shaft's geometry (R = 0.4 m, ρ = 0.264 m): the bend begins R − ρ = 0.136 m behind the
// wall, and steering begins when the front axle (90 mm before the base) is 60 mm short of it.
constexpr double kTurnBegins_m = 0.136 - 0.09 - 0.06;
// The laser, 170 mm behind the base, sees the branch 0.207 m behind the wall: where the inner wall
// of its channel, of radius ρ − D/2 = 0.114 m about (0.136, 0.264), is 0.175 m from the axis, at
// 0.136 + √(0.114² − 0.089²). Three revolutions settle it.
const double kBranchSeen_m = 0.136 + std::sqrt(0.114 * 0.114 - 0.089 * 0.089) + 0.17;

void ExpectArrival(const Puppet& puppet, std::size_t last_leg) {
  EXPECT_FALSE(puppet.crashed()) << puppet.story();
  ASSERT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
  EXPECT_EQ(puppet.leg(), last_leg);
  // The laser, 170 mm behind the base, is in the shaft; the base in its first half.
  EXPECT_GT(puppet.beyond_m(), 0.17 - 0.01) << puppet.story();
  EXPECT_LT(puppet.beyond_m(), 0.40) << puppet.story();
}

TEST(Executive, NeedsALeg) {
  EXPECT_THROW(Executive(MapRoute{"A", {}}, 0.6, Kantaro(), ShippedParameters()),
               std::invalid_argument);
}

TEST(Executive, ArrivesWhenTheLaserStandsInTheGoalsShaft) {
  const Puppet puppet = Drive(TeeField(), {"A", "M"});
  ExpectArrival(puppet, 0);
  EXPECT_THAT(puppet.story(), HasSubstr("reached manhole M"));
  EXPECT_TRUE(puppet.turns().empty());
}

TEST(Executive, BacksUpAndTurnsAtATee) {
  const Puppet puppet = Drive(TeeField(), {"A", "C"});
  ExpectArrival(puppet, 1);
  ASSERT_EQ(puppet.turns().size(), 1u) << puppet.story();
  EXPECT_EQ(puppet.turns()[0].leg, 0u);
  EXPECT_TRUE(puppet.turns()[0].left);
  EXPECT_NEAR(puppet.turns()[0].beyond_m, kTurnBegins_m, 0.015);
}

// "If the robot enters into the manhole and is to turn it moves backward by 40 cm and turns"
// (thesis 5.6).
TEST(Executive, BacksUpByWhatTheGeometryGives) {
  const Puppet puppet = Drive(TeeField(), {"A", "C"});
  EXPECT_NEAR(puppet.First(Phase::kBackingUp).beyond_m, kBranchSeen_m, 0.015);
  EXPECT_NEAR(puppet.longest_reverse_m(), kBranchSeen_m - kTurnBegins_m, 0.025);
  EXPECT_NEAR(puppet.longest_reverse_m(), 0.40, 0.03);
}

// Steering against a roll would steer uphill in reverse.
TEST(Executive, BacksUpStraight) {
  Puppet puppet(TeeField(), {"A", "C"}, {});
  Executive executive = Robot(TeeField(), {"A", "C"});
  puppet.meddle = [&](perception::Observation& observation, const Puppet&) {
    auto* attitude = std::get_if<AttitudeObservation>(&observation);
    if (attitude != nullptr && executive.phase() == Phase::kBackingUp) attitude->roll_rad = 0.3;
  };
  puppet.Drive(executive);
  ExpectArrival(puppet, 1);
}

TEST(Executive, TurnsAtATeeOnlyAfterTheLasersJunction) {
  const std::string story = Drive(TeeField(), {"A", "C"}).story();
  const auto manhole = story.find("laser: manhole M"),
             junction = story.find("laser: junction to the left"), back = story.find("back up"),
             turn = story.find("turn into"), pipe = story.find("turned by");
  ASSERT_NE(pipe, std::string::npos) << story;
  EXPECT_LT(manhole, junction);
  EXPECT_LT(junction, back);
  EXPECT_LT(back, turn);
  EXPECT_LT(turn, pipe);
}

// From the stem of a tee the nose meets the far wall when the base is R + D/2 - 0.16 m behind the
// near one, less if the robot stands askew; the laser, 170 mm behind, may then never see the
// branches.
TEST(Executive, TurnsAtATeeThatItEntersByTheStem) {
  PuppetSetup setup;
  setup.farthest_beyond_m = kBranchSeen_m - 0.02;
  const Puppet puppet = Drive(TeeField(), {"C", "A"}, setup);
  ExpectArrival(puppet, 1);
  ASSERT_EQ(puppet.turns().size(), 1u) << puppet.story();
  EXPECT_FALSE(puppet.turns()[0].left);
}

TEST(Executive, TurnsRightWhereTheBranchLiesToTheRight) {
  const Puppet puppet = Drive(TeeField(), {"B", "C"});
  ExpectArrival(puppet, 1);
  ASSERT_EQ(puppet.turns().size(), 1u) << puppet.story();
  EXPECT_FALSE(puppet.turns()[0].left);
  EXPECT_NEAR(puppet.longest_reverse_m(), kBranchSeen_m - kTurnBegins_m, 0.025)
      << "driven upstream, it is the same";
}

TEST(Executive, PassesATeeStraight) {
  const Puppet puppet = Drive(TeeField(), {"A", "E"});
  ExpectArrival(puppet, 2);
  EXPECT_TRUE(puppet.turns().empty());
  EXPECT_FALSE(puppet.Was(Phase::kBackingUp));
  EXPECT_EQ(puppet.longest_reverse_m(), 0.0);
  EXPECT_THAT(puppet.story(), HasSubstr("laser: entered pipe P2"));
  EXPECT_THAT(puppet.story(), HasSubstr("laser: entered pipe P4"));
}

TEST(Executive, FollowsACurveWithoutBackingUp) {
  const Puppet puppet = Drive(Curve(), {"A", "C"});
  ExpectArrival(puppet, 1);
  EXPECT_FALSE(puppet.Was(Phase::kBackingUp));
  ASSERT_EQ(puppet.turns().size(), 1u) << puppet.story();
  EXPECT_NEAR(puppet.turns()[0].beyond_m, kTurnBegins_m, 0.015);
}

// Round the block the route ends in the tee that it passed first: one manhole, met twice.
TEST(Executive, ReachesATeeThatItPassedBefore) {
  const Puppet puppet = Drive(Block(), {"A", "X", "Z", "Y", "T"});
  ExpectArrival(puppet, 4);
  EXPECT_EQ(puppet.turns().size(), 3u) << puppet.story();
  EXPECT_THAT(puppet.story(), HasSubstr("reached manhole T"));
}

class MapOff : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Executive, MapOff, testing::Values(0.95, 1.05));

TEST_P(MapOff, TurnsAtTheTeeWhereItIs) {
  const Puppet puppet = Drive(TeeField(), {"A", "C"}, {}, GetParam());
  ExpectArrival(puppet, 1);
  ASSERT_EQ(puppet.turns().size(), 1u);
  EXPECT_NEAR(puppet.turns()[0].beyond_m, kTurnBegins_m, 0.02);
}

TEST_P(MapOff, PassesTheTeeStraight) {
  ExpectArrival(Drive(TeeField(), {"A", "E"}, {}, GetParam()), 2);
}

TEST_P(MapOff, FollowsTheCurve) { ExpectArrival(Drive(Curve(), {"A", "C"}, {}, GetParam()), 1); }

TEST_P(MapOff, DrivesThroughWithSlippingWheelsAndCamera) {
  network::Network network = TeeField();
  for (network::Pipe& pipe : network.pipes) {
    for (const double chainage_m : {1.5, 3.3, 5.1, 6.9})
      pipe.joints.push_back({chainage_m, 0.008, 0.006});
  }
  PuppetSetup setup;
  setup.camera = true;
  setup.scale = 0.98;
  ExpectArrival(Drive(network, {"A", "C"}, setup, GetParam()), 1);
}

// 40 m of pipe, of which the map has 38 m: the tee comes 2 m, a pipe's width many times over, after
// it is due.
TEST(Executive, WaitsForATeeAsLongAsTheMapMayBeOff) {
  network::Network network = TeeField();
  network.manholes[0].p_WM.x() = 8.0 - 40.8;
  ExpectArrival(Drive(network, {"A", "C"}, {}, 0.95), 1);
}

// IR, laser and camera see one wall one after the other: one manhole, passed once.
TEST(Executive, CountsAWallSeenByEverySensorOnce) {
  network::Network network = TeeField();
  PuppetSetup setup;
  setup.camera = true;
  Puppet puppet(network, {"A", "E"}, setup);
  Executive executive = Robot(network, {"A", "E"});
  double largest_m = 0.0;
  puppet.meddle = [&](perception::Observation&, const Puppet& truth) {
    if (executive.estimate().leg == truth.leg()) {
      largest_m =
          std::max(largest_m, std::abs(executive.estimate().distance_m - truth.distance_m()));
    }
  };
  puppet.Drive(executive);
  ExpectArrival(puppet, 2);
  EXPECT_LT(largest_m, 0.05);
}

// Joints that no map has still tell how far the robot comes: wheels that slip by 5 % are found out.
TEST(Executive, LearnsSlipFromRingsThatAreNotOnTheMap) {
  network::Network network = TeeField();
  network.manholes[0].p_WM.x() = 8.0 - 20.8;
  Executive executive = Robot(network, {"A", "M"});
  for (int i = 1; i < 11; ++i) network.pipes[0].joints.push_back({1.8 * i, 0.008, 0.006});
  PuppetSetup setup;
  setup.camera = true;
  setup.scale = 0.95;
  Puppet puppet(network, {"A", "M"}, setup);
  puppet.Drive(executive, 130.0);
  ASSERT_GT(puppet.distance_m(), 15.0);
  ASSERT_LT(puppet.beyond_m(), -2.0) << "no wall has helped";
  const double by_the_wheels_m = 0.6 + (puppet.distance_m() - 0.6) / 0.95;
  EXPECT_LT(std::abs(executive.estimate().distance_m - puppet.distance_m()),
            0.5 * (by_the_wheels_m - puppet.distance_m()));
}

TEST(Executive, LearnsHowLongThePipeIs) {
  Puppet puppet(TeeField(), {"A", "M"}, {});
  Executive executive = Robot(TeeField(), {"A", "M"}, 1.05);
  puppet.Drive(executive);
  const Estimate estimate = executive.estimate();
  EXPECT_NEAR(estimate.distance_m - estimate.leg_length_m, puppet.beyond_m(), 0.02);
}

// ---- what must not happen ----

TEST(Executive, DoesNotTurnWithoutTheJunction) {
  PuppetSetup setup;
  setup.side_walls_open = false;
  const Puppet puppet = Drive(TeeField(), {"A", "C"}, setup);
  EXPECT_TRUE(puppet.turns().empty()) << puppet.story();
  EXPECT_TRUE(puppet.Was(Phase::kFailed));
  EXPECT_THAT(puppet.story(), HasSubstr("no junction was found in manhole M"));
}

TEST(Executive, DoesNotTurnWithoutTheManhole) {
  PuppetSetup setup;
  setup.tops_open = false;
  for (const auto& network : {TeeField(), Curve()}) {
    const Puppet puppet = Drive(network, {"A", "C"}, setup);
    EXPECT_TRUE(puppet.turns().empty()) << puppet.story();
    EXPECT_TRUE(puppet.Was(Phase::kFailed));
    EXPECT_THAT(puppet.story(), HasSubstr("manhole M was not found where the map has it"));
  }
}

// An inlet on the side of the turn, a metre before the tee, is no junction.
TEST(Executive, DoesNotTurnAtAnInlet) {
  network::Network network = TeeField();
  network.pipes[0].inlets = {{"house", 6.2, 0.15, 9.0}};
  const Puppet puppet = Drive(network, {"A", "C"});
  ExpectArrival(puppet, 1);
  EXPECT_THAT(puppet.story(), HasSubstr("laser: inlet on the left"));
  EXPECT_NEAR(puppet.turns().at(0).beyond_m, kTurnBegins_m, 0.015);
}

TEST(Executive, StandsStillOnceItHasFailed) {
  PuppetSetup setup;
  setup.side_walls_open = false;
  Puppet puppet(TeeField(), {"A", "C"}, setup);
  Executive executive = Robot(TeeField(), {"A", "C"});
  puppet.Drive(executive);
  ASSERT_EQ(executive.phase(), Phase::kFailed);
  const std::vector<perception::Observation> later{
      OdometryObservation{At(900), 50.0, 50.0, 50.0}, AttitudeObservation{At(901), 1.0, 1.0, 1.0},
      IrObservation{At(902), true, true, true},
      Windows(At(903), {{LaserWindow::kTop, true, At(903)}, {LaserWindow::kLeft, true, At(903)}})};
  for (const perception::Observation& observation : later) {
    const robot::Command command = executive.Step(observation);
    EXPECT_EQ(command.left_rad_s, 0.0);
    EXPECT_EQ(command.right_rad_s, 0.0);
  }
  EXPECT_EQ(executive.phase(), Phase::kFailed);
}

TEST(Executive, StandsStillOnceItHasArrived) {
  Puppet puppet(TeeField(), {"A", "M"}, {});
  Executive executive = Robot(TeeField(), {"A", "M"});
  puppet.Drive(executive);
  ASSERT_EQ(executive.phase(), Phase::kArrived);
  EXPECT_TRUE(executive.finished());
  const robot::Command command = executive.Step(OdometryObservation{At(900), 90.0, 90.0, 90.0});
  EXPECT_EQ(command.left_rad_s, 0.0);
  EXPECT_EQ(command.right_rad_s, 0.0);
}

// Set down with the laser still in the start shaft, a tee: its windows are open, but of a manhole
// that lies behind.
TEST(Executive, TakesNoJunctionOfTheStartForTheNextManholes) {
  Executive executive = Robot(TeeField(), {"A", "C"}, 1.0, 0.1);
  (void)executive.Step(OdometryObservation{At(0.1), 0.0, 0.0, 0.0});
  (void)executive.Step(Windows(At(0.1), {{LaserWindow::kRight, true, At(0.1)},
                                         {LaserWindow::kTop, true, At(0.1)},
                                         {LaserWindow::kLeft, true, At(0.1)}}));
  // 7 m on, the IR (110 mm before the base) comes to the shaft of M, and the laser still reports.
  (void)executive.Step(OdometryObservation{At(60.0), 6.99, 6.99, 6.99});
  (void)executive.Step(Windows(At(60.0), {{LaserWindow::kTop, false, At(2.0)},
                                          {LaserWindow::kLeft, false, At(2.0)},
                                          {LaserWindow::kRight, false, At(2.0)}}));
  (void)executive.Step(IrObservation{At(60.0), true, false, false});
  EXPECT_EQ(executive.phase(), Phase::kDriving);
  // In the shaft, beyond the bend's start: no junction was seen here.
  (void)executive.Step(OdometryObservation{At(62.0), 7.25, 7.25, 7.25});
  EXPECT_EQ(executive.phase(), Phase::kDriving);
}

// The same by IR, which decides where there is no laser.
TEST(Executive, TakesNoIrJunctionOfTheStartForTheNextManholes) {
  Executive executive = Robot(TeeField(), {"A", "C"}, 1.0, 0.1);
  (void)executive.Step(OdometryObservation{At(9.0), 0.0, 0.0, 0.0});
  (void)executive.Step(IrObservation{At(9.0), true, true, true});
  (void)executive.Step(OdometryObservation{At(10.0), 0.1, 0.1, 0.1});
  (void)executive.Step(IrObservation{At(10.0), false, false, false});
  (void)executive.Step(OdometryObservation{At(60.0), 6.99, 6.99, 6.99});
  (void)executive.Step(IrObservation{At(60.0), true, false, false});
  (void)executive.Step(OdometryObservation{At(61.0), 7.25, 7.25, 7.25});
  EXPECT_EQ(executive.phase(), Phase::kDriving);
  (void)executive.Step(IrObservation{At(61.0), true, true, false});
  EXPECT_EQ(executive.phase(), Phase::kBackingUp) << "that is the junction of M";
}

// Leaving one tee for the next, the laser still looks into the first one's channels.
TEST(Executive, TakesNoJunctionOfTheManholeItLeavesForTheNext) {
  network::Network network = Block();
  network.pipes.push_back(PipeFrom("YW", "Y", "W"));
  network.manholes.push_back(ManholeAt("W", 0, 8));
  const std::vector<std::string> route{"A", "Y", "Z"};
  Executive executive = Robot(network, route);
  Puppet puppet(network, route, {});
  bool shown = false;
  puppet.meddle = [&](perception::Observation& observation, const Puppet&) {
    auto* laser = std::get_if<LaserObservation>(&observation);
    if (laser == nullptr || executive.phase() != Phase::kLeaving || shown) return;
    laser->edges.push_back({LaserWindow::kRight, true, laser->captured_at});
    shown = true;
  };
  puppet.Drive(executive);
  ASSERT_TRUE(shown) << puppet.story();
  ExpectArrival(puppet, 2);
  ASSERT_EQ(puppet.turns().size(), 2u) << puppet.story();
  EXPECT_NEAR(puppet.turns()[1].beyond_m, kTurnBegins_m, 0.02);
  EXPECT_NE(puppet.story().find("back up", puppet.story().find(": manhole Y")), std::string::npos)
      << puppet.story();
}

TEST(Executive, TellsItsStoryOnce) {
  Executive executive = Robot(TeeField(), {"A", "M"});
  (void)executive.Step(OdometryObservation{At(0.0), 0.0, 0.0, 0.0});
  (void)executive.Step(OdometryObservation{At(50.0), 6.49, 6.49, 6.49});
  (void)executive.Step(IrObservation{At(50.0), true, false, false});
  const std::vector<Event> events = executive.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, Event::Kind::kLandmark);
  EXPECT_EQ(events[0].time, At(50.0));
  EXPECT_EQ(events[0].text, "IR: manhole M");
  EXPECT_TRUE(executive.TakeEvents().empty());
}

TEST(Executive, NamesEveryPhase) {
  EXPECT_EQ(ToString(Phase::kBackingUp), "backing up");
  EXPECT_EQ(ToString(Phase::kFailed), "failed");
  EXPECT_THROW((void)ToString(static_cast<Phase>(99)), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::navigation
