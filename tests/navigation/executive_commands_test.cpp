// What every command obeys, and what a single reading does to the next one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/random.hpp"
#include "navigation/executive.hpp"
#include "tests/navigation/driven.hpp"

namespace kantaro::navigation {
namespace {

using perception::AttitudeObservation;
using perception::IrObservation;
using perception::LaserObservation;
using perception::LaserWindow;
using perception::OdometryObservation;
using robot::RunTime;

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

// High on the left, it has climbed the left wall: steering right brings it down.
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

}  // namespace
}  // namespace kantaro::navigation
