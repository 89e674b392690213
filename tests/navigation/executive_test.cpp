#include "navigation/executive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "base/random.hpp"
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

LaserObservation Windows(RunTime at, const std::vector<perception::WindowEdge>& edges) {
  LaserObservation laser;
  laser.captured_at = at;
  laser.edges = edges;
  return laser;
}

RunTime At(double time_s) { return RunTime(static_cast<RunTime::rep>(time_s * 1e9)); }

Executive Robot(const network::Network& network, const std::vector<std::string>& manholes,
                double map_factor = 1.0, double start_distance_m = 0.6) {
  std::map<std::string, double> factors;
  for (const network::Pipe& pipe : network.pipes) factors[pipe.name] = map_factor;
  return {MakeRoute(network, manholes, factors), start_distance_m, Kantaro(), ShippedParameters()};
}

/// Drives a route with a true map; the puppet tells what came of it.
Puppet Drive(const network::Network& network, const std::vector<std::string>& manholes,
             const PuppetSetup& setup = {}, double map_factor = 1.0) {
  Puppet puppet(network, manholes, setup);
  Executive executive = Robot(network, manholes, map_factor, setup.start_distance_m);
  puppet.Drive(executive);
  return puppet;
}

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

// ---- what every command obeys ----

/// The wheels roll about as they are told.
perception::Observation Rolled(RandomStream& random, double& time_s, double& travel_m,
                               bool backwards) {
  time_s += random.Uniform(-0.025, 0.075);
  travel_m += (backwards ? -1.0 : 1.0) * random.Uniform(0.0, 0.02);
  return OdometryObservation{At(time_s), travel_m, travel_m, travel_m};
}

perception::Observation AnyObservation(RandomStream& random, double& time_s, bool attitude) {
  time_s += random.Uniform(-0.025, 0.075);
  const RunTime at = At(time_s);
  const auto coin = [&] { return random.Index(2) == 1; };
  switch (attitude ? 3 : random.Index(5)) {
    case 0: {
      LaserObservation laser;
      laser.captured_at = at;
      for (const LaserWindow window :
           {LaserWindow::kRight, LaserWindow::kTop, LaserWindow::kLeft}) {
        if (random.Index(10) == 0)
          laser.edges.push_back({window, coin(), at - At(random.Uniform(0.0, 0.3))});
      }
      return laser;
    }
    case 1:
      return IrObservation{at, random.Index(20) == 0, coin(), coin()};
    case 2: {
      perception::RingObservation rings{at, {}};
      for (std::uint64_t i = random.Index(4); i > 0; --i) {
        perception::RingSighting ring;
        ring.kind = coin() ? perception::RingKind::kJoint : perception::RingKind::kManholeMouth;
        ring.distance_m = random.Uniform(0.2, 1.6);
        rings.rings.push_back(ring);
      }
      return rings;
    }
    case 3:
      // Mostly still, or no one would turn by such a gyro.
      return AttitudeObservation{
          at, random.Uniform(-3, 3), random.Uniform(-9, 9),
          random.Index(5) == 0 ? random.Uniform(-9, 9) : random.Uniform(-0.02, 0.02)};
    default:
      return perception::FaultObservation{at, {}};
  }
}

// Whatever the sensors say, with clocks that run backwards: never above 15 cm/s (thesis 5.6), never
// more than the motors' 0.25 m/s at one wheel (models/kantaro/kantaro.yaml), always a number.
TEST(Executive, KeepsTheSpeedLimitWhateverItSees) {
  network::Network network = TeeField();
  network.pipes[0].joints = {{1.5, 0.008, 0.006}, {3.3, 0.008, 0.006}};
  network.pipes[0].inlets = {{"left", 2.0, 0.1, 9.0}, {"right", 5.0, 0.1, 3.0}};
  std::set<Phase> phases;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    RandomStream random(seed, "observations");
    Executive executive = Robot(network, {"A", seed % 2 == 0 ? "C" : "E"});
    double time_s = 0.0, travel_m = 0.0;
    robot::Command command;
    for (int i = 0; i < 2500; ++i) {
      command =
          executive.Step(i % 2 == 0 ? Rolled(random, time_s, travel_m, command.left_rad_s < 0.0)
                                    : AnyObservation(random, time_s, i % 4 == 1));
      const double left_m_s = 0.045 * command.left_rad_s, right_m_s = 0.045 * command.right_rad_s;
      ASSERT_LE(std::abs(left_m_s + right_m_s) / 2.0, 0.15) << "seed " << seed << ", step " << i;
      ASSERT_LE(std::abs(left_m_s), 0.25) << "seed " << seed << ", step " << i;
      ASSERT_LE(std::abs(right_m_s), 0.25) << "seed " << seed << ", step " << i;
      const Estimate estimate = executive.estimate();
      ASSERT_TRUE(std::isfinite(estimate.distance_m) && std::isfinite(estimate.deviation_m) &&
                  std::isfinite(estimate.leg_length_m))
          << "seed " << seed << ", step " << i;
      ASSERT_LT(estimate.leg, executive.route().legs.size());
      phases.insert(executive.phase());
    }
  }
  EXPECT_THAT(phases, testing::IsSupersetOf(
                          {Phase::kBackingUp, Phase::kTurning, Phase::kLeaving, Phase::kFailed}))
      << "the sequences reach into the manoeuvres";
}

TEST(Executive, NeverExceedsTheLimitOnAMission) {
  EXPECT_LE(Drive(TeeField(), {"A", "C"}).fastest_m_s(), 0.15);
  EXPECT_LE(Drive(Curve(), {"A", "C"}).fastest_m_s(), 0.15);
}

// High on the left, it has climbed the left wall: steering right brings it down.
perception::RingObservation Ring(double time_s, perception::RingKind kind, double distance_m) {
  perception::RingObservation rings;
  rings.captured_at = At(time_s);
  rings.rings.push_back({kind, distance_m, 100.0, 1.0, 0.0, 0.0});
  return rings;
}

/// One pipe of 100 m between its shafts, jointed every 1.8 m.
network::Network LongPipe() {
  network::Network network;
  for (const auto& [name, x_m] : {std::pair{"A", 0.0}, std::pair{"Z", 100.8}}) {
    network::Manhole manhole;
    manhole.name = name;
    manhole.p_WM.x() = x_m;
    network.manholes.push_back(manhole);
  }
  network::Pipe pipe;
  pipe.name = "AZ";
  pipe.upstream = "A";
  pipe.downstream = "Z";
  pipe.diameter_m = 0.300;
  for (double chainage_m = 1.8; chainage_m < 99.0; chainage_m += 1.8) {
    network::Joint joint;
    joint.chainage_m = chainage_m;
    pipe.joints.push_back(joint);
  }
  network.pipes.push_back(pipe);
  return network;
}

// 80 m into a pipe whose map may be 3 % off, 2.4 m, the joint ahead is any of three.
TEST(Executive, TakesNoJointWhereTheNextMayAsWellBeMeant) {
  Executive executive = Robot(LongPipe(), {"A", "Z"}, 1.0, 80.0);
  (void)executive.Step(OdometryObservation{At(0.02), 0.0, 0.0, 0.0});
  const Estimate before = executive.estimate();
  (void)executive.Step(Ring(0.04, perception::RingKind::kJoint, 0.9));
  EXPECT_EQ(executive.estimate().leg_length_m, before.leg_length_m);
  EXPECT_EQ(executive.estimate().deviation_m, before.deviation_m);
}

TEST(Executive, TakesTheJointThatCanOnlyBeMeant) {
  Executive executive = Robot(LongPipe(), {"A", "Z"}, 1.0, 1.0);
  (void)executive.Step(OdometryObservation{At(0.02), 0.0, 0.0, 0.0});
  const Estimate before = executive.estimate();
  (void)executive.Step(Ring(0.04, perception::RingKind::kJoint, 0.6));
  EXPECT_LT(executive.estimate().deviation_m, before.deviation_m);
}

// A mouth 1 m ahead that is none: driven past, it is unlearned, and the map holds again.
TEST(Executive, DisbelievesAMouthThatNoWallFollows) {
  Executive executive = Robot(LongPipe(), {"A", "Z"}, 1.0, 95.0);
  (void)executive.Step(OdometryObservation{At(0.02), 0.0, 0.0, 0.0});
  double time_s = 0.1;
  double travel_m = 0.0;
  for (double distance_m = 1.0; distance_m > 0.85; distance_m -= 0.025) {
    (void)executive.Step(Ring(time_s, perception::RingKind::kManholeMouth, distance_m));
    time_s += 0.2;
    travel_m += 0.025;
    (void)executive.Step(OdometryObservation{At(time_s), travel_m, travel_m, travel_m});
  }
  EXPECT_LT(executive.estimate().leg_length_m, 97.0);
  for (; travel_m < 3.0; travel_m += 0.01) {
    time_s += 0.1;
    (void)executive.Step(Windows(At(time_s), {}));
    (void)executive.Step(OdometryObservation{At(time_s), travel_m, travel_m, travel_m});
  }
  EXPECT_EQ(executive.phase(), Phase::kDriving);
  EXPECT_DOUBLE_EQ(executive.estimate().leg_length_m, 100.0);
}

TEST(Executive, SteersDownhill) {
  Executive executive = Robot(TeeField(), {"A", "M"});
  const robot::Command right = executive.Step(AttitudeObservation{At(0.1), 0.1, 0.0, 0.0});
  EXPECT_GT(right.left_rad_s, right.right_rad_s);
  const robot::Command left = executive.Step(AttitudeObservation{At(0.2), -0.1, 0.0, 0.0});
  EXPECT_GT(left.right_rad_s, left.left_rad_s);
  const robot::Command straight = executive.Step(AttitudeObservation{At(0.3), 0.0, 0.0, 0.0});
  EXPECT_EQ(straight.left_rad_s, straight.right_rad_s);
}

// Rolling back upright already, it steers less.
TEST(Executive, DampsItsRoll) {
  Executive executive = Robot(TeeField(), {"A", "M"});
  const auto steer = [&](double roll_rad, double rate_rad_s) {
    const robot::Command c =
        executive.Step(AttitudeObservation{At(0.1), roll_rad, rate_rad_s, 0.0});
    return c.right_rad_s - c.left_rad_s;
  };
  EXPECT_LT(std::abs(steer(0.1, -0.05)), std::abs(steer(0.1, 0.0)));
}

// Crossing a shaft it has no round wall to lean on: drifted to the left, it steers right.
TEST(Executive, HoldsItsHeadingAcrossAManhole) {
  Puppet puppet(TeeField(), {"A", "E"}, {});
  Executive executive = Robot(TeeField(), {"A", "E"});
  bool tried = false;
  puppet.meddle = [&](perception::Observation& observation, const Puppet& truth) {
    if (tried || truth.leg() != 0 || truth.beyond_m() < 0.2) return;
    tried = true;
    const RunTime now = std::visit([](const auto& seen) { return seen.captured_at; }, observation);
    (void)executive.Step(AttitudeObservation{now, 0.0, 0.0, 1.0});
    const robot::Command command =
        executive.Step(AttitudeObservation{now + At(0.1), 0.0, 0.0, 1.0});
    EXPECT_GT(command.left_rad_s, command.right_rad_s);
    (void)executive.Step(AttitudeObservation{now + At(0.1), 0.0, 0.0, -1.0});
    (void)executive.Step(AttitudeObservation{now + At(0.2), 0.0, 0.0, -1.0});
  };
  puppet.Drive(executive, 80.0);
  EXPECT_TRUE(tried);
}

TEST(Executive, SlowsDownBeforeTheManholeWhereItTurns) {
  Puppet puppet(TeeField(), {"A", "C"}, {});
  Executive executive = Robot(TeeField(), {"A", "C"});
  puppet.Drive(executive, 100.0);
  Executive slow = Robot(TeeField(), {"A", "C"});
  const double cruise = slow.Step(OdometryObservation{At(0.02), 0.0, 0.0, 0.0}).left_rad_s;
  const double near = slow.Step(OdometryObservation{At(50.0), 6.3, 6.3, 6.3}).left_rad_s;
  EXPECT_NEAR(cruise * 0.045, 0.13, 1e-9);
  EXPECT_NEAR(near * 0.045, 0.08, 1e-9);
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
