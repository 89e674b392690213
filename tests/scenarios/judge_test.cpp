#include "scenarios/judge.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "tests/scenarios/synthetic_mission.hpp"

namespace kantaro::scenarios {
namespace {

const Check& Find(const Verdict& verdict, const std::string& name) {
  const auto check = std::find_if(verdict.checks.begin(), verdict.checks.end(),
                                  [&](const Check& c) { return c.name == name; });
  if (check == verdict.checks.end()) throw std::out_of_range(name);
  return *check;
}

std::vector<std::string> FailedChecks(const Verdict& verdict) {
  std::vector<std::string> names;
  for (const Check& check : verdict.checks) {
    if (!check.passed) names.push_back(check.name);
  }
  return names;
}

/// Index of the sample nearest to a time.
std::size_t At(const MissionTrace& trace, double time_s) {
  return std::min(trace.truth.size() - 1, static_cast<std::size_t>(time_s / kTracePeriod_s + 0.5));
}

TEST(Judge, PassesARunThatDoesItAllRight) {
  const Verdict verdict = Judge(TeeScenario(), PerfectMission());
  EXPECT_TRUE(verdict.passed);
  EXPECT_THAT(FailedChecks(verdict), testing::IsEmpty());
  EXPECT_EQ(verdict.checks.size(), 9u);
  // 2.7 + 3.4 + 4.0 m were driven.
  EXPECT_NEAR(verdict.metrics.at("distance_m"), 10.1, 0.02);
  EXPECT_EQ(verdict.metrics.at("fault_hits"), 1.0);
  EXPECT_EQ(verdict.metrics.at("fault_false_alarms"), 0.0);
}

TEST(Judge, FailsARunThatStopsShortOfItsGoal) {
  MissionTrace trace = PerfectMission();
  // Goal B's shaft wall lies at y = 3.6; at y = 3.2 the robot is 0.4 m short of it, 0.3 m are
  // allowed.
  while (trace.truth.back().X_WB.translation().y() > 3.2) {
    trace.truth.pop_back();
    trace.estimate.pop_back();
  }
  const Verdict verdict = Judge(TeeScenario(), trace);
  EXPECT_THAT(FailedChecks(verdict), testing::ElementsAre("goal_reached"));
  EXPECT_NEAR(Find(verdict, "goal_reached").value, 0.4, 0.007);
}

TEST(Judge, FailsARunThatTheRobotDidNotEndItself) {
  MissionTrace trace = PerfectMission();
  trace.finished = false;
  EXPECT_THAT(FailedChecks(Judge(TeeScenario(), trace)), testing::ElementsAre("finished_in_time"));
}

TEST(Judge, ForbidsATurnWhereThereIsNoJunction) {
  MissionTrace trace = PerfectMission();
  // After 10 s the robot is at x = 2.1 m, 4.5 m before the tee's shaft wall at x = 6.6 m.
  trace.estimate[At(trace, 10.0)].turning = true;
  const Verdict verdict = Judge(TeeScenario(), trace);
  EXPECT_THAT(FailedChecks(verdict), testing::ElementsAre("no_turn_without_junction"));
  EXPECT_NEAR(Find(verdict, "no_turn_without_junction").value, 4.5, 0.02);
  EXPECT_EQ(Find(verdict, "no_turn_without_junction").place.substr(0, 9), "pipe S-M1");
}

TEST(Judge, CountsAStraightManholeAsNoJunction) {
  MissionTrace trace = PerfectMission();
  const std::size_t in_m1 = At(trace, 3.1 / 0.12);  // x = 4.0 m, the middle of M1
  ASSERT_EQ(trace.truth[in_m1].place.manhole, "M1");
  trace.estimate[in_m1].turning = true;
  EXPECT_THAT(FailedChecks(Judge(TeeScenario(), trace)),
              testing::ElementsAre("no_turn_without_junction"));
}

TEST(Judge, ForbidsAHeadingAcrossThePipe) {
  MissionTrace trace = PerfectMission();
  TruthSample& sample = trace.truth[At(trace, 10.0)];
  sample.X_WB.linear() =
      Eigen::AngleAxisd(30.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  const Verdict verdict = Judge(TeeScenario(), trace);
  EXPECT_THAT(FailedChecks(verdict), testing::ElementsAre("heading_along_pipe"));
  EXPECT_NEAR(Find(verdict, "heading_along_pipe").value, 30.0, 1e-9);
}

// 0.20 m/s for 0.25 s and 0.10 m/s for the rest makes a mean of 0.15 over 0.5 s: allowed. For 0.4 s
// it is 0.18.
TEST(Judge, HoldsTheSpeedLimitForTheMeanOverHalfASecond) {
  const auto run_at = [](std::size_t fast_samples) {
    MissionTrace trace = PerfectMission();
    for (TruthSample& sample : trace.truth) sample.speed_m_s = 0.10;
    for (std::size_t i = 0; i < fast_samples; ++i) trace.truth[200 + i].speed_m_s = 0.20;
    return Find(Judge(TeeScenario(), trace), "speed_limit");
  };
  EXPECT_NEAR(run_at(5).value, 0.15, 1e-9);
  EXPECT_NEAR(run_at(8).value, 0.18, 1e-9);
  EXPECT_FALSE(run_at(8).passed);
  EXPECT_NEAR(*run_at(8).at_s, 10.4, 0.051);
}

TEST(Judge, MeasuresSpeedBackwardsAsWell) {
  MissionTrace trace = PerfectMission();
  for (std::size_t i = 200; i < 220; ++i) trace.truth[i].speed_m_s = -0.2;
  EXPECT_NEAR(Find(Judge(TeeScenario(), trace), "speed_limit").value, 0.2, 1e-9);
}

TEST(Judge, ExceptsADropFromTheSpeedLimit) {
  MissionTrace trace = PerfectMission();
  for (std::size_t i = 200; i < trace.truth.size(); ++i) {
    // It falls 50 mm within 0.25 s, and is fast meanwhile.
    const double fallen_m = 0.01 * static_cast<double>(std::min<std::size_t>(i - 199, 5));
    trace.truth[i].X_WB.translation().z() -= fallen_m;
    if (i < 205) trace.truth[i].speed_m_s = 0.4;
  }
  EXPECT_TRUE(Find(Judge(TeeScenario(), trace), "speed_limit").passed);
}

TEST(Judge, ReportsHowLongTheUpperBoxTouched) {
  MissionTrace trace = PerfectMission();
  for (std::size_t i = 100; i < 104; ++i) trace.truth[i].upper_box_contact = true;
  const Check check = Find(Judge(TeeScenario(), trace), "no_upper_box_collision");
  EXPECT_FALSE(check.passed);
  EXPECT_NEAR(check.value, 0.2, 1e-9);
  EXPECT_NEAR(*check.at_s, 5.0, 1e-9);
}

TEST(PositionError, IsTheDifferenceOfChainageInTheSamePipe) {
  TruthSample truth;
  truth.place = {"S-M1", "", 1.0};
  EXPECT_NEAR(PositionError(TeeNetwork(), truth, {0.0, "S-M1", 1.3, 0.0, "", false}), 0.3, 1e-12);
}

TEST(PositionError, IsTheDistanceInPlanFromAnotherPipe) {
  TruthSample truth;
  truth.X_WB.translation() = Eigen::Vector3d(4.0, 0.0, 0.1);
  truth.place = {"", "M1", 0.0};
  // Chainage 0 of M1-M2 is its upstream shaft wall, 0.4 m past the centre of M1.
  EXPECT_NEAR(PositionError(TeeNetwork(), truth, {0.0, "M1-M2", 0.0, 0.0, "", false}), 0.4, 1e-9);
}

TEST(Judge, FailsARobotThatIsLostAtTheEnd) {
  MissionTrace trace = PerfectMission();
  trace.estimate.back().pipe.clear();
  EXPECT_THAT(FailedChecks(Judge(TeeScenario(), trace)),
              testing::ElementsAre("position_error", "final_position_error"));
}

TEST(Judge, CountsHitsMissesAndFalseAlarms) {
  MissionTrace trace = PerfectMission();
  trace.faults.clear();
  AddSighting(trace.faults, {10.0, "S-M1", 1.80, 3.0, 0.8});   // 0.30 m off: too far
  AddSighting(trace.faults, {11.0, "S-M1", 1.50, 5.0, 0.8});   // 2 h off
  AddSighting(trace.faults, {12.0, "M1-M2", 1.50, 3.0, 0.8});  // another pipe
  const Verdict missed = Judge(TeeScenario(), trace);
  EXPECT_THAT(FailedChecks(missed), testing::ElementsAre("faults_found"));
  EXPECT_EQ(missed.metrics.at("fault_misses"), 1.0);
  EXPECT_EQ(missed.metrics.at("fault_false_alarms"), 3.0);

  AddSighting(trace.faults, {13.0, "S-M1", 1.26, 1.6, 0.8});  // 0.24 m and 1.4 h off
  const Verdict found = Judge(TeeScenario(), trace);
  EXPECT_TRUE(found.passed);
  EXPECT_EQ(found.metrics.at("fault_hits"), 1.0);
  EXPECT_EQ(found.metrics.at("fault_false_alarms"), 3.0);
}

TEST(Judge, AsksForNoFaultsWhereNoneWerePassed) {
  Scenario scenario = TeeScenario();
  scenario.network.pipes[0].faults.clear();
  const Verdict verdict = Judge(scenario, PerfectMission());
  EXPECT_THROW(static_cast<void>(Find(verdict, "faults_found")), std::out_of_range);
  EXPECT_EQ(verdict.metrics.at("fault_false_alarms"), 1.0);
}

TEST(Judge, RefusesATraceWithoutSamples) {
  EXPECT_THROW(static_cast<void>(Judge(TeeScenario(), MissionTrace())), std::invalid_argument);
}

// A recording or a device: nobody knows where the robot really is.
TEST(Judge, WithoutGroundTruthJudgesTheRobotsWordAndItsCommandsAndSaysSo) {
  MissionTrace trace = PerfectMission();
  trace.truth.clear();
  for (EstimateSample& sample : trace.estimate) sample.commanded_m_s = 0.12;
  trace.estimate[40].commanded_m_s = -0.16;  // 0.15 m/s are allowed, either way
  trace.estimate[40].time_s = 2.0;
  const Verdict verdict = Judge(TeeScenario(), trace);
  EXPECT_FALSE(verdict.passed);
  EXPECT_THAT(FailedChecks(verdict), testing::ElementsAre("speed_limit"));
  EXPECT_EQ(Find(verdict, "speed_limit").value, 0.16);
  EXPECT_EQ(Find(verdict, "speed_limit").at_s, 2.0);
  EXPECT_TRUE(Find(verdict, "finished_in_time").judged);
  EXPECT_FALSE(Find(verdict, "position_error").judged);
  EXPECT_EQ(Find(verdict, "goal_reached").text, "Not judged: no ground truth.");
  EXPECT_EQ(verdict.metrics.count("distance_m"), 0u);
  EXPECT_THAT(verdict.true_alarm, testing::IsEmpty());

  trace.estimate[40].commanded_m_s = -0.14;
  EXPECT_TRUE(Judge(TeeScenario(), trace).passed);
  trace.finished = false;
  EXPECT_THAT(FailedChecks(Judge(TeeScenario(), trace)), testing::ElementsAre("finished_in_time"));
}

}  // namespace
}  // namespace kantaro::scenarios
