// The program as its users start it: missions in processes of their own.

#include <gmock/gmock.h>

#include <unistd.h>

#include <filesystem>

#include "base/files.hpp"
#include "scenarios/suite.hpp"

namespace kantaro::scenarios {
namespace {

class Mission : public testing::Test {
 protected:
  Mission()
      : out_(std::filesystem::path(testing::TempDir()) / ("mission-" + std::to_string(getpid()))) {}
  ~Mission() override { std::filesystem::remove_all(out_); }

  [[nodiscard]] std::vector<CaseResult> RunShort() const {
    SuiteOptions options;
    options.paths = {std::filesystem::path(KANTARO_SOURCE_DIR) / "tests/apps/short_mission.yaml"};
    options.out = out_;
    options.program = KANTARO_PROGRAM;
    return RunCases(ListCases(options), options,
                    [](const CaseResult&, std::size_t, std::size_t) {});
  }

  std::filesystem::path out_;
};

TEST_F(Mission, DrivesAShortPipeToItsEndAndReportsIt) {
  const std::vector<CaseResult> results = RunShort();
  EXPECT_EQ(results[0].outcome, CaseResult::Outcome::kPassed) << results[0].message;
  // From 0.6 m into the pipe to its shaft's wall at 2.4 m at least.
  EXPECT_GT(results[0].metrics.at("distance_m"), 1.7);
  EXPECT_THAT(ReadInputFile(results[0].mission.run_folder / "report.html"),
              testing::HasSubstr("<strong>Passed</strong>"));
}

}  // namespace
}  // namespace kantaro::scenarios
