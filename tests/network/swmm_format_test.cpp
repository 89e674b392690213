#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "network/pipe_axis.hpp"
#include "tests/network/remarks.hpp"

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

double ToMillimetre(double value_m) { return std::round(value_m * 1000.0) / 1000.0; }

std::string ReasonFor(const Network& network, const std::string& link) {
  for (const SkippedLink& skipped : network.skipped) {
    if (skipped.name == link) return skipped.reason;
  }
  return "";
}

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

// kSmall's c1 is drawn from (1000, 1000) to (1050, 1000), c2 over (1060, 1000) to (1060, 1040).
TEST(Swmm, WhatIsNoPipeStaysInTheMapWithItsCourseAndSize) {
  const Network network = Parse(SmallWith("c2 circular 0.4", "c2 EGG 0.75"));
  ASSERT_EQ(network.skipped.size(), 2u);
  const SkippedLink& egg = network.skipped[0];
  EXPECT_EQ(egg.name, "c2");
  EXPECT_EQ(egg.upstream, "B 1");
  EXPECT_EQ(egg.downstream, "C");
  EXPECT_EQ(egg.height_m, 0.75);
  EXPECT_EQ(egg.length_m, 50.0);  // 10 m and 40 m
  ASSERT_EQ(egg.via_W.size(), 1u);
  EXPECT_EQ(egg.via_W[0], Eigen::Vector2d(30, -20));
  const SkippedLink& weir = network.skipped[1];
  EXPECT_EQ(weir.length_m, ToMillimetre(std::hypot(60.0, 40.0)));
  EXPECT_EQ(weir.height_m, 0.0);
}

TEST(Swmm, AnUndrawnLinkKeepsItsStatedLength) {
  const Network network = Parse(SmallWith("C 1060 1040\n", ""));
  EXPECT_EQ(network.skipped[0].name, "c2");
  EXPECT_EQ(network.skipped[0].length_m, 50.0);
}

// Of these only a number is a height: the others name a transect or a street.
TEST(Swmm, ShapesOfEveryKindStayInTheMap) {
  for (const char* shape :
       {"EGG 1 0 0 0", "HORSESHOE 1 0 0 0", "ARCH 1 1 0 0", "CUSTOM 1 curve", "RECT_CLOSED 1 2 0 0",
        "FILLED_CIRCULAR 1 0.2 0 0", "FORCE_MAIN 1 140 0 0"}) {
    const Network network = Parse(SmallWith("c2 circular 0.4 0 0 0 1", std::string("c2 ") + shape));
    EXPECT_EQ(network.skipped[0].height_m, 1.0) << shape;
    EXPECT_EQ(network.pipes.size(), 1u) << shape;
  }
  for (const char* shape : {"IRREGULAR river", "STREET high_street", "DUMMY"}) {
    const Network network = Parse(SmallWith("c2 circular 0.4 0 0 0 1", std::string("c2 ") + shape));
    EXPECT_EQ(network.skipped[0].height_m, 0.0) << shape;
  }
}

TEST(Swmm, OneOfSeveralBarrelsIsLaid) {
  const Network network = Parse(SmallWith("c2 circular 0.4 0 0 0 1", "c2 circular 0.4 0 0 0 3"));
  EXPECT_EQ(network.pipes.size(), 2u);
  EXPECT_TRUE(HasRemark(network, "conduit c2", "3 barrels"));
}

// The widest pipe makes the shafts: one of 15 m would leave no room for its neighbour of 50 m.
TEST(Swmm, APipeOfFifteenMetresIsNoPipeAndHarmsNoOther) {
  const Network network = Parse(SmallWith("c2 circular 0.4", "c2 circular 15"));
  EXPECT_THAT(ReasonFor(network, "c2"), HasSubstr("more than 10 m"));
  ASSERT_EQ(network.pipes.size(), 1u);
  EXPECT_EQ(network.ShaftDiameter(network.ManholeNamed("B 1")), 0.8);
}

TEST(Swmm, AnOffsetThatIsNotGivenIsNoneAndNamed) {
  const Network network = Parse(SmallWith("50 0.010 0 0.1 0 0", "50 0.010 0"));
  EXPECT_EQ(network.pipes[0].downstream_offset_m, 0.0);
  EXPECT_TRUE(HasRemark(network, "conduit c1", "an offset is not given"));
}

TEST(Swmm, AFileWithoutNodesOrCoordinatesSaysSo) {
  try {
    (void)Parse("[CONDUITS]\nc1 A B 1 1 0 0\n");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), "JUNCTIONS");
  }
  try {
    (void)Parse(SmallWith("A 1000 1000\n\"B 1\" 1050 1000\nC 1060 1040\n", ""));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), "COORDINATES");
  }
}

TEST(Swmm, AStorageUnitIsTakenForAManholeAndNamed) {
  const Network network = Parse(SmallWith("[OUTFALLS]\nC 9.0 FREE", "[STORAGE]\nC 9.0 4.0 0"));
  EXPECT_EQ(network.ManholeNamed("C").depth_m, 4.0);
  EXPECT_TRUE(HasRemark(network, "node C", "storage unit"));
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

TEST(Swmm, KnowsEveryUnitSystem) {
  for (const char* us : {"CFS", "GPM", "MGD", "cfs"}) {
    EXPECT_NEAR(Parse(SmallWith("LPS", us)).ManholeNamed("C").p_WM.z(), 2.7432, 5e-4) << us;
  }
  for (const char* si : {"CMS", "LPS", "MLD", "mld"}) {
    EXPECT_EQ(Parse(SmallWith("LPS", si)).ManholeNamed("C").p_WM.z(), 9.0) << si;
  }
  const Network silent = Parse(SmallWith("FLOW_UNITS LPS\n", ""));
  EXPECT_NEAR(silent.ManholeNamed("C").p_WM.z(), 2.7432, 5e-4);
  EXPECT_TRUE(HasRemark(silent, "units", "no FLOW_UNITS"));
}

TEST(Swmm, TheMapMaySayItsOwnUnit) {
  // In feet by its flow, drawn in metres: the conduits are 50 ft, 15.24 m, long.
  std::string text = SmallWith("LPS", "CFS");
  text += "[MAP]\nDIMENSIONS 0 0 1 1\nUNITS Meters\n";
  for (const char* length : {"\"B 1\" 50 0.010", "C 50 0.013"}) {
    const std::size_t at = text.find(length);
    const std::string words = length;
    text.replace(at, words.size(),
                 words.substr(0, words.find("50")) + "164.04" + words.substr(words.find("50") + 2));
  }
  const Network network = Parse(text);
  EXPECT_EQ(network.ManholeNamed("A").p_WM.x(), -30.0);
  EXPECT_FALSE(HasRemark(network, "map", "scaled"));
}

// On WGS 84 at 55° N a degree is 63,994 m of longitude and 111,325 m of latitude (from its axes:
// N cos φ and M with N = a / √(1 − e² sin² φ), M = a (1 − e²) / (1 − e² sin² φ)^1.5).
TEST(Swmm, ProjectsDegrees) {
  std::string text = SmallWith("A 1000 1000\n\"B 1\" 1050 1000\nC 1060 1040\n",
                               "A 10.000 55\n\"B 1\" 10.001 55\nC 10.001 55.0004\n");
  text.replace(text.find("c2 1060 1000\n"), 13, "");
  text += "[MAP]\nUnits Degrees\n";
  text.replace(text.find("\"B 1\" 50"), 8, "\"B 1\" 64");
  text.replace(text.find("C 50 0.013"), 10, "C 44.5 0.013");
  const Network network = Parse(text);
  const double a_m = 6378137.0, e2 = 6.69437999e-3, sine = std::sin(55.0 * std::numbers::pi / 180);
  const double n_m = a_m / std::sqrt(1 - e2 * sine * sine);
  const double m_m = a_m * (1 - e2) / std::pow(1 - e2 * sine * sine, 1.5);
  const Eigen::Vector3d east = network.ManholeNamed("B 1").p_WM - network.ManholeNamed("A").p_WM;
  const Eigen::Vector3d north = network.ManholeNamed("C").p_WM - network.ManholeNamed("B 1").p_WM;
  EXPECT_NEAR(east.x(), 0.001 * std::numbers::pi / 180 * n_m * std::sqrt(1 - sine * sine), 0.01);
  EXPECT_NEAR(north.y(), 0.0004 * std::numbers::pi / 180 * m_m, 0.01);
  EXPECT_NEAR(east.y(), 0.0, 1e-9);
  EXPECT_TRUE(HasRemark(network, "map", "degrees"));
  EXPECT_FALSE(HasRemark(network, "map", "scaled"));
}

TEST(Swmm, RefusesDegreesThatAreNone) {
  ExpectRefused(std::string(kSmall) + "[MAP]\nUnits Degrees\n", 8, "MAP.UNITS");
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

TEST(Swmm, ReadsHeadingsAsShortAsSwmmDoes) {
  std::string text = SmallWith("[JUNCTIONS]", "[Junc]");
  text.replace(text.find("[COORDINATES]"), 13, "[COORD]");
  EXPECT_EQ(Parse(text).pipes.size(), 2u);
}

TEST(Swmm, NamesSectionsThatSwmmDoesNotKnowAndPassesOverTheRest) {
  const Network network =
      Parse(std::string(kSmall) + "[POLYGONS]\nA x y\n[LID_CONTROLS]\n?\n[ROBOTS]\n???\n");
  EXPECT_EQ(network.pipes.size(), 2u);
  EXPECT_TRUE(HasRemark(network, "section [ROBOTS]", "unknown"));
  EXPECT_FALSE(HasRemark(network, "section [POLYGONS]", ""));
  EXPECT_FALSE(HasRemark(network, "section [LID_CONTROLS]", ""));
}

TEST(Swmm, QuotesOddHeadingsAndShapesSoThatTheyReadBack) {
  std::string heading = "[RO\tBOT ";
  for (int i = 0; i < 2000; ++i) heading += "\xC3\x85";  // Å
  std::string text = SmallWith("c2 circular", "c2 \"E\tGG\"") + heading + "]\n";
  const Network network = Parse(text);
  EXPECT_TRUE(HasRemark(network, "section [RO BOT " + heading.substr(8, 52) + "]", "unknown"));
  EXPECT_EQ(ReasonFor(network, "c2"), "not circular (E GG)");
  EXPECT_TRUE(ParseYaml(ToYaml(network), "again.yaml") == network);
}

TEST(Swmm, ReadsTheLineEndsOfOldMacs) {
  std::string text = kSmall;
  std::replace(text.begin(), text.end(), '\n', '\r');
  EXPECT_EQ(Parse(text).pipes.size(), 2u);
}

TEST(Swmm, NamesMayHoldAnythingPrintable) {
  for (const std::string name : {"#1", "a:b", "-", "~", "null", "x'y", "{[,]}", "Å ß 管", "a\\b",
                                 "*", "&a", "1e5", "true", "a;b", "%YAML", "?"}) {
    std::string text = kSmall;
    for (std::size_t at = 0; (at = text.find("B 1", at)) != std::string::npos;) {
      text.replace(at, 3, name);
      at += name.size();
    }
    const Network network = Parse(text);
    ASSERT_TRUE(network.FindManhole(name).has_value()) << name;
    EXPECT_TRUE(ParseYaml(ToYaml(network), "again.yaml").FindManhole(name).has_value()) << name;
  }
  ExpectRefused(SmallWith("\"B 1\" 9.8", "\"\" 9.8"), 9, "JUNCTIONS.Name");
  ExpectRefused(SmallWith("\"B 1\" 9.8", "\"B\t1\" 9.8"), 9, "JUNCTIONS.Name");
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
  ExpectRefused(SmallWith("w1 A C", "c1 A C"), 16, "WEIRS.Name");
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

}  // namespace
}  // namespace kantaro::network
