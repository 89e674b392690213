#include "scenarios/suite.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "scenarios/child_process.hpp"

namespace kantaro::scenarios {
namespace {

using Outcome = CaseResult::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;

CaseResult Case(const std::string& scenario, std::uint64_t seed, Outcome outcome, double error_m) {
  CaseResult result;
  result.mission = {scenario, scenario + ".yaml", seed, "out/" + scenario};
  result.outcome = outcome;
  result.message =
      outcome == Outcome::kPassed ? "" : "It stopped <short> of \"B\" in pipe P2 at 3.10 m.";
  result.metrics = {{"position_error_max_m", error_m}};
  result.sim_s = 100.0;
  result.wall_s = 40.0;
  return result;
}

std::string Baseline(const std::vector<CaseResult>& results) {
  return SuiteJson(results, nullptr, "out").dump();
}

/// A stand-in for the program: a shell script that gets the arguments of a mission.
class StandIn : public testing::Test {
 protected:
  StandIn()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~StandIn() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::vector<CaseResult> RunSeeds(const std::string& script,
                                                 std::uint64_t seeds) const {
    SuiteOptions options;
    options.program = folder_ / "stand_in.sh";
    options.jobs = 2;
    WriteFileAtomically(options.program, "#!/bin/sh\n" + script);
    std::filesystem::permissions(options.program, std::filesystem::perms::owner_all);
    std::vector<SuiteCase> cases;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
      cases.push_back({"tee", "tee.yaml", seed, "out"});
    return RunCases(cases, options, [](const CaseResult&, std::size_t, std::size_t) {});
  }

  std::filesystem::path folder_;
};

constexpr char kPassedJson[] =
    R"({"scenario":"tee","seed":1,"verdict":{"passed":true,"checks":[]},"metrics":{"distance_m":3.5,"lost_m":null},)"
    R"("timing":{"sim_s":10,"wall_s":4,"real_time_factor":2.5},"trace_sha256":"abc"})";

TEST_F(StandIn, IsReadFromItsJson) {
  const auto results = RunSeeds(std::string("echo '") + kPassedJson + "'\n", 1);
  EXPECT_EQ(results[0].outcome, Outcome::kPassed);
  EXPECT_EQ(results[0].metrics.at("distance_m"), 3.5);
  EXPECT_EQ(results[0].trace_sha256, "abc");
}

// Seed 2 dies by a signal, seed 3 talks nonsense, seed 4 ends with an internal fault: the rest goes
// on.
TEST_F(StandIn, ThatCrashesIsOneFailedCase) {
  const auto results =
      RunSeeds(std::string("case $4 in\n 2) kill -SEGV $$;;\n 3) echo nonsense;;\n 4) echo "
                           "'kantaro: no OSMesa' >&2; exit 3;;\n *) echo '") +
                   kPassedJson + "';;\nesac\n",
               5);
  EXPECT_EQ(results[0].outcome, Outcome::kPassed);
  EXPECT_EQ(results[1].outcome, Outcome::kCrashed);
  EXPECT_THAT(results[1].message, HasSubstr("signal 11"));
  EXPECT_EQ(results[2].outcome, Outcome::kCrashed);
  EXPECT_EQ(results[3].message, "ended with exit code 3: kantaro: no OSMesa");
  EXPECT_EQ(results[4].outcome, Outcome::kPassed);
  EXPECT_FALSE(AllPassed(results));
}

TEST(RunChildren, SurvivesMoreOutputThanAPipeHolds) {
  std::size_t size = 0;
  RunChildren({{{"/bin/sh", "-c", "head -c 300000 /dev/zero; head -c 300000 /dev/zero >&2"}}}, 1,
              [&](std::size_t, const ChildResult& result) {
                size = result.out.size() + result.err.size();
              });
  EXPECT_EQ(size, 600000u);
}

// As a scheduler stops a suite: its missions are not to go on without it.
TEST(RunChildren, EndsThemWhenItIsEnded) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / ("ended-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const pid_t parent = fork();
  if (parent == 0) {
    const std::string told = "echo $$ > " + (folder / "$0.part").string() + "; mv " +
                             (folder / "$0.part").string() + " " + (folder / "$0").string() +
                             "; exec sleep 600";
    RunChildren({{{"/bin/sh", "-c", told, "one"}}, {{"/bin/sh", "-c", told, "two"}}}, 2,
                [](std::size_t, const ChildResult&) {});
    _exit(0);
  }
  const auto child = [&](const char* name) -> pid_t {
    while (!std::filesystem::exists(folder / name)) usleep(10000);
    return std::stoi(ReadInputFile(folder / name));
  };
  const pid_t one = child("one"), two = child("two");
  kill(parent, SIGTERM);
  int status = 0;
  waitpid(parent, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
  EXPECT_EQ(kill(one, 0), -1) << "it is still there";
  EXPECT_EQ(kill(two, 0), -1) << "it is still there";
  std::filesystem::remove_all(folder);
}

TEST(SuiteHtml, ShowsFirstWhatFailedAndLinksToEachReport) {
  std::vector<CaseResult> results{Case("a", 1, Outcome::kPassed, 0.1),
                                  Case("b", 2, Outcome::kFailed, 0.7),
                                  Case("c", 3, Outcome::kCrashed, 0.0)};
  results[0].mission.run_folder = "out/a/seed-1";
  results[1].mission.run_folder = "out/b/seed-2";
  const std::string page = SuiteHtml(results, nullptr, "out");
  EXPECT_THAT(page, HasSubstr("<title>1 of 3 missions passed</title>"));
  EXPECT_THAT(page, HasSubstr(R"(<a href="a/seed-1/report.html">a · seed 1</a>)"));
  EXPECT_LT(page.find("b/seed-2/report.html"), page.find("a/seed-1/report.html"));
  EXPECT_THAT(page, HasSubstr("stopped &lt;short&gt; of &quot;B&quot;"));
  EXPECT_THAT(page, testing::Not(HasSubstr("c/report.html"))) << "it has none";
  EXPECT_THAT(page, HasSubstr("70 cm"));
}

TEST(Comparison, NamesWhatGotWorseAndWhere) {
  const std::string before =
      Baseline({Case("a", 1, Outcome::kPassed, 0.1), Case("a", 2, Outcome::kPassed, 0.1),
                Case("a", 3, Outcome::kFailed, 0.1), Case("a", 4, Outcome::kPassed, 0.10),
                Case("gone", 1, Outcome::kPassed, 0.1)});
  const Comparison comparison = CompareWithBaseline(
      {Case("a", 1, Outcome::kFailed, 0.1), Case("a", 2, Outcome::kPassed, 0.3),
       Case("a", 3, Outcome::kPassed, 0.1), Case("a", 4, Outcome::kPassed, 0.11),
       Case("new", 1, Outcome::kPassed, 0.1)},
      before, "suite.json");
  ASSERT_EQ(comparison.worse.size(), 2u);
  EXPECT_EQ(comparison.worse[0].seed, 1u);
  EXPECT_THAT(comparison.worse[0].text, HasSubstr("in pipe P2 at 3.10 m"));
  EXPECT_EQ(comparison.worse[1].text, "largest position error (m) 0.1 -> 0.3");
  ASSERT_EQ(comparison.better.size(), 1u);
  EXPECT_EQ(comparison.better[0].seed, 3u);
  EXPECT_EQ(comparison.unchanged, 1u);
  EXPECT_EQ(comparison.added, 1u);
  EXPECT_EQ(comparison.removed, 1u);
}

TEST(Comparison, RefusesAFileThatIsNoSuite) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      static_cast<void>(CompareWithBaseline({}, text, "old.json"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal("{\n\"cases\": [}"), testing::StartsWith("old.json:2: not valid JSON"));
  EXPECT_THAT(refusal("[]"), testing::StartsWith("old.json: cases: not a suite.json"));
  EXPECT_THAT(refusal(R"({"cases": [{"scenario": "a", "seed": "x"}]})"),
              testing::StartsWith("old.json: cases:"));
  EXPECT_THAT(
      refusal(R"({"cases": [{"scenario": "a", "seed": 1, "outcome": "passed", "metrics": 3}]})"),
      testing::StartsWith("old.json: cases:"));
}

TEST(Junit, CountsAndEscapes) {
  const std::string xml =
      JunitXml({Case("a", 1, Outcome::kPassed, 0.1), Case("a", 2, Outcome::kFailed, 0.1),
                Case("b", 1, Outcome::kCrashed, 0.1)});
  EXPECT_THAT(xml,
              HasSubstr(R"(<testsuite name="a" tests="2" failures="1" errors="0" time="80.000">)"));
  EXPECT_THAT(xml, HasSubstr(R"(<testsuite name="b" tests="1" failures="0" errors="1")"));
  EXPECT_THAT(xml, HasSubstr(R"(message="It stopped &lt;short&gt; of &quot;B&quot;)"));
}

TEST(SuiteJson, SumsUpByScenario) {
  const nlohmann::ordered_json json = SuiteJson(
      {Case("a", 1, Outcome::kPassed, 0.1), Case("a", 2, Outcome::kFailed, 0.1)}, nullptr, "out");
  EXPECT_EQ(json["passed"], false);
  EXPECT_EQ(json["passed_missions"], 1);
  EXPECT_EQ(json["scenarios"][0]["passed"], 1);
  EXPECT_EQ(json["cases"][1]["outcome"], "failed");
  EXPECT_EQ(json["cases"][0]["run_folder"], "a");
  EXPECT_FALSE(json.contains("comparison"));
}

}  // namespace
}  // namespace kantaro::scenarios
