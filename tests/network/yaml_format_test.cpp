#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "network/names.hpp"
#include "network/pipe_axis.hpp"
#include "network/topology.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

using ::testing::HasSubstr;

constexpr char kSmall[] = R"(name: small
manholes:
  - {name: A, position_m: [0, 0, 1.5]}
  - {name: B, position_m: [10, 0, 1.4], shaft_diameter_mm: 900, depth_m: 3, bench_height: axis,
     channel_radius_mm: 250}
pipes:
  - name: P
    from: A
    to: B
    diameter_mm: 250
    material: clay
    to_offset_mm: 20
    bends: [{at_m: [5, 0.5], radius_mm: 375}]
    joints: {first_m: 1, spacing_m: 2, gap_mm: 9, depth_mm: 5}
    inlets: [{name: I, at_m: 4, diameter_mm: 150, clock: 9.5}]
    faults: [{name: F, category: root_invasion, rank: B, at_m: 6, clock: 2, length_mm: 80, width_mm: 40}]
)";

/// kSmall with its first `from` replaced by `to`.
std::string SmallWith(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void ExpectRefused(const std::string& text, int line, const std::string& field) {
  try {
    (void)ParseYaml(text, "small.yaml");
    ADD_FAILURE() << "accepted: " << text;
  } catch (const InputError& error) {
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_EQ(error.field(), field) << error.what();
    EXPECT_THAT(error.what(), HasSubstr("small.yaml"));
  }
}

std::filesystem::path TestField() {
  return std::filesystem::path(KANTARO_SOURCE_DIR) / "models/networks/test_field.yaml";
}

TEST(NetworkYaml, IsReadInSiUnits) {
  const Network network = ParseYaml(kSmall, "small.yaml");
  EXPECT_EQ(network.name, "small");
  ASSERT_EQ(network.manholes.size(), 2u);
  EXPECT_EQ(network.manholes[0].p_WM, Eigen::Vector3d(0, 0, 1.5));
  EXPECT_FALSE(network.manholes[0].shaft_diameter_m.has_value());
  EXPECT_EQ(network.manholes[0].bench_height, BenchHeight::kCrown);
  EXPECT_EQ(network.manholes[0].depth_m, 2.0);
  EXPECT_EQ(network.manholes[1].shaft_diameter_m, 0.9);
  EXPECT_EQ(network.manholes[1].channel_radius_m, 0.25);
  EXPECT_EQ(network.manholes[1].depth_m, 3.0);
  EXPECT_EQ(network.manholes[1].bench_height, BenchHeight::kAxis);
  ASSERT_EQ(network.pipes.size(), 1u);
  const Pipe& pipe = network.pipes[0];
  EXPECT_EQ(pipe.upstream, "A");
  EXPECT_EQ(pipe.downstream, "B");
  EXPECT_EQ(pipe.diameter_m, 0.25);
  EXPECT_EQ(pipe.material, Material::kClay);
  EXPECT_EQ(pipe.upstream_offset_m, 0.0);
  EXPECT_EQ(pipe.downstream_offset_m, 0.02);
  ASSERT_EQ(pipe.bends.size(), 1u);
  EXPECT_EQ(pipe.bends[0].radius_m, 0.375);
  ASSERT_EQ(pipe.inlets.size(), 1u);
  EXPECT_EQ(pipe.inlets[0].diameter_m, 0.15);
  EXPECT_EQ(pipe.inlets[0].clock_h, 9.5);
  ASSERT_EQ(pipe.faults.size(), 1u);
  EXPECT_EQ(pipe.faults[0].category, FaultCategory::kRootInvasion);
  EXPECT_EQ(pipe.faults[0].rank, FaultRank::kB);
  EXPECT_EQ(pipe.faults[0].length_m, 0.08);
  EXPECT_EQ(pipe.faults[0].width_m, 0.04);
}

TEST(NetworkYaml, LaysRegularJoints) {
  const Network network = ParseYaml(kSmall, "small.yaml");
  // About 9.2 m between shafts of 750 and 900 mm: 1, 3, 5, 7; 9 would leave a stub under 0.5 m.
  ASSERT_EQ(network.pipes[0].joints.size(), 4u);
  EXPECT_EQ(network.pipes[0].joints[3].chainage_m, 7.0);
  EXPECT_EQ(network.pipes[0].joints[3].gap_m, 0.009);
  EXPECT_EQ(network.pipes[0].joints[3].depth_m, 0.005);
}

TEST(NetworkYaml, TakesJointsOneByOne) {
  const Network network = ParseYaml(SmallWith("{first_m: 1, spacing_m: 2, gap_mm: 9, depth_mm: 5}",
                                              "[{at_m: 2.5, gap_mm: 20}, {at_m: 3}]"),
                                    "small.yaml");
  ASSERT_EQ(network.pipes[0].joints.size(), 2u);
  EXPECT_EQ(network.pipes[0].joints[0].gap_m, 0.02);
  EXPECT_EQ(network.pipes[0].joints[1].gap_m, 0.008);
  EXPECT_EQ(network.pipes[0].joints[1].depth_m, 0.006);
}

TEST(NetworkYaml, ComplaintsNameLineAndField) {
  ExpectRefused(SmallWith("diameter_mm: 250", "diameter_mm: -250"), 10, "pipes[0].diameter_mm");
  ExpectRefused(SmallWith("diameter_mm: 250", "diameter_mm: wide"), 10, "pipes[0].diameter_mm");
  ExpectRefused(SmallWith("diameter_mm: 250", "diameter_mm: .nan"), 10, "pipes[0].diameter_mm");
  ExpectRefused(SmallWith("diameter_mm: 250", "diameter: 250"), 10, "pipes[0].diameter");
  ExpectRefused(SmallWith("to: B", "to: C"), 9, "pipes[0].to");
  ExpectRefused(SmallWith("name: B", "name: A"), 4, "manholes[1].name");
  ExpectRefused(SmallWith("[0, 0, 1.5]", "[0, 0]"), 3, "manholes[0].position_m");
  ExpectRefused(SmallWith("clay", "steel"), 11, "pipes[0].material");
  ExpectRefused(SmallWith("radius_mm: 375", "radius_mm: 100"), 13, "pipes[0].bends[0].radius_mm");
  ExpectRefused(SmallWith("radius_mm: 375", "radius_mm: 90000"), 13, "pipes[0].bends");
  ExpectRefused(SmallWith("diameter_mm: 150", "diameter_mm: 260"), 15,
                "pipes[0].inlets[0].diameter_mm");
  ExpectRefused(SmallWith("category: root_invasion", "category: worms"), 16,
                "pipes[0].faults[0].category");
  ExpectRefused(SmallWith("rank: B", "rank: D"), 16, "pipes[0].faults[0].rank");
  ExpectRefused(SmallWith("first_m: 1,", "first_m: 11,"), 14, "pipes[0].joints.first_m");
  ExpectRefused(SmallWith("first_m: 1,", "first_m: 0.001,"), 14, "pipes[0].joints[0].at_m");
  ExpectRefused(SmallWith("spacing_m: 2", "spacing_m: 1e-9"), 14, "pipes[0].joints.spacing_m");
  ExpectRefused(SmallWith("spacing_m: 2", "spacing_m: 0"), 14, "pipes[0].joints.spacing_m");
  ExpectRefused(SmallWith("gap_mm: 9", "gap_mm: 0"), 14, "pipes[0].joints[0].gap_mm");
  ExpectRefused(SmallWith("{first_m: 1, spacing_m: 2, gap_mm: 9, depth_mm: 5}", "[{at_m: 12}]"), 14,
                "pipes[0].joints[0].at_m");
  ExpectRefused(SmallWith("shaft_diameter_mm: 900", "shaft_diameter_mm: 200"), 4,
                "manholes[1].shaft_diameter_mm");
}

TEST(NetworkYaml, ADefaultThatDoesNotFitIsBlamedOnItsOwner) {
  // Depth is not in the file: the complaint points at the manhole that lacks it.
  ExpectRefused(SmallWith("to_offset_mm: 20", "from_offset_mm: 1900"), 3, "manholes[0].depth_m");
}

TEST(NetworkYaml, MissingPartsAreRefused) {
  EXPECT_THROW((void)ParseYaml("name: x\nmanholes: []\n", "x.yaml"), InputError);
  EXPECT_THROW((void)ParseYaml("name: x\nmanholes: []\npipes: []\n", "x.yaml"), InputError);
  EXPECT_THROW((void)ParseYaml("", "x.yaml"), InputError);
  EXPECT_THROW((void)ParseYaml("just a word", "x.yaml"), InputError);
  EXPECT_THROW((void)ParseYaml("[1, 2]", "x.yaml"), InputError);
}

void ExpectEqual(const Network& a, const Network& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_TRUE(a.manholes == b.manholes);
  ASSERT_EQ(a.pipes.size(), b.pipes.size());
  for (std::size_t i = 0; i < a.pipes.size(); ++i) {
    EXPECT_TRUE(a.pipes[i] == b.pipes[i]) << a.pipes[i].name << "\n" << ToYaml(a) << ToYaml(b);
  }
}

TEST(NetworkYaml, WhatIsWrittenReadsBackEqual) {
  Network network = ParseYaml(kSmall, "small.yaml");
  network.name = "Ærø \"north\" \\ south";
  network.manholes[0].name = network.pipes[0].upstream = "17";
  network.manholes[0].p_WM.x() = 1.0 / 3.0;
  network.pipes[0].joints.pop_back();  // no pattern any more
  network.pipes[0].faults[0].clock_h = 0.1;
  ExpectEqual(ParseYaml(ToYaml(network), "written.yaml"), network);
  const Network field = ReadNetwork(TestField());
  ExpectEqual(ParseYaml(ToYaml(field), "written.yaml"), field);
}

constexpr char kElements[] = R"(name: elements
manholes:
  - {name: A, position_m: [0, 0, 1.5], bench_height: flat}
  - {name: B, position_m: [10, 0, 1.4], bench_height: 120}
pipes:
  - name: P
    from: A
    to: B
    diameter_mm: 250
    material: clay
    condition: slimy
    water_mm: 15
    diameter_changes: [{at_m: 7.25, diameter_mm: 300, align: crown}]
    joints:
      - {at_m: 2, offset_mm: 10, offset_clock: 3}
      - {at_m: 4, deflection_deg: 1.5, deflection_clock: 9}
    sags: [{from_m: 1, to_m: 5, depth_mm: 25}]
    inlets: [{name: I, at_m: 3, diameter_mm: 100, clock: 10, angle_deg: 45, protrusion_mm: 40}]
    obstacles:
      - {name: mud, kind: sediment, at_m: 5.5, height_mm: 20, length_mm: 1200}
      - {name: pebble, kind: stone, at_m: 6.5, clock: 5, height_mm: 20, width_mm: 60}
      - {name: ring, kind: mortar_ridge, at_m: 4.5, height_mm: 10, length_mm: 30}
      - {name: half, kind: brick, at_m: 8, clock: 6.5, height_mm: 65, length_mm: 120, width_mm: 115}
)";

/// kElements with its first `from` replaced by `to`.
std::string ElementsWith(const std::string& from, const std::string& to) {
  std::string text = kElements;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(NetworkYaml, ReadsEveryElement) {
  const Network network = ParseYaml(kElements, "elements.yaml");
  EXPECT_EQ(network.manholes[0].bench_height, BenchHeight::kFlat);
  EXPECT_EQ(network.manholes[1].bench_height, BenchHeight::kGiven);
  EXPECT_EQ(network.manholes[1].given_bench_m, 0.120);
  const Pipe& pipe = network.pipes[0];
  EXPECT_EQ(pipe.condition, WallCondition::kSlimy);
  EXPECT_EQ(pipe.water_m, 0.015);
  ASSERT_EQ(pipe.diameter_changes.size(), 1u);
  EXPECT_EQ(pipe.diameter_changes[0], (DiameterChange{7.25, 0.3, Alignment::kCrown}));
  EXPECT_EQ(pipe.joints[0].offset_m, 0.010);
  EXPECT_EQ(pipe.joints[0].offset_clock_h, 3.0);
  EXPECT_EQ(pipe.joints[0].deflection_rad, 0.0);
  EXPECT_DOUBLE_EQ(pipe.joints[1].deflection_rad, 1.5 * std::numbers::pi / 180);
  EXPECT_EQ(pipe.joints[1].deflection_clock_h, 9.0);
  ASSERT_EQ(pipe.sags.size(), 1u);
  EXPECT_EQ(pipe.sags[0], (Sag{1.0, 5.0, 0.025}));
  EXPECT_DOUBLE_EQ(pipe.inlets[0].angle_rad, std::numbers::pi / 4);
  EXPECT_EQ(pipe.inlets[0].protrusion_m, 0.040);
  ASSERT_EQ(pipe.obstacles.size(), 4u);
  EXPECT_EQ(pipe.obstacles[0], (Obstacle{"mud", ObstacleKind::kSediment, 5.5, 6, 0.02, 1.2, 0}));
  EXPECT_EQ(pipe.obstacles[1],
            (Obstacle{"pebble", ObstacleKind::kStone, 6.5, 5, 0.02, 0.06, 0.06}));
  EXPECT_EQ(pipe.obstacles[2],
            (Obstacle{"ring", ObstacleKind::kMortarRidge, 4.5, 6, 0.01, 0.03, 0}));
  EXPECT_EQ(pipe.obstacles[3],
            (Obstacle{"half", ObstacleKind::kBrick, 8, 6.5, 0.065, 0.12, 0.115}));
}

TEST(NetworkYaml, MeansASoundDryPipeWhereNothingIsSaid) {
  const Network network = ParseYaml(kSmall, "small.yaml");
  EXPECT_EQ(network.pipes[0].condition, WallCondition::kDry);
  EXPECT_EQ(network.pipes[0].water_m, 0.0);
  EXPECT_EQ(network.pipes[0].joints[0].offset_m, 0.0);
  EXPECT_DOUBLE_EQ(network.pipes[0].inlets[0].angle_rad, std::numbers::pi / 2);
}

TEST(NetworkYaml, ComplaintsAboutElementsNameLineAndField) {
  const auto refused = [](const char* from, const char* to, int line, const char* field) {
    ExpectRefused(ElementsWith(from, to), line, field);
  };
  refused("bench_height: flat", "bench_height: high", 3, "manholes[0].bench_height");
  refused("bench_height: 120", "bench_height: -5", 4, "manholes[1].bench_height");
  refused("bench_height: 120", "bench_height: 12x", 4, "manholes[1].bench_height");
  refused("slimy", "icy", 11, "pipes[0].condition");
  refused("water_mm: 15", "water_mm: 250", 12, "pipes[0].water_mm");
  refused("align: crown", "align: centre", 13, "pipes[0].diameter_changes[0].align");
  refused("at_m: 7.25", "at_m: 4.001", 13, "pipes[0].diameter_changes[0].at_m");
  refused("offset_mm: 10", "offset_mm: 130", 15, "pipes[0].joints[0].offset_mm");
  refused("offset_mm: 10", "offset: 10", 15, "pipes[0].joints[0].offset");
  refused("deflection_deg: 1.5", "deflection_deg: 15", 16, "pipes[0].joints[1].deflection_deg");
  refused("from_m: 1, to_m: 5", "from_m: 4.5, to_m: 5", 17, "pipes[0].sags[0].from_m");
  refused("depth_mm: 25", "depth_mm: 0", 17, "pipes[0].sags[0].depth_mm");
  refused("angle_deg: 45", "angle_deg: 20", 18, "pipes[0].inlets[0].angle_deg");
  refused("protrusion_mm: 40", "protrusion_mm: deep", 18, "pipes[0].inlets[0].protrusion_mm");
  refused("kind: sediment", "kind: mud", 20, "pipes[0].obstacles[0].kind");
  refused("length_mm: 1200", "length_mm: 0", 20, "pipes[0].obstacles[0].length_mm");
  refused("width_mm: 60", "width_mm: 30", 21, "pipes[0].obstacles[1].width_mm");
  refused("name: ring", "name: mud", 22, "pipes[0].obstacles[2].name");
  refused("height_mm: 65", "height_mm: 300", 23, "pipes[0].obstacles[3].height_mm");
}

TEST(NetworkYaml, EveryElementReadsBackEqual) {
  const Network network = ParseYaml(kElements, "elements.yaml");
  ExpectEqual(ParseYaml(ToYaml(network), "written.yaml"), network);
  EXPECT_THAT(ToYaml(network), HasSubstr("bench_height: 120"));
  EXPECT_THAT(ToYaml(network), HasSubstr("deflection_deg: 1.5, deflection_clock: 9}"));
}

// Chance numbers have as many digits as there are.
TEST(NetworkYaml, AnyNetworkReadsBackEqual) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Network network = RandomSewer(seed);
    ExpectEqual(ParseYaml(ToYaml(network), "written.yaml"), network);
  }
}

TEST(NetworkYaml, APatternCanSag) {
  const Network network = ParseYaml(
      SmallWith("    inlets:", "    sags: [{from_m: 2, to_m: 6, depth_mm: 20}]\n    inlets:"),
      "small.yaml");
  ASSERT_EQ(network.pipes[0].sags.size(), 1u);
  EXPECT_THAT(ToYaml(network), HasSubstr("joints: {first_m: 1, spacing_m: 2"));
  ExpectEqual(ParseYaml(ToYaml(network), "written.yaml"), network);
  ExpectRefused(
      SmallWith("    inlets:", "    sags: [{from_m: 1, to_m: 2, depth_mm: 20}]\n    inlets:"), 15,
      "pipes[0].sags[0].from_m");
}

TEST(NetworkYaml, RegularJointsAreWrittenAsAPattern) {
  EXPECT_THAT(ToYaml(ParseYaml(kSmall, "small.yaml")),
              HasSubstr("joints: {first_m: 1, spacing_m: 2, gap_mm: 9, depth_mm: 5}"));
}

TEST(NetworkYaml, KeepsWhatIsNotBuiltAndWhatWasSaidOfIt) {
  Network network = OnePipe();
  network.remarks = {{3, "node \"A\"", "a depth"}, {{}, "map", "it's a \\ and a # comment"}};
  network.skipped = {{"W1", "A", "nowhere", "a weir: of {wood}", 12.5, 0.3, {{1, 2}, {3.25, -4}}},
                     {"P 2", "B", "A", "a pump"}};
  const Network again = ParseYaml(ToYaml(network), "written.yaml");
  EXPECT_TRUE(again == network);
  ASSERT_EQ(again.skipped.size(), 2u);
  EXPECT_EQ(again.skipped[0].via_W[1], Eigen::Vector2d(3.25, -4));
  EXPECT_EQ(again.remarks[1].text, "it's a \\ and a # comment");
}

// 2.1 and 47.7 mm are among the fiftieth of all tenths that are no double's thousandth.
TEST(NetworkYaml, KeepsTheHeightOfWhatIsNotBuiltToTheBit) {
  Network network = OnePipe();
  for (int tenths = 1; tenths <= 20'000; ++tenths) {
    network.skipped.push_back({"W", "A", "B", "a weir", 0.0, tenths / 1e4});
  }
  const std::string text = ToYaml(network);
  EXPECT_THAT(text, HasSubstr("height_mm: 2.1}"));
  EXPECT_THAT(text, HasSubstr("height_mm: 2000}"));
  EXPECT_TRUE(ParseYaml(text, "written.yaml") == network);
}

TEST(NetworkYaml, KeepsRemarksOnOneLine) {
  Network network = OnePipe();
  network.remarks = {{3, "node A", "a depth\nname: forged"}};
  const Network again = ParseYaml(ToYaml(network), "written.yaml");
  EXPECT_EQ(again.name, network.name);
  EXPECT_EQ(again.remarks[0].text, "a depth name: forged");
}

TEST(NetworkYaml, NotesAreReadAsStrictlyAsTheRest) {
  const std::string text = ToYaml(OnePipe());
  const auto refuses = [&](const std::string& more, const std::string& field) {
    try {
      (void)ParseYaml(text + more, "notes.yaml");
      ADD_FAILURE() << more;
    } catch (const InputError& error) {
      EXPECT_EQ(error.field(), field) << error.what();
    }
  };
  const std::string link = "not_enterable:\n  - {name: W, from: A, to: B";
  refuses(link + "}\n", "not_enterable[0]");
  refuses(link + ", reason: weir, colour: red}\n", "not_enterable[0].colour");
  refuses(link + ", reason: weir, length_m: -1}\n", "not_enterable[0].length_m");
  refuses(link + ", reason: weir, via_m: [[1, 2, 3]]}\n", "not_enterable[0].via_m[0]");
  refuses(link + ", reason: \"a\\nb\"}\n", "not_enterable[0].reason");
  refuses("remarks: [{about: A, text: b, line: 0}]\n", "remarks[0].line");
}

TEST(ReadNetwork, GoesByTheEnding) {
  EXPECT_THROW((void)ReadNetwork("network.txt"), InputError);
  EXPECT_THROW((void)ReadNetwork("missing.yaml"), InputError);
}

// Thesis section 5.6 and the issue: three manholes of different kinds between two ends, a 250 mm
// branch, two inlets of 100 and 150 mm, three faults, pipe lengths under 2 m.
TEST(TestField, IsTheThesisDryField) {
  const Network field = ReadNetwork(TestField());
  const auto kind = [&](const char* name) { return KindOf(field, field.ManholeNamed(name)); };
  EXPECT_EQ(kind("S"), ManholeKind::kEnd);
  EXPECT_EQ(kind("M1"), ManholeKind::kStraight);
  EXPECT_EQ(kind("M2"), ManholeKind::kTee);
  EXPECT_EQ(kind("M3"), ManholeKind::kCurve);
  EXPECT_EQ(kind("E"), ManholeKind::kEnd);
  EXPECT_EQ(kind("B"), ManholeKind::kEnd);
  std::vector<double> inlets_m;
  std::size_t faults = 0;
  for (const Pipe& pipe : field.pipes) {
    const PipeAxis axis(field, pipe);
    EXPECT_LT(axis.grade(), -0.005) << pipe.name;
    EXPECT_GT(axis.grade(), -0.010) << pipe.name;
    EXPECT_EQ(pipe.material, Material::kPvc);
    EXPECT_EQ(pipe.diameter_m, pipe.name < "P4" ? 0.3 : 0.25);
    double last_m = 0.0;
    for (const Joint& joint : pipe.joints) {
      EXPECT_LT(joint.chainage_m - last_m, 2.0);
      last_m = joint.chainage_m;
    }
    EXPECT_LT(axis.length_m() - last_m, 2.0) << pipe.name;
    for (const Inlet& inlet : pipe.inlets) {
      inlets_m.push_back(inlet.diameter_m);
      for (const Joint& joint : pipe.joints) {
        EXPECT_GT(std::abs(joint.chainage_m - inlet.chainage_m), 0.5);
      }
    }
    for (const Fault& fault : pipe.faults) {
      ++faults;
      EXPECT_TRUE(fault.clock_h <= 4 || fault.clock_h >= 8) << "the wheels run there";
    }
  }
  EXPECT_EQ(inlets_m, (std::vector<double>{0.15, 0.10}));
  EXPECT_EQ(faults, 3u);
}

TEST(TestField, LeavesTheTeeToTheLeftAndTheCurveToTheRight) {
  const Network field = ReadNetwork(TestField());
  const auto leaves = [&](const char* pipe, const char* manhole) {
    return DirectionFrom(field, field.PipeNamed(pipe), field.ManholeNamed(manhole));
  };
  EXPECT_LT((leaves("P5", "M2") - Eigen::Vector2d(0, 1)).norm(), 1e-12);
  EXPECT_LT((leaves("P4", "M3") - Eigen::Vector2d(0, -1)).norm(), 1e-12);
}

std::filesystem::path EveryElement() {
  return std::filesystem::path(KANTARO_SOURCE_DIR) / "models/networks/every_element.yaml";
}

/// Of all pipes, what they hold of one kind.
template <typename Item>
std::vector<Item> All(const Network& network, std::vector<Item> Pipe::*list) {
  std::vector<Item> all;
  for (const Pipe& pipe : network.pipes) {
    all.insert(all.end(), (pipe.*list).begin(), (pipe.*list).end());
  }
  return all;
}

template <typename Range, typename Predicate>
bool Any(const Range& range, const Predicate& predicate) {
  return std::any_of(range.begin(), range.end(), predicate);
}

TEST(EveryElement, HoldsEachAtLeastOnce) {
  const Network network = ReadNetwork(EveryElement());
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(Any(network.manholes, [&](const Manhole& m) {
      return m.bench_height == static_cast<BenchHeight>(i);
    })) << i;
    EXPECT_TRUE(Any(network.pipes, [&](const Pipe& p) {
      return p.material == static_cast<Material>(i);
    })) << i;
    EXPECT_TRUE(Any(All(network, &Pipe::obstacles), [&](const Obstacle& o) {
      return o.kind == static_cast<ObstacleKind>(i);
    })) << i;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(Any(network.pipes, [&](const Pipe& p) {
      return p.condition == static_cast<WallCondition>(i);
    })) << i;
    EXPECT_TRUE(Any(All(network, &Pipe::diameter_changes), [&](const DiameterChange& c) {
      return c.alignment == static_cast<Alignment>(i);
    })) << i;
  }
  for (const char* kind : {"end", "straight", "curve", "tee", "wye", "cross"}) {
    EXPECT_TRUE(Any(network.manholes, [&](const Manhole& m) {
      return ToString(KindOf(network, m)) == kind;
    })) << kind;
  }
  EXPECT_TRUE(Any(network.manholes, [](const Manhole& m) { return m.shaft_diameter_m; }));
  EXPECT_TRUE(Any(network.manholes, [](const Manhole& m) { return m.channel_radius_m; }));
  EXPECT_TRUE(Any(network.pipes, [](const Pipe& p) { return p.water_m > 0; }));
  EXPECT_TRUE(Any(network.pipes, [](const Pipe& p) { return p.downstream_offset_m > 0.09; }));
  EXPECT_TRUE(Any(network.pipes, [](const Pipe& p) { return !IsEnterable(p); }));
  EXPECT_FALSE(All(network, &Pipe::bends).empty());
  EXPECT_FALSE(All(network, &Pipe::sags).empty());
  EXPECT_FALSE(All(network, &Pipe::faults).empty());
  const std::vector<Joint> joints = All(network, &Pipe::joints);
  EXPECT_TRUE(Any(joints, [](const Joint& j) { return j.offset_m > 0; }));
  EXPECT_TRUE(Any(joints, [](const Joint& j) { return j.deflection_rad > 0; }));
  EXPECT_TRUE(Any(joints, [](const Joint& j) { return j.gap_m > 0.015; }));
  const std::vector<Inlet> inlets = All(network, &Pipe::inlets);
  EXPECT_TRUE(Any(inlets, [](const Inlet& i) { return i.protrusion_m > 0; }));
  EXPECT_TRUE(Any(inlets, [](const Inlet& i) { return i.angle_rad < 1.0; }));
  EXPECT_TRUE(Any(All(network, &Pipe::obstacles), [](const Obstacle& o) {
    return o.kind == ObstacleKind::kMortarRidge && o.width_m == 0.0;
  }));
}

TEST(EveryElement, ReadsBackEqual) {
  const Network network = ReadNetwork(EveryElement());
  ExpectEqual(ParseYaml(ToYaml(network), "written.yaml"), network);
}

}  // namespace
}  // namespace kantaro::network
