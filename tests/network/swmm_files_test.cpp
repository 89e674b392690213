// Maps that others made, counted by other tools.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "network/formats.hpp"
#include "network/pipe_axis.hpp"
#include "network/topology.hpp"
#include "tests/network/remarks.hpp"

namespace kantaro::network {
namespace {

/// Where data that may not ship lies, or an empty path.
std::filesystem::path Shared(const std::string& name) {
  const char* given = std::getenv("KANTARO_DATA");
  const std::filesystem::path data =
      given != nullptr ? given : std::filesystem::path(KANTARO_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path file = data / "swmm" / name;
  return std::filesystem::exists(file) ? file : std::filesystem::path();
}

#define READ_SHARED(network, name)                                             \
  if (Shared(name).empty())                                                    \
    GTEST_SKIP() << name << " is not here: it may not ship, set KANTARO_DATA"; \
  const Network network = ReadNetwork(Shared(name))

// Example 1 of EPA: 13 conduits from 1 to 2 ft in a drawing of arbitrary units, MaxDepth 3 ft.
TEST(SwmmExample1, IsReadWhole) {
  const Network network =
      ReadNetwork(std::filesystem::path(KANTARO_SOURCE_DIR) / "models/networks/epa_example1.inp");
  EXPECT_EQ(network.manholes.size(), 14u);
  EXPECT_EQ(network.pipes.size(), 13u);
  EXPECT_TRUE(network.skipped.empty());
  EXPECT_EQ(std::count_if(network.pipes.begin(), network.pipes.end(), IsEnterable), 4);  // of 1 ft
  EXPECT_NEAR(network.PipeNamed("6").diameter_m, 0.3048, 1e-4);
  EXPECT_NEAR(network.PipeNamed("6").downstream_offset_m, 0.3048, 1e-3);
  EXPECT_NEAR(network.ManholeNamed("9").p_WM.z(), 304.8, 1e-3);
  EXPECT_NEAR(network.ManholeNamed("10").depth_m, 0.9144, 1e-3);
  EXPECT_TRUE(HasRemark(network, "map", "scaled"));
  // By hand from the drawing: 4, 5 and 6 are of 1 ft and lead from 19 over 20 and 21 to 10.
  const std::vector<RouteLeg> route = ShortestRoute(network, {"19", "10"});
  ASSERT_EQ(route.size(), 3u);
  EXPECT_EQ(route[0].pipe, "4");
  EXPECT_EQ(route[2].pipe, "6");
  EXPECT_FALSE(route[2].downstream);
}

// Counted with awk: 1,015 conduits, 951 of them circular, 555 of 200 to 350 mm; the circular ones
// add up to 48,028 m from node to node, the enterable ones to 28,020 m.
TEST(SwmmBellinge, IsReadWithTheCountsOfAnIndependentTool) {
  READ_SHARED(network, "bellinge_full.inp");
  EXPECT_EQ(network.manholes.size(), 1020u);
  EXPECT_EQ(network.pipes.size(), 951u);
  EXPECT_EQ(network.skipped.size(), 64u + 6 + 3 + 13 + 7);
  const NetworkIndex index(network);
  double shafts_m = 0.0, all_m = 0.0, enterable_m = 0.0, enterable_shafts_m = 0.0;
  int enterable = 0;
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const double length_m = PipeAxis(network, index, i).length_m();
    all_m += length_m;
    const double taken_m =
        (index.shaft_diameter_m[index.upstream[i]] + index.shaft_diameter_m[index.downstream[i]]) /
        2;
    shafts_m += taken_m;
    if (!IsEnterable(network.pipes[i])) continue;
    ++enterable;
    enterable_m += length_m;
    enterable_shafts_m += taken_m;
  }
  EXPECT_EQ(enterable, 555);
  EXPECT_NEAR(all_m + shafts_m, 48'028.0, 0.002 * 48'028.0);  // bends cut corners
  EXPECT_NEAR(enterable_m + enterable_shafts_m, 28'020.0, 0.002 * 28'020.0);
}

TEST(SwmmStatePlane, IsReadInFeetAtItsTrueScale) {
  READ_SHARED(network, "swmmio_model_state_plane.inp");
  EXPECT_EQ(network.pipes.size(), 44u);
  EXPECT_FALSE(HasRemark(network, "map", "scaled"));
}

TEST(SwmmInvalidModel, LoadsWithItsUndefinedNodesNamed) {
  READ_SHARED(network, "swmmio_invalid_model.inp");
  EXPECT_EQ(std::count_if(network.skipped.begin(), network.skipped.end(),
                          [](const SkippedLink& link) {
                            return link.reason.find("undefined node") != std::string::npos;
                          }),
            2);
}

class SwmmExamples : public ::testing::TestWithParam<const char*> {};

TEST_P(SwmmExamples, AreWrittenAsYamlThatReadsBackEqual) {
  READ_SHARED(network, GetParam());
  EXPECT_TRUE(ParseYaml(ToYaml(network), "again.yaml") == network);
}

INSTANTIATE_TEST_SUITE_P(All, SwmmExamples,
                         ::testing::Values("bellinge_full.inp", "nrtest_Example1.inp",
                                           "nrtest_Example3.inp", "nrtest_user1.inp",
                                           "nrtest_user4.inp", "swmmio_model_state_plane.inp",
                                           "swmmio_invalid_model.inp"),
                         [](const auto& one) {
                           const std::string file = one.param;
                           return file.substr(0, file.find('.'));
                         });

}  // namespace
}  // namespace kantaro::network
