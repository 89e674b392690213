// What the executive does when what its sensors say cannot be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "navigation/executive.hpp"
#include "tests/navigation/puppet.hpp"
#include "tests/navigation/sewers.hpp"

namespace kantaro::navigation {
namespace {

using perception::AttitudeObservation;
using perception::BatteryObservation;
using perception::InclinationObservation;
using perception::IrObservation;
using perception::LaserObservation;
using perception::LossObservation;
using perception::OdometryObservation;
using robot::RunTime;
using robot::Sensor;
using testing::HasSubstr;
using testing::Not;

RunTime At(double time_s) { return RunTime(std::llround(time_s * 1e9)); }

using Meddle = std::function<void(perception::Observation&, const Puppet&)>;

Puppet Drive(const PuppetSetup& setup, const Meddle& meddle = {},
             const std::vector<std::string>& manholes = {"A", "C"}) {
  Executive executive(MakeRoute(TeeField(), manholes, {}), setup.start_distance_m, Kantaro(),
                      ShippedParameters());
  Puppet puppet(TeeField(), manholes, setup);
  puppet.meddle = meddle;
  puppet.Drive(executive);
  return puppet;
}

void ExpectStop(const Puppet& puppet, const std::string& why) {
  EXPECT_FALSE(puppet.crashed()) << puppet.story();
  EXPECT_TRUE(puppet.Was(Phase::kFailed)) << puppet.story();
  EXPECT_THAT(puppet.story(), HasSubstr(why));
}

/// An observation without news of the sensor that is meant.
perception::Observation Missing(Sensor sensor) {
  return LossObservation{{}, sensor, LossObservation::Cause::kMissing};
}

/// Cruise for 2 s, then the encoders stay where they are: 1.5 s later it stands.
TEST(FailingSensors, StopsWhenTheEncodersHang) {
  std::optional<OdometryObservation> frozen;
  const Puppet puppet = Drive({}, [&](perception::Observation& seen, const Puppet& truth) {
    auto* odometry = std::get_if<OdometryObservation>(&seen);
    if (odometry == nullptr || truth.distance_m() < 1.0) return;
    if (!frozen) frozen = *odometry;
    const RunTime now = odometry->captured_at;
    *odometry = *frozen;
    odometry->captured_at = now;
  });
  ExpectStop(puppet, "by their encoders");
  EXPECT_NEAR(puppet.distance_m(), 1.0 + 1.5 * 0.13, 0.05);
}

TEST(FailingSensors, StopsWithoutEncoders) {
  const Puppet puppet = Drive({}, [](perception::Observation& seen, const Puppet& truth) {
    if (std::holds_alternative<OdometryObservation>(seen) && truth.distance_m() > 1.0)
      seen = Missing(Sensor::kEncoders);
  });
  ExpectStop(puppet, "no word from the encoders");
  EXPECT_NEAR(puppet.distance_m(), 1.0 + 0.3 * 0.13, 0.02);
}

TEST(FailingSensors, StopsWhenTheEncodersJump) {
  const Puppet puppet = Drive({}, [](perception::Observation& seen, const Puppet& truth) {
    auto* odometry = std::get_if<OdometryObservation>(&seen);
    if (odometry != nullptr && truth.distance_m() > 1.0) odometry->travel_m += 5.0;
  });
  ExpectStop(puppet, "jumped by 5.0");
}

TEST(FailingSensors, StopsInATurnWhenTheGyroFallsSilent) {
  const Puppet puppet = Drive({}, [](perception::Observation& seen, const Puppet& truth) {
    if (std::holds_alternative<AttitudeObservation>(seen) && !truth.turns().empty())
      seen = Missing(Sensor::kInertial);
  });
  ExpectStop(puppet, "no word from the gyro in a turn");
}

TEST(FailingSensors, DoesNotTurnWithoutAGyro) {
  PuppetSetup setup;
  setup.gyro = false;
  const Puppet puppet = Drive(setup);
  ExpectStop(puppet, "cannot turn in manhole");
  EXPECT_TRUE(puppet.turns().empty());
}

TEST(FailingSensors, GoesStraightOnWithoutAGyro) {
  PuppetSetup setup;
  setup.gyro = false;
  const Puppet puppet = Drive(setup, {}, {"A", "E"});
  EXPECT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
}

// 0.03 rad/s over the 8 s of a turn would be 14°: learned on the way there, it is none.
TEST(FailingSensors, LearnsTheGyrosBiasBeforeItTurns) {
  PuppetSetup honest, drifting;
  drifting.yaw_bias_rad_s = 0.03;
  const Puppet expected = Drive(honest);
  const Puppet puppet = Drive(drifting);
  ASSERT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
  EXPECT_NEAR(puppet.First(Phase::kLeaving).beyond_m, expected.First(Phase::kLeaving).beyond_m,
              0.01);
}

TEST(FailingSensors, DoesNotTurnByAGyroThatTellsNonsense) {
  PuppetSetup setup;
  setup.yaw_bias_rad_s = 0.2;
  ExpectStop(Drive(setup), "cannot turn in manhole");
}

TEST(FailingSensors, SaysWhenItsWheelsSpinBackingUp) {
  PuppetSetup setup;
  setup.reverse_scale = 0.0;
  const Puppet puppet = Drive(setup);
  ExpectStop(puppet, "the wheels spin");
  EXPECT_TRUE(puppet.turns().empty());
}

// With a third of the way lost the laser leaves the manhole later, and tells where the wall is.
TEST(FailingSensors, BacksUpAsFarAsItMustWhenItsWheelsSlip) {
  PuppetSetup setup;
  setup.reverse_scale = 0.67;
  const Puppet puppet = Drive(setup);
  ASSERT_EQ(puppet.turns().size(), 1u) << puppet.story();
  EXPECT_FALSE(puppet.crashed());
  EXPECT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
}

// An inlet at 12 o'clock just where the manhole may be, by a map that is a little long.
TEST(FailingSensors, TakesNoInletInTheCrownForTheManhole) {
  for (const bool infrared : {true, false}) {
    PuppetSetup setup;
    setup.infrared = infrared;
    setup.crown_inlet_m = 6.9;  // the pipe is 7.2 m long
    const Puppet puppet = Drive(setup);
    EXPECT_FALSE(puppet.crashed()) << puppet.story();
    EXPECT_THAT(puppet.story(), HasSubstr("no manhole: an opening of 0.1"));
    EXPECT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
  }
}

// The goal's wall is near when the crown opens: an inlet must not end the mission.
TEST(FailingSensors, ArrivesInNoInlet) {
  for (const bool infrared : {true, false}) {
    PuppetSetup setup;
    setup.infrared = infrared;
    setup.crown_inlet_m = 6.9;
    const Puppet puppet = Drive(setup, {}, {"A", "M"});
    ASSERT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
    EXPECT_GT(puppet.beyond_m(), 0.17);
  }
}

/// One sensor sees no crown from the first metre on.
Puppet DriveUnderOpenSky(Sensor sensor) {
  return Drive({}, [sensor](perception::Observation& seen, const Puppet& truth) {
    if (truth.leg() != 0 || truth.distance_m() < 1.0) return;
    auto* infrared = std::get_if<IrObservation>(&seen);
    if (infrared != nullptr && sensor == Sensor::kInfrared)
      infrared->manhole = infrared->junction_left = infrared->junction_right = true;
  });
}

TEST(FailingSensors, BelievesNoInfraredThatNeverSeesTheCrown) {
  const Puppet puppet = DriveUnderOpenSky(Sensor::kInfrared);
  EXPECT_FALSE(puppet.crashed()) << puppet.story();
  EXPECT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
}

TEST(FailingSensors, UsesNoWordThatComesTooLate) {
  PuppetSetup setup;
  const Puppet puppet = Drive(setup, [](perception::Observation& seen, const Puppet&) {
    if (auto* laser = std::get_if<LaserObservation>(&seen)) laser->captured_at -= At(3.0);
  });
  EXPECT_FALSE(puppet.crashed()) << puppet.story();
  EXPECT_THAT(puppet.story(), Not(HasSubstr("laser:")));
  EXPECT_TRUE(puppet.Was(Phase::kArrived)) << puppet.story();
}

/// Drives 1 s in a pipe, and returns what one more observation leads to.
robot::Command After(const perception::Observation& last, bool gyro = true) {
  Executive executive(MakeRoute(TeeField(), {"A", "C"}, {}), 1.0, Kantaro(), ShippedParameters());
  for (int i = 0; i <= 100; ++i) {
    const double way_m = 0.0013 * i;
    if (gyro) (void)executive.Step(AttitudeObservation{At(0.01 * i), 0.0, 0.0, 0.0});
    (void)executive.Step(OdometryObservation{At(0.01 * i), way_m, way_m, way_m});
  }
  return executive.Step(last);
}

TEST(FailingSensors, KeepsUprightByTheInclinometerWithoutAGyro) {
  // Left side high: to the left is uphill, so it steers right.
  const robot::Command leaning = After(InclinationObservation{At(1.0), 0.1, 0.0}, false);
  EXPECT_GT(leaning.left_rad_s, leaning.right_rad_s + 0.1);
  const robot::Command with_gyro = After(InclinationObservation{At(1.0), 0.1, 0.0}, true);
  EXPECT_EQ(with_gyro.left_rad_s, with_gyro.right_rad_s);
}

TEST(FailingSensors, StopsAtTheBatterysReserve) {
  EXPECT_GT(After(BatteryObservation{At(1.0), 0.04, 14.0}).left_rad_s, 0.0);
  EXPECT_EQ(After(BatteryObservation{At(1.0), 0.02, 14.0}).left_rad_s, 0.0);
}

TEST(FailingSensors, StopsAtOnceWhenTheEncodersLineIsDown) {
  using Cause = LossObservation::Cause;
  EXPECT_EQ(After(LossObservation{At(1.0), Sensor::kEncoders, Cause::kLineDown}).left_rad_s, 0.0);
  EXPECT_GT(After(LossObservation{At(1.0), Sensor::kEncoders, Cause::kMissing}).left_rad_s, 0.0);
  EXPECT_GT(After(LossObservation{At(1.0), Sensor::kCompass, Cause::kLineDown}).left_rad_s, 0.0);
}

}  // namespace
}  // namespace kantaro::navigation
