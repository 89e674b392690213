// One scenario and one seed give one trace, whatever else the machine does.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "scenarios/child_process.hpp"

namespace kantaro::scenarios {
namespace {

using Words = std::vector<std::string>;

/// `trace_sha256` of each of some missions: `kantaro run SCENARIO` with these words more.
std::vector<std::string> Traces(const std::string& scenario, const std::vector<Words>& missions,
                                unsigned jobs) {
  const auto out =
      std::filesystem::path(testing::TempDir()) / ("repeatability-" + std::to_string(getpid()));
  std::vector<ChildJob> children;
  for (const Words& words : missions) {
    children.push_back(
        {{KANTARO_PROGRAM, "run", (std::filesystem::path(KANTARO_SOURCE_DIR) / scenario).string(),
          "--out", (out / std::to_string(children.size())).string(), "--json"}});
    children.back().arguments.insert(children.back().arguments.end(), words.begin(), words.end());
  }
  std::vector<std::string> traces(missions.size());
  RunChildren(children, jobs, [&](std::size_t mission, const ChildResult& result) {
    EXPECT_EQ(result.signal, 0);
    EXPECT_LE(result.exit_code, 1) << result.err;
    const auto json = nlohmann::json::parse(result.out, nullptr, /*allow_exceptions=*/false);
    if (!json.is_discarded()) traces[mission] = json.at("trace_sha256").get<std::string>();
    EXPECT_EQ(traces[mission].size(), 64u) << result.out;
  });
  std::filesystem::remove_all(out);
  return traces;
}

#ifdef KANTARO_LONG_MISSIONS

std::set<std::string> AsSet(const std::vector<std::string>& traces) {
  return {traces.begin(), traces.end()};
}

TEST(RepeatabilitySoak, TwentyRunsOfAShortMissionGiveOneTrace) {
  EXPECT_EQ(AsSet(Traces("tests/apps/short_mission.yaml", std::vector<Words>(20), 2)).size(), 1u);
}

TEST(RepeatabilitySoak, TwentyRunsOfRoute1GiveOneTrace) {
  EXPECT_EQ(AsSet(Traces("scenarios/route_1.yaml", std::vector<Words>(20), 2)).size(), 1u);
}

TEST(RepeatabilitySoak, RenderThreadsChangeNothingOfRoute1) {
  const auto missions = std::vector<Words>{
      {"--render-threads", "0"}, {"--render-threads", "1"}, {"--render-threads", "2"}};
  EXPECT_EQ(AsSet(Traces("scenarios/route_1.yaml", missions, 1)).size(), 1u);
}

#else

constexpr const char* kScenario = "tests/apps/first_seconds.yaml";

TEST(Repeatability, ATraceIsTheSameAloneAndBesideAnotherWithAnyNumberOfRenderThreads) {
  const auto beside = Traces(kScenario, {{"--seed", "1"}, {"--seed", "2"}}, 2);
  EXPECT_NE(beside[0], beside[1]) << "another seed is another mission";
  const auto alone = Traces(kScenario, {{"--render-threads", "0"}, {"--render-threads", "1"}}, 1);
  EXPECT_EQ(alone[0], beside[0]) << "rendering not beside the physics";
  EXPECT_EQ(alone[1], beside[0]);
}

// As a processor would run it that has AVX2 and nothing newer.
TEST(Repeatability, TheWidthOfVectorsAndLlvmpipesThreadsChangeNoTrace) {
  const auto usual = Traces(kScenario, {{}}, 1);
  setenv("LP_NATIVE_VECTOR_WIDTH", "128", 1);
  setenv("LP_NUM_THREADS", "0", 1);
  setenv("GALLIUM_OVERRIDE_CPU_CAPS", "avx", 1);
  setenv("OPENCV_CPU_DISABLE", "AVX512-COMMON,AVX512-SKX", 1);
  setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ", 1);
  EXPECT_EQ(Traces(kScenario, {{}}, 1), usual);
}

#endif

}  // namespace
}  // namespace kantaro::scenarios
