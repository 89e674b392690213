#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "network/pipe_axis.hpp"
#include "network/topology.hpp"

namespace kantaro::network {
namespace {

using ::testing::HasSubstr;

// Drawn in metres: A (1000, 1000), B 50 m east, C 40 m north of B by a corner.
constexpr char kSmall[] = R"([TITLE]
anything
[OPTIONS]
FLOW_UNITS LPS
LINK_OFFSETS DEPTH
[JUNCTIONS]
;;Name Elevation MaxDepth
A	10.0	2.5
"B 1" 9.8 0 ; no depth
[OUTFALLS]
C 9.0 FREE
[CONDUITS]
c1 A "B 1" 50 0.010 0 0.1 0 0
c2 "B 1" C 50 0.013 0.2 0 0 0
[WEIRS]
w1 A C TRANSVERSE 0 3.3
[xsections]
c1 CIRCULAR 0.3 0 0 0 1
c2 circular 0.4 0 0 0 1
w1 RECT_OPEN 1 1 0 0
[COORDINATES]
A 1000 1000
"B 1" 1050 1000
C 1060 1040
[VERTICES]
c2 1060 1000
[SYMBOLS]
)";

std::string SmallWith(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Network Parse(const std::string& text) { return ParseSwmm(text, "small.inp"); }

void ExpectRefused(const std::string& text, int line, const std::string& field) {
  try {
    (void)Parse(text);
    ADD_FAILURE() << "accepted: " << text;
  } catch (const InputError& error) {
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_EQ(error.field(), field) << error.what();
  }
}

bool HasRemark(const Network& network, const std::string& subject, const std::string& text) {
  return std::any_of(network.remarks.begin(), network.remarks.end(), [&](const Remark& remark) {
    return remark.subject == subject && remark.text.find(text) != std::string::npos;
  });
}

std::string ReasonFor(const Network& network, const std::string& link) {
  for (const SkippedLink& skipped : network.skipped) {
    if (skipped.name == link) return skipped.reason;
  }
  return "";
}

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

TEST(Swmm, CircularConduitsBecomePipes) {
  const Network network = Parse(kSmall);
  EXPECT_EQ(network.name, "small");
  ASSERT_EQ(network.pipes.size(), 2u);
  const Pipe& c1 = network.pipes[0];
  EXPECT_EQ(c1.upstream, "A");
  EXPECT_EQ(c1.downstream, "B 1");
  EXPECT_EQ(c1.diameter_m, 0.3);
  EXPECT_EQ(c1.upstream_offset_m, 0.0);
  EXPECT_EQ(c1.downstream_offset_m, 0.1);
  EXPECT_EQ(c1.material, Material::kPvc);
  EXPECT_EQ(network.pipes[1].material, Material::kConcrete);
}

TEST(Swmm, NodesBecomeManholesAroundTheMapsMiddle) {
  const Network network = Parse(kSmall);
  ASSERT_EQ(network.manholes.size(), 3u);
  // The drawing spans 1000 … 1060 and 1000 … 1040.
  EXPECT_EQ(network.ManholeNamed("A").p_WM, Eigen::Vector3d(-30, -20, 10));
  EXPECT_EQ(network.ManholeNamed("C").p_WM, Eigen::Vector3d(30, 20, 9));
  EXPECT_EQ(network.ManholeNamed("A").depth_m, 2.5);
  EXPECT_EQ(network.ManholeNamed("B 1").depth_m, 2.0);
  EXPECT_TRUE(HasRemark(network, "node B 1", "no depth"));
}

TEST(Swmm, VerticesBecomeBendsOfOneAndAHalfDiameters) {
  const Pipe pipe = Parse(kSmall).pipes[1];
  ASSERT_EQ(pipe.bends.size(), 1u);
  EXPECT_EQ(pipe.bends[0].p_W, Eigen::Vector2d(30, -20));
  EXPECT_EQ(pipe.bends[0].radius_m, 0.6);
}

TEST(Swmm, AVertexThatDoesNotFitIsDroppedAndNamed) {
  const Network network = Parse(SmallWith("c2 1060 1000", "c2 1050.2 1000"));  // inside the shaft
  EXPECT_TRUE(network.pipes[1].bends.empty());
  EXPECT_TRUE(HasRemark(network, "conduit c2", "vertices left out"));
}

// The corner of c2 stands 0.1 m from a vertex in line with one of its legs, before it or after it.
TEST(Swmm, OfCrowdedVerticesTheSharperStays) {
  for (const char* vertices : {"c2 1059.9 1000\nc2 1060 1000", "c2 1060 1000\nc2 1060 1000.1"}) {
    const Network network = Parse(SmallWith("c2 1060 1000", vertices));
    ASSERT_EQ(network.pipes[1].bends.size(), 1u);
    EXPECT_EQ(network.pipes[1].bends[0].p_W, Eigen::Vector2d(30, -20));
  }
}

TEST(Swmm, OnlyEnterablePipesGetJoints) {
  const Network network = Parse(kSmall);
  EXPECT_GE(network.pipes[0].joints.size(), 26u);  // 49.2 m and less at 1.8 m
  EXPECT_TRUE(network.pipes[1].joints.empty());
  EXPECT_TRUE(HasRemark(network, "joints", "1.8 m"));
}

TEST(Swmm, WhatIsNoPipeIsSkippedWithAReason) {
  EXPECT_EQ(ReasonFor(Parse(kSmall), "w1"), "a weir");
  EXPECT_EQ(ReasonFor(Parse(SmallWith("c2 circular", "c2 EGG")), "c2"), "not circular (EGG)");
  EXPECT_THAT(ReasonFor(Parse(SmallWith("C 1060 1040\n", "")), "c2"), HasSubstr("no coordinates"));
  EXPECT_THAT(ReasonFor(Parse(SmallWith("c2 \"B 1\" C", "c2 \"B 1\" Z")), "c2"),
              HasSubstr("undefined node"));
  // 0.9 m apart: two shafts of 900 mm touch.
  std::string close = SmallWith("C 1060 1040\n[VERTICES]\nc2 1060 1000", "C 1050 1000.9");
  close.replace(close.find("\"B 1\" C 50"), 10, "\"B 1\" C .9");
  EXPECT_THAT(ReasonFor(Parse(close), "c2"), HasSubstr("too short"));
  EXPECT_THAT(ReasonFor(Parse(SmallWith("C 9.0", "C -90")), "c2"), HasSubstr("steeper"));
}

TEST(Swmm, AFileWithoutAUsablePipeIsRefused) {
  std::string text = SmallWith("c1 CIRCULAR", "c1 EGG");
  text.replace(text.find("c2 circular"), 11, "c2 TRIANGULAR");
  EXPECT_THROW((void)Parse(text), InputError);
}

TEST(Swmm, ReadsFeetWhereTheFlowUnitIsAmerican) {
  // The drawing is in feet as well.
  const Network network = Parse(SmallWith("LPS", "CFS"));
  EXPECT_NEAR(network.pipes[0].diameter_m, 0.3 * 0.3048, 5e-5);
  EXPECT_NEAR(network.ManholeNamed("A").p_WM.x(), -30 * 0.3048, 5e-4);
  EXPECT_NEAR(network.ManholeNamed("A").p_WM.z(), 10 * 0.3048, 5e-4);
}

TEST(Swmm, OffsetsMayBeElevations) {
  std::string text = SmallWith("LINK_OFFSETS DEPTH", "LINK_OFFSETS ELEVATION");
  text.replace(text.find("0.010 0 0.1"), 11, "0.010 * 9.9");
  text.replace(text.find("0.013 0.2 0"), 11, "0.013 10.1 8.5");
  const Network network = Parse(text);
  EXPECT_EQ(network.pipes[0].upstream_offset_m, 0.0);
  EXPECT_NEAR(network.pipes[0].downstream_offset_m, 0.1, 1e-9);
  EXPECT_NEAR(network.pipes[1].upstream_offset_m, 0.3, 1e-9);
  EXPECT_EQ(network.pipes[1].downstream_offset_m, 0.0);  // below the node: raised
  EXPECT_TRUE(HasRemark(network, "conduit c2", "below its node's invert"));
}

TEST(Swmm, AMapInAnotherScaleIsScaledToTheLengths) {
  std::string text = SmallWith("\"B 1\" C 50", "\"B 1\" C 500");
  text.replace(text.find("\"B 1\" 50 0.010"), 14, "\"B 1\" 500 0.010");
  const Network network = Parse(text);
  EXPECT_EQ(network.ManholeNamed("A").p_WM, Eigen::Vector3d(-300, -200, 10));
  EXPECT_TRUE(HasRemark(network, "map", "10 times"));
}

TEST(Swmm, SaysHowManyLengthsDifferFromTheMap) {
  const Network network = Parse(SmallWith("\"B 1\" C 50", "\"B 1\" C 47"));
  EXPECT_TRUE(HasRemark(network, "conduits", "1 of 2"));
}

TEST(Swmm, AManholeIsAtLeastAsDeepAsItsPipes) {
  const Network network = Parse(SmallWith("A\t10.0\t2.5", "A\t10.0\t0.25"));
  EXPECT_EQ(network.ManholeNamed("A").depth_m, 0.3);
  EXPECT_TRUE(HasRemark(network, "node A", "shallower"));
}

TEST(Swmm, IsNotPickyAboutLineEndsCaseTabsAndRepeatedSections) {
  std::string text = SmallWith("c2 \"B 1\" C", "[LOSSES]\nc1 0 0 0\n[Conduits]\nc2 \"B 1\" C");
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(Parse(crlf).pipes.size(), 2u);
}

TEST(Swmm, ReadsLatin1Names) {
  std::string text = kSmall;
  for (std::size_t at = 0; (at = text.find("B 1", at)) != std::string::npos;) {
    text.replace(at, 3, "\xC5");  // Å
  }
  EXPECT_TRUE(Parse(text).FindManhole("\xC3\x85").has_value());
}

TEST(Swmm, ComplaintsNameLineAndField) {
  ExpectRefused(SmallWith("A\t10.0", "A\thigh"), 8, "JUNCTIONS.Elevation");
  ExpectRefused(SmallWith("50 0.010 0 0.1 0 0", "50"), 13, "CONDUITS.Roughness");
  ExpectRefused(SmallWith("50 0.010", "-50 0.010"), 13, "CONDUITS.Length");
  ExpectRefused(SmallWith("50 0.010", "nan 0.010"), 13, "CONDUITS.Length");
  ExpectRefused(SmallWith("c1 CIRCULAR 0.3", "c1 CIRCULAR -0.3"), 18, "XSECTIONS.Geom1");
  ExpectRefused(SmallWith("c1 CIRCULAR 0.3 0 0 0 1\n", ""), 13, "XSECTIONS");
  ExpectRefused(SmallWith("A 1000 1000", "A 1000"), 22, "COORDINATES.Y");
  ExpectRefused(SmallWith("LPS", "BUCKETS"), 4, "OPTIONS.FLOW_UNITS");
  ExpectRefused(SmallWith("C 9.0 FREE", "A 9.0 FREE"), 11, "OUTFALLS.Name");
  ExpectRefused(SmallWith("c2 \"B 1\" C", "c1 \"B 1\" C"), 14, "CONDUITS.Name");
  ExpectRefused(SmallWith("[CONDUITS]", "[CONDUITS"), 12, "[CONDUITS");
  ExpectRefused("noise\n", 1, "");
  ExpectRefused(std::string("[OPTIONS]\n\0", 11), 2, "");
}

// Wherever a file is cut, it is refused, or what was lost is only of the map's vertices or named.
TEST(Swmm, ACutFileIsRefusedOrItsLossNamed) {
  const std::string whole = kSmall;
  const std::size_t vertices = whole.find("[VERTICES]");
  for (std::size_t length = 0; length < vertices; ++length) {
    try {
      const Network network = Parse(whole.substr(0, length));
      EXPECT_EQ(network.pipes.size() + network.skipped.size(), 3u) << length;
      EXPECT_TRUE(network.pipes.size() == 2 || !ReasonFor(network, "c2").empty()) << length;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("small.inp"));
    }
  }
}

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
  const std::vector<RouteLeg> route = ShortestRoute(network, "19", "10");
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

TEST(SwmmExamples, SurviveBeingWrittenAsYaml) {
  READ_SHARED(network, "nrtest_user4.inp");
  const Network again = ParseYaml(ToYaml(network), "user4.yaml");
  ASSERT_EQ(again.pipes.size(), network.pipes.size());
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    EXPECT_EQ(again.pipes[i].diameter_m, network.pipes[i].diameter_m);
    EXPECT_EQ(again.pipes[i].joints.size(), network.pipes[i].joints.size());
  }
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    EXPECT_EQ(again.manholes[i].p_WM, network.manholes[i].p_WM);
  }
}

}  // namespace
}  // namespace kantaro::network
