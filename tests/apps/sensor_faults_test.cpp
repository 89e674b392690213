// Missions with one sensor spoilt: the robot arrives, or it stops and says why; it drives into
// nothing.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "scenarios/runner.hpp"

namespace kantaro::scenarios {
namespace {

using robot::Fault;
using robot::FaultKind;
using robot::Sensor;

constexpr std::uint64_t kSeed = 2;

Scenario Mission(const std::string& name) {
  return ReadScenario(std::filesystem::path(KANTARO_SOURCE_DIR) / "tests/apps" / name);
}

/// What is too much for each sensor, and not absurd.
double BiasOf(Sensor sensor) {
  switch (sensor) {
    case Sensor::kLaser:
      return 0.030;  // m: the wall of the pipe looks as far as a manhole's
    case Sensor::kInfrared:
      return -0.2;  // of 1: as in a manhole
    case Sensor::kEncoders:
      return 0.2;  // of the travel
    case Sensor::kInertial:
      return 0.1;  // rad/s
    case Sensor::kInclinometer:
      return 0.2;  // rad
    case Sensor::kBattery:
      return -3.0;  // V
    case Sensor::kCompass:
      return 1.0;  // rad
    default:
      return 60.0;  // of 255
  }
}

Fault Spoilt(Sensor sensor, FaultKind kind, double from_s) {
  Fault fault;
  fault.sensor = sensor;
  fault.kind = kind;
  fault.from = robot::RunTime(static_cast<robot::RunTime::rep>(from_s * 1e9));
  fault.amount = kind == FaultKind::kBiased    ? BiasOf(sensor)
                 : kind == FaultKind::kDropped ? 0.5
                 : kind == FaultKind::kDelayed ? 0.5
                                               : 0.0;
  return fault;
}

/// Runs it and holds it to what every mission must keep. @returns its trace
MissionTrace RunSafely(const Scenario& scenario) {
  const MissionRun run = RunMission(scenario, kSeed, {});
  std::string story = run.trace.ending;
  for (const Event& event : run.trace.events)
    story += fmt::format("\n{:6.2f} s {}: {}", event.time_s, event.kind, event.text);
  // The recorder says so only of a robot that has stopped by itself.
  const bool stopped = run.trace.ending.starts_with("The robot gave up: ");
  EXPECT_TRUE(run.result.verdict.passed || stopped) << story;
  const EstimateSample& last = run.trace.estimate.back();
  if (last.phase == "failed") {
    EXPECT_EQ(last.commanded_m_s, 0.0) << story;
  }
  for (const TruthSample& truth : run.trace.truth)
    EXPECT_FALSE(truth.upper_box_contact) << truth.time_s << " s\n" << story;
  return run.trace;
}

using Case = std::tuple<Sensor, FaultKind>;
class SpoiltSensor : public testing::TestWithParam<Case> {};

// From the second metre of the first pipe on, so before the turn.
TEST_P(SpoiltSensor, ArrivesOrStopsAndSaysWhy) {
  const auto [sensor, kind] = GetParam();
  Scenario scenario = Mission("tee_mission.yaml");
  scenario.faults.push_back(Spoilt(sensor, kind, 4.0));
  (void)RunSafely(scenario);
}

std::string CaseName(const testing::TestParamInfo<Case>& info) {
  return std::string(robot::ToString(std::get<0>(info.param))) + "_" +
         robot::ToString(std::get<1>(info.param));
}

const auto kEveryKind =
    testing::Values(FaultKind::kFrozen, FaultKind::kDropped, FaultKind::kSaturated,
                    FaultKind::kBiased, FaultKind::kDelayed, FaultKind::kDead);
INSTANTIATE_TEST_SUITE_P(, SpoiltSensor,
                         testing::Combine(testing::Values(Sensor::kLaser, Sensor::kInfrared,
                                                          Sensor::kEncoders, Sensor::kInertial,
                                                          Sensor::kInclinometer, Sensor::kCompass,
                                                          Sensor::kBattery),
                                          kEveryKind),
                         CaseName);

class SpoiltCameras : public testing::TestWithParam<FaultKind> {};

// All of them, soon after the start.
TEST_P(SpoiltCameras, KeepTheRobotFromNothing) {
  Scenario scenario = Mission("short_mission.yaml");
  scenario.start.chainage_m = 1.2;
  for (const Sensor camera : {Sensor::kFrontCamera, Sensor::kStereoCameras})
    scenario.faults.push_back(Spoilt(camera, GetParam(), 2.0));
  EXPECT_TRUE(RunSafely(scenario).finished) << "the other sensors are enough";
}

INSTANTIATE_TEST_SUITE_P(, SpoiltCameras, kEveryKind,
                         [](const auto& fault) { return robot::ToString(fault.param); });

/// The mission of the tee with one fault from a time on.
MissionTrace WithFault(Sensor sensor, FaultKind kind, double from_s) {
  Scenario scenario = Mission("tee_mission.yaml");
  scenario.faults.push_back(Spoilt(sensor, kind, from_s));
  return RunSafely(scenario);
}

double BeginOfTurn() {
  const MissionTrace trace = RunSafely(Mission("tee_mission.yaml"));
  EXPECT_TRUE(trace.finished) << trace.ending;
  for (const Event& event : trace.events) {
    if (event.text.starts_with("turn into the channel")) return event.time_s;
  }
  throw std::logic_error("it never turned");
}

TEST(SpoiltInTheTurn, StopsWithoutAGyro) {
  const MissionTrace trace = WithFault(Sensor::kInertial, FaultKind::kDead, BeginOfTurn() + 1.0);
  EXPECT_FALSE(trace.finished);
  EXPECT_THAT(trace.ending, testing::HasSubstr("gyro"));
}

TEST(SpoiltInTheTurn, StopsWithFrozenEncoders) {
  const MissionTrace trace = WithFault(Sensor::kEncoders, FaultKind::kFrozen, BeginOfTurn() + 1.0);
  EXPECT_FALSE(trace.finished);
  EXPECT_THAT(trace.ending, testing::HasSubstr("encoders"));
}

TEST(SpoiltPower, StopsAndSaysSoWhenTheBatteryRunsLow) {
  Scenario scenario = Mission("tee_mission.yaml");
  scenario.battery_charge = 0.0305;  // 0.05 % above the reserve: 9 As of 18,720, some 4 s
  const MissionTrace trace = RunSafely(scenario);
  EXPECT_FALSE(trace.finished);
  EXPECT_THAT(trace.ending, testing::HasSubstr("battery is down to 3.0 %"));
  EXPECT_NEAR(trace.end_s, 3.5, 1.5);
}

// A battery that always looks full, and is empty after some 2 s.
TEST(SpoiltPower, SaysWhenThePowerFails) {
  Scenario scenario = Mission("tee_mission.yaml");
  scenario.battery_charge = 0.0005;
  scenario.faults.push_back(Spoilt(Sensor::kBattery, FaultKind::kSaturated, 0.0));
  const MissionTrace trace = RunSafely(scenario);
  EXPECT_THAT(trace.ending, testing::HasSubstr("the power has failed"));
}

}  // namespace
}  // namespace kantaro::scenarios
