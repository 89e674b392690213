#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

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
  ASSERT_EQ(a.manholes.size(), b.manholes.size());
  for (std::size_t i = 0; i < a.manholes.size(); ++i) {
    EXPECT_EQ(a.manholes[i].name, b.manholes[i].name);
    EXPECT_EQ(a.manholes[i].p_WM, b.manholes[i].p_WM);
    EXPECT_EQ(a.manholes[i].depth_m, b.manholes[i].depth_m);
    EXPECT_EQ(a.manholes[i].shaft_diameter_m, b.manholes[i].shaft_diameter_m);
    EXPECT_EQ(a.manholes[i].channel_radius_m, b.manholes[i].channel_radius_m);
    EXPECT_EQ(a.manholes[i].bench_height, b.manholes[i].bench_height);
  }
  ASSERT_EQ(a.pipes.size(), b.pipes.size());
  for (std::size_t i = 0; i < a.pipes.size(); ++i) {
    const Pipe &p = a.pipes[i], &q = b.pipes[i];
    EXPECT_EQ(p.name, q.name);
    EXPECT_EQ(p.upstream, q.upstream);
    EXPECT_EQ(p.downstream, q.downstream);
    EXPECT_EQ(p.diameter_m, q.diameter_m);
    EXPECT_EQ(p.material, q.material);
    EXPECT_EQ(p.upstream_offset_m, q.upstream_offset_m);
    EXPECT_EQ(p.downstream_offset_m, q.downstream_offset_m);
    ASSERT_EQ(p.bends.size(), q.bends.size());
    for (std::size_t k = 0; k < p.bends.size(); ++k) {
      EXPECT_EQ(p.bends[k].p_W, q.bends[k].p_W);
      EXPECT_EQ(p.bends[k].radius_m, q.bends[k].radius_m);
    }
    ASSERT_EQ(p.joints.size(), q.joints.size());
    for (std::size_t k = 0; k < p.joints.size(); ++k) {
      EXPECT_EQ(p.joints[k].chainage_m, q.joints[k].chainage_m);
      EXPECT_EQ(p.joints[k].gap_m, q.joints[k].gap_m);
      EXPECT_EQ(p.joints[k].depth_m, q.joints[k].depth_m);
    }
    ASSERT_EQ(p.inlets.size(), q.inlets.size());
    for (std::size_t k = 0; k < p.inlets.size(); ++k) {
      EXPECT_EQ(p.inlets[k].name, q.inlets[k].name);
      EXPECT_EQ(p.inlets[k].chainage_m, q.inlets[k].chainage_m);
      EXPECT_EQ(p.inlets[k].diameter_m, q.inlets[k].diameter_m);
      EXPECT_EQ(p.inlets[k].clock_h, q.inlets[k].clock_h);
    }
    ASSERT_EQ(p.faults.size(), q.faults.size());
    for (std::size_t k = 0; k < p.faults.size(); ++k) {
      EXPECT_EQ(p.faults[k].name, q.faults[k].name);
      EXPECT_EQ(p.faults[k].category, q.faults[k].category);
      EXPECT_EQ(p.faults[k].rank, q.faults[k].rank);
      EXPECT_EQ(p.faults[k].chainage_m, q.faults[k].chainage_m);
      EXPECT_EQ(p.faults[k].clock_h, q.faults[k].clock_h);
      EXPECT_EQ(p.faults[k].length_m, q.faults[k].length_m);
      EXPECT_EQ(p.faults[k].width_m, q.faults[k].width_m);
    }
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

TEST(NetworkYaml, RegularJointsAreWrittenAsAPattern) {
  EXPECT_THAT(ToYaml(ParseYaml(kSmall, "small.yaml")),
              HasSubstr("joints: {first_m: 1, spacing_m: 2, gap_mm: 9, depth_mm: 5}"));
}

TEST(NetworkYaml, KeepsRemarksAsCommentsOfOneLine) {
  Network network = OnePipe();
  network.remarks = {{3, "node A", "a depth\nname: forged"}};
  network.skipped = {{"W1", "A", "B", "a weir"}};
  const std::string text = ToYaml(network);
  EXPECT_THAT(text, HasSubstr("# left out W1: a weir\n"));
  ExpectEqual(ParseYaml(text, "written.yaml"), network);
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

}  // namespace
}  // namespace kantaro::network
