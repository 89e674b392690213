#include "scenarios/report.hpp"

#include <gmock/gmock.h>

#include <regex>

#include "scenarios/drawings.hpp"
#include "scenarios/html.hpp"
#include "tests/scenarios/synthetic_mission.hpp"

namespace kantaro::scenarios {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string Report(const Scenario& scenario, const MissionTrace& trace) {
  const Result result{scenario.name, 4, Judge(scenario, trace), {84.0, 20.0}, trace.sha256};
  return ReportHtml(scenario, DrawConditions(scenario, 4), trace, result, {});
}

TEST(Escape, LeavesNoMarkup) {
  EXPECT_EQ(Escape("<b a=\"x\" b='y'>&"), "&lt;b a=&quot;x&quot; b=&#39;y&#39;&gt;&amp;");
  EXPECT_EQ(Escape("Käthe"), "Käthe");
  EXPECT_EQ(Escape(std::string("a\0b\xff", 4)),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD");
}

// The examples of RFC 4648, section 10.
TEST(Base64, MatchesTheStandardsExamples) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

TEST(RouteRuler, CountsThroughPipesAndShafts) {
  const Eigen::Vector3d kNowhere = Eigen::Vector3d::Zero();
  RouteRuler ruler(TeeScenario());
  EXPECT_NEAR(*ruler.Measure({"S-M1", "", 1.0}, kNowhere), 1.0, 1e-9);
  EXPECT_NEAR(*ruler.Measure({"", "M1", 0.0}, {4.1, 0.0, 0.1}), 3.2 + 0.5, 1e-9);
  EXPECT_NEAR(*ruler.Measure({"M1-M2", "", 1.0}, kNowhere), 3.2 + 0.8 + 1.0, 1e-9);
  // B-M2 is driven upstream: chainage 3.2 is its beginning.
  EXPECT_NEAR(*ruler.Measure({"B-M2", "", 3.0}, kNowhere), 3.2 + 0.8 + 2.2 + 0.8 + 0.2, 1e-9);
  EXPECT_FALSE(ruler.Measure({"M2-E", "", 1.0}, kNowhere).has_value());
}

TEST(Report, SaysTheVerdictFirst) {
  const std::string html = Report(TeeScenario(), PerfectMission());
  EXPECT_THAT(html, HasSubstr("<title>Tee: passed"));
  EXPECT_LT(html.find("<strong>Passed</strong>"), html.find("<section"));
  EXPECT_THAT(html, HasSubstr("All 9 checks passed with seed 4."));
}

TEST(Report, ListsWhatFailedBesideTheVerdict) {
  MissionTrace trace = PerfectMission();
  trace.truth[100].upper_box_contact = true;
  const std::string html = Report(TeeScenario(), trace);
  const auto verdict = html.find("<strong>Failed</strong>");
  ASSERT_NE(verdict, std::string::npos);
  EXPECT_LT(html.find("The upper box touched the wall", verdict), html.find("<section"));
}

TEST(Report, FetchesNothingAndRunsNothing) {
  MissionTrace trace = PerfectMission();
  trace.frames.push_back({12.0, "manhole M1", "\xff\xd8jpeg"});
  const std::string html = Report(TeeScenario(), trace);
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  const std::regex source("(src|href)=\"(?!data:)");
  EXPECT_FALSE(std::regex_search(html, source));
}

TEST(Report, EscapesEveryNameFromAFile) {
  const std::string evil = "<script>alert('x')</script>";
  Scenario scenario = TeeScenario();
  scenario.description = evil;
  for (network::Manhole& manhole : scenario.network.manholes) manhole.name += evil;
  for (network::Pipe& pipe : scenario.network.pipes) {
    pipe.name += evil;
    pipe.upstream += evil;
    pipe.downstream += evil;
    for (network::Fault& fault : pipe.faults) fault.name += evil;
    for (network::Inlet& inlet : pipe.inlets) inlet.name += evil;
  }
  scenario.network.skipped = {{evil, "S" + evil, "B" + evil, evil}};
  scenario.start.manhole += evil;
  scenario.start.pipe += evil;
  scenario.goal += evil;
  MissionTrace trace = PerfectMission();
  for (TruthSample& sample : trace.truth) {
    (sample.place.pipe.empty() ? sample.place.manhole : sample.place.pipe) += evil;
  }
  for (EstimateSample& sample : trace.estimate) {
    sample.pipe += evil;
    sample.phase += evil;
  }
  trace.events.push_back({1.0, evil, evil});
  trace.ending = evil;
  trace.frames.push_back({12.0, evil, "jpeg"});
  trace.laser_ring = LaserRing{12.0, evil, {{{0.0, 0.15, robot::RangeStatus::kValid}}}};
  AddSighting(trace.faults, {10.0, "S-M1" + evil, 3.0, 3.0, 0.8});
  trace.faults.back().jpeg = "jpeg";
  const std::string html = Report(scenario, trace);
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
}

TEST(Report, DrawsWhatIsInTheMapButNotBuilt) {
  Scenario scenario = TeeScenario();
  scenario.network.skipped = {{"egg", "S", "B", "not circular (EGG)", 20.0, 0.9, {{1.0, 2.0}}},
                              {"lost", "S", "nowhere", "undefined node: nowhere"}};
  const std::string html = Report(scenario, PerfectMission());
  EXPECT_THAT(html, HasSubstr("<title>egg: not circular (EGG), not enterable</title>"));
  EXPECT_THAT(html, HasSubstr("class=\"unbuilt\""));
  EXPECT_THAT(html, Not(HasSubstr("<title>lost")));
}

TEST(Report, StandsWithoutPicturesEstimatesOrFaults) {
  MissionTrace trace = PerfectMission();
  trace.faults.clear();
  trace.events.clear();
  for (EstimateSample& sample : trace.estimate) sample.pipe.clear();
  const std::string html = Report(TeeScenario(), trace);
  EXPECT_THAT(html, HasSubstr("<strong>Failed</strong>"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr(">inf")));
}

TEST(Report, SaysWhatIsNotKnownWithoutGroundTruth) {
  MissionTrace trace = PerfectMission();
  trace.truth.clear();
  trace.refused = 3;
  trace.lost = {{"front_camera", 2}};
  const std::string html = Report(TeeScenario(), trace);
  EXPECT_THAT(html, HasSubstr("<dt>Driven</dt><dd>not known</dd>"));
  EXPECT_THAT(html, HasSubstr("Not judged: no ground truth."));
  EXPECT_THAT(html, HasSubstr("2345, 0 cut to what the motors can, 3 refused"));
  EXPECT_THAT(html, HasSubstr("2 of Front camera"));
  EXPECT_THAT(html, Not(HasSubstr("false alarm")));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace kantaro::scenarios
