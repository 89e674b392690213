// The thesis' two routes on twenty seeds each, seeing and blind. Takes an hour or more on two
// cores.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <thread>

#include "scenarios/suite.hpp"

namespace kantaro::scenarios {
namespace {

constexpr std::uint64_t kSeeds = 20;

std::vector<CaseResult> RunRoutes(const std::vector<std::string>& extra) {
  const std::filesystem::path scenarios = std::filesystem::path(KANTARO_SOURCE_DIR) / "scenarios";
  SuiteOptions options;
  options.paths = {scenarios / "route_1.yaml", scenarios / "route_2.yaml"};
  options.seeds = kSeeds;
  options.jobs = std::max(1u, std::thread::hardware_concurrency());
  options.out =
      std::filesystem::path(KANTARO_BINARY_DIR) / "soak" / (extra.empty() ? "seeing" : "blind");
  options.program = KANTARO_PROGRAM;
  options.extra = extra;
  return RunCases(ListCases(options), options, [](const CaseResult&, std::size_t, std::size_t) {});
}

TEST(Soak, BothRoutesPassOnEverySeed) {
  for (const CaseResult& result : RunRoutes({})) {
    EXPECT_EQ(result.outcome, CaseResult::Outcome::kPassed)
        << result.mission.scenario << " seed " << result.mission.seed << ": " << result.message;
  }
}

/// Whether the mission failed by its driving: without cameras no fault is found, and that proves
/// nothing.
bool FailedDriving(const CaseResult& result) {
  return std::any_of(result.failed_checks.begin(), result.failed_checks.end(),
                     [](const std::string& check) { return check != "faults_found"; });
}

// With laser, IR and cameras dead only wheels and map are left: driving by them is driving by time,
// and must not do.
TEST(Soak, TimedDrivingDoesNotPass) {
  std::map<std::string, std::uint64_t> failed;
  for (const CaseResult& result : RunRoutes({"--blind", "laser,infrared,cameras"})) {
    ASSERT_NE(result.outcome, CaseResult::Outcome::kCrashed) << result.message;
    failed[result.mission.scenario] += FailedDriving(result) ? 1 : 0;
  }
  for (const auto& [scenario, count] : failed) EXPECT_GE(count, 18u) << scenario;
}

}  // namespace
}  // namespace kantaro::scenarios
