#include "scenarios/experiments/locomotion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

#include "base/input_error.hpp"

namespace kantaro::scenarios {
namespace {

const std::filesystem::path kRobot = KANTARO_SOURCE_DIR "/models/kantaro";

const LocomotionCase& CaseNamed(const std::string& name) {
  for (const LocomotionCase& drive : LocomotionCases()) {
    if (drive.name == name) return drive;
  }
  throw std::out_of_range(name);
}

LocomotionOutcome DriveOnce(const std::string& name, double diameter_m, double friction,
                            const Profile& profile, const LocomotionStart& start = {}) {
  const robot::Description description = robot::ReadDescription(kRobot);
  return DriveCourse(description, CaseNamed(name).course(diameter_m), profile, friction, start);
}

/// Where a drive of 2 s at 0.1 m/s through a straight pipe ended, from 0.5 m.
double StuckAt(const LocomotionStart& start) {
  const std::string reason = DriveOnce("straight", 0.300, 0.7, {{2.0, 0.1, 0.1}}, start).reason;
  constexpr std::string_view kWords = "stuck at ";
  EXPECT_TRUE(reason.starts_with(kWords)) << reason;
  return std::stod(reason.substr(kWords.size()));
}

TEST(LocomotionStart, StaysWithinItsBoundsAndFillsThem) {
  constexpr double kYaw_rad = 3.0 * std::numbers::pi / 180.0;
  double widest_yaw = 0.0;
  for (std::size_t run = 0; run < 200; ++run) {
    const LocomotionStart start = DrawStart(1, "straight 300 dry", run);
    EXPECT_LE(std::abs(start.chainage_m), 0.005);
    EXPECT_LE(std::abs(start.lateral_m), 0.005);
    EXPECT_LE(std::abs(start.yaw_rad), kYaw_rad);
    EXPECT_LE(std::abs(start.friction_factor - 1.0), 0.1);
    EXPECT_LE(std::abs(start.mismatch), 0.015);
    widest_yaw = std::max(widest_yaw, std::abs(start.yaw_rad));
  }
  EXPECT_GT(widest_yaw, 0.95 * kYaw_rad);
}

TEST(LocomotionStart, IsAnotherForEachRunRowAndSeed) {
  const double yaw = DrawStart(1, "a", 0).yaw_rad;
  EXPECT_EQ(DrawStart(1, "a", 0).yaw_rad, yaw);
  EXPECT_NE(DrawStart(1, "a", 1).yaw_rad, yaw);
  EXPECT_NE(DrawStart(1, "b", 0).yaw_rad, yaw);
  EXPECT_NE(DrawStart(2, "a", 0).yaw_rad, yaw);
}

// 0.5 s at 0.1 m/s is 5 cm from the start at 0.5 m.
TEST(DriveCourse, SaysWhereTheRobotWasWhenItsProfileEnded) {
  const LocomotionOutcome outcome = DriveOnce("straight", 0.300, 0.7, {{0.5, 0.1, 0.1}});
  EXPECT_FALSE(outcome.passed);
  EXPECT_EQ(outcome.reason, "stuck at 0.55 m of \"pipe\"");
}

TEST(DriveCourse, CallsAnotherBranchAstray) {
  // Straight on where the way turns left.
  const LocomotionOutcome outcome = DriveOnce("tee_left", 0.300, 0.7, {{30.0, 0.1, 0.1}});
  EXPECT_FALSE(outcome.passed);
  EXPECT_EQ(outcome.reason, "went astray into \"ahead\"");
}

// Each part of a start shows in the way.
TEST(DriveCourse, StartsAsDrawn) {
  EXPECT_NEAR(StuckAt({}), 0.70, 0.011);
  EXPECT_NEAR(StuckAt({.chainage_m = 0.1}), 0.80, 0.011);
  EXPECT_NEAR(StuckAt({.yaw_rad = std::numbers::pi}), 0.30, 0.011);
  // One side is faster by what the other is slower, so the mean stays: with one side alone the
  // two would lie 4 cm apart.
  EXPECT_NEAR(StuckAt({.mismatch = 0.2}), StuckAt({.mismatch = -0.2}), 0.021);
  const LocomotionStart up_the_wall{.lateral_m = 2.0 * 0.150};  // by 2 rad
  EXPECT_TRUE(DriveOnce("straight", 0.300, 0.7, {{1.0, 0.1, 0.1}}, up_the_wall)
                  .reason.starts_with("rolled over"));
  // A slope of 10 % takes 0.0905 (physics_trust_test).
  const Profile& climb = CaseNamed("slope_up_10").profile;
  EXPECT_FALSE(DriveOnce("slope_up_10", 0.300, 0.09, climb, {.friction_factor = 0.8}).passed);
  EXPECT_TRUE(DriveOnce("slope_up_10", 0.300, 0.09, climb, {.friction_factor = 1.6}).passed);
}

TEST(DriveCourse, DoesNotPassARobotThatComesBackwards) {
  const LocomotionOutcome outcome =
      DriveOnce("straight", 0.300, 0.7, {{14.0, -0.15, -0.15}}, {.yaw_rad = std::numbers::pi});
  EXPECT_FALSE(outcome.passed);
  EXPECT_TRUE(outcome.reason.starts_with("turned round")) << outcome.reason;
}

// A ring of 20 mm leaves a bore of 160 mm: the upper box meets it before the wheels are over.
TEST(DriveCourse, TellsThatTheUpperBoxIsAgainstTheWall) {
  const LocomotionOutcome jammed = DriveOnce("ring_20", 0.200, 0.7, CaseNamed("ring_20").profile);
  EXPECT_FALSE(jammed.passed);
  EXPECT_TRUE(jammed.touched);
  EXPECT_TRUE(jammed.reason.ends_with("of \"pipe\", the upper box against the wall"))
      << jammed.reason;
  EXPECT_FALSE(DriveOnce("straight", 0.300, 0.7, {{1.0, 0.1, 0.1}}).touched);
}

// Down a step of 400 mm, more than its length, head first; and set down on its side.
TEST(DriveCourse, TellsTippingFromRolling) {
  const robot::Description description = robot::ReadDescription(kRobot);
  const LocomotionCase& drop = CaseNamed("drop_100");
  Course course = drop.course(0.300);
  course.network.manholes[0].p_WM.z() = 0.4;
  course.network.pipes[0].downstream_offset_m = 0.4;
  const LocomotionOutcome tipped = DriveCourse(description, course, drop.profile, 0.7, {});
  EXPECT_TRUE(tipped.reason.starts_with("tipped over its front")) << tipped.reason;
  course = CaseNamed("straight").course(0.300);
  course.start.roll_rad = 2.0;
  const LocomotionOutcome rolled = DriveCourse(description, course, drop.profile, 0.7, {});
  EXPECT_TRUE(rolled.reason.starts_with("rolled over")) << rolled.reason;
}

TEST(DriveCourse, ReachesTheGoalOfAStraightPipe) {
  const LocomotionCase& drive = CaseNamed("straight");
  const LocomotionOutcome outcome = DriveOnce("straight", 0.250, 0.3, drive.profile);
  EXPECT_TRUE(outcome.passed) << outcome.reason;
  EXPECT_EQ(outcome.reason, "");
}

// A taste of the whole experiment: where the robot of an earlier design fell over or stuck, wet.
TEST(DriveCourse, PassesTheHardestOfEachKind) {
  for (const auto& [name, diameter_m] :
       {std::pair{"bend_90", 0.200}, std::pair{"tee_left", 0.300}, std::pair{"drop_100", 0.300},
        std::pair{"ring_10", 0.250}, std::pair{"lump_20", 0.250}}) {
    const LocomotionOutcome outcome = DriveOnce(name, diameter_m, 0.3, CaseNamed(name).profile);
    EXPECT_TRUE(outcome.passed) << name << ": " << outcome.reason;
  }
}

TEST(LocomotionExperiment, GivesTheSameRowsOnOneThreadAndOnTwo) {
  ExperimentOptions options{kRobot, 1, 1, {"straight"}, 1, {}, {}, {}};
  const nlohmann::ordered_json alone = LocomotionExperiment().run(options);
  options.jobs = 2;
  EXPECT_EQ(LocomotionExperiment().run(options), alone);
  ASSERT_EQ(alone.at("rows").size(), 8u);  // four diameters, dry and wet
  const nlohmann::ordered_json& row = alone.at("rows").at(1);
  EXPECT_EQ(row.at("case"), "straight");
  EXPECT_EQ(row.at("diameter_mm"), 200);
  EXPECT_EQ(row.at("condition"), "wet");
  EXPECT_EQ(row.at("passed"), 1);
  EXPECT_EQ(row.at("runs"), 1);
  EXPECT_EQ(row.at("reason"), "");
  EXPECT_EQ(alone.at("passed"), true);
}

TEST(LocomotionExperiment, RefusesACaseItDoesNotKnow) {
  const ExperimentOptions options{kRobot, 1, 1, {"loop"}, 1, {}, {}, {}};
  EXPECT_THROW((void)LocomotionExperiment().run(options), InputError);
}

}  // namespace
}  // namespace kantaro::scenarios
