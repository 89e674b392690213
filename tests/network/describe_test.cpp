#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "network/formats.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// The 9.2 m of OnePipe, another 10 m − 0.4 m − 0.5 m of 500 mm (its far shaft is 1 m wide), and
/// remarks.
Network TwoPipes() {
  Network network = OnePipe();
  network.manholes.push_back(ManholeAt("C", 10, 10));
  network.pipes.push_back(PipeFrom("Q", "B", "C", 0.5));
  network.manholes[1].shaft_diameter_m = 0.8;
  network.pipes[0].inlets = {{"I", 3, 0.1, 3}};
  network.pipes[0].faults = {{"F", FaultCategory::kCrack, FaultRank::kA, 5, 12, 0.1, 0.005}};
  network.skipped = {{"W1", "A", "B", "a weir", 10.0},
                     {"X1", "A", "B", "too short: 0.2 m", 0.2},
                     {"X2", "A", "B", "too short: 0.3 m", 0.3, 0.75}};
  network.remarks = {{7, "node A", "no depth"}, {8, "node B", "no depth"}};
  return network;
}

TEST(Describe, SaysWhatIsThereAndWhatKantaroCanEnter) {
  const std::string text = Describe(TwoPipes());
  EXPECT_THAT(text, HasSubstr("in all                 2 pipes       18.3 m"));
  EXPECT_THAT(text, HasSubstr("KANTARO enters         1 pipe         9.2 m  200 to 350 mm"));
  EXPECT_THAT(text, HasSubstr("500 mm"));
  EXPECT_THAT(text, HasSubstr("curve                  1"));
  EXPECT_THAT(text, HasSubstr("inlets                 1  diameter 100 mm\n"));
  EXPECT_THAT(text, HasSubstr("planted faults         1  1 crack\n"));
}

/// OnePipe with two or three of everything.
Network Furnished() {
  Network network = OnePipe();
  network.manholes[0].bench_height = BenchHeight::kGiven;
  network.manholes[0].given_bench_m = 0.12;
  network.manholes[1].shaft_diameter_m = 0.8;
  network.manholes[1].channel_radius_m = 0.3;
  Pipe& pipe = network.pipes[0];
  pipe.material = Material::kClay;
  pipe.condition = WallCondition::kSlimy;
  pipe.water_m = 0.02;
  pipe.downstream_offset_m = 0.05;
  pipe.bends = {{{5, 0.5}, 0.45}};
  for (const double chainage_m : {1.0, 3.0, 5.0}) pipe.joints.push_back({chainage_m, 0.008});
  pipe.joints[0].offset_m = 0.006;
  pipe.joints[1].offset_m = 0.010;
  pipe.joints[2].deflection_rad = 1.5 * std::numbers::pi / 180;
  pipe.joints[2].gap_m = 0.020;
  pipe.sags = {{0.5, 4.0, 0.015}};
  pipe.diameter_changes = {{4.0, 0.25}};
  pipe.inlets = {{"I", 2, 0.1, 3}, {"K", 6, 0.15, 9}};
  pipe.inlets[1].angle_rad = std::numbers::pi / 4;
  pipe.inlets[1].protrusion_m = 0.03;
  pipe.obstacles = {{"a", ObstacleKind::kStone, 6, 6, 0.015, 0.05, 0.05},
                    {"b", ObstacleKind::kStone, 7, 6, 0.030, 0.08, 0.08},
                    {"c", ObstacleKind::kSediment, 8, 6, 0.020, 0.5, 0}};
  return network;
}

TEST(Describe, ListsEveryElementWithItsSizes) {
  const std::string text = Describe(Furnished());
  for (const char* row :
       {"clay, slimy            1 pipe", "given                  1\n",
        "given benches          1  height 120 mm\n", "given shafts           1  diameter 800 mm\n",
        "given channels         1  radius 300 mm\n", "drops                  1  height 50 mm\n",
        "bends                  1  radius 450 mm\n", "diameter changes       1  step 50 mm\n",
        "joints                 3  gap 8 to 20 mm\n",
        "joint offsets          2  offset 6 to 10 mm\n",
        "joint deflections      1  angle 1.5 deg\n", "sags                   1  depth 15 mm\n",
        "inlets                 2  diameter 100 to 150 mm\n",
        "slanted inlets         1  angle 45 deg\n", "protruding inlets      1  protrusion 30 mm\n",
        "pipes with water       1  depth 20 mm\n", "sediment               1  height 20 mm\n",
        "stones                 2  height 15 to 30 mm\n"}) {
    EXPECT_THAT(text, HasSubstr(std::string("  ") + row));
  }
  EXPECT_THAT(text, Not(HasSubstr("bricks")));  // there are none
}

TEST(DescribeJson, ListsEveryElementWithItsSizes) {
  const auto json = nlohmann::json::parse(DescribeJson(Furnished()));
  const auto& elements = json["elements"];
  EXPECT_EQ(elements["joint_offsets"]["count"], 2);
  EXPECT_NEAR(elements["joint_offsets"]["offset_mm"][0].get<double>(), 6, 1e-9);
  EXPECT_NEAR(elements["joint_offsets"]["offset_mm"][1].get<double>(), 10, 1e-9);
  EXPECT_EQ(elements["bricks"]["count"], 0);
  EXPECT_EQ(elements["drops"]["count"], 1);
  EXPECT_EQ(json["joints"], 3);
  EXPECT_EQ(json["manholes"]["bench_height"]["given"], 1);
  EXPECT_EQ(json["materials"][0]["material"], "clay");
  EXPECT_EQ(json["materials"][0]["condition"], "slimy");
}

// 4 m of 300 mm, the rest of 250 mm.
TEST(Describe, CountsAPipeForEveryDiameterItHas) {
  const auto json = nlohmann::json::parse(DescribeJson(Furnished()));
  EXPECT_EQ(json["diameters"][0]["diameter_mm"], 250);
  EXPECT_EQ(json["diameters"][1]["diameter_mm"], 300);
  EXPECT_NEAR(json["diameters"][1]["length_m"].get<double>(), 4.0, 1e-9);
  EXPECT_NEAR(json["diameters"][0]["length_m"].get<double>(),
              json["all"]["length_m"].get<double>() - 4.0, 1e-9);
}

TEST(Describe, GroupsWhatIsNotBuiltByReason) {
  const std::string text = Describe(TwoPipes());
  EXPECT_THAT(text, HasSubstr("1       10.0 m  a weir: W1"));
  EXPECT_THAT(text, HasSubstr("2        0.5 m  too short: X1, X2"));
  EXPECT_THAT(text, HasSubstr("in the map, not built     3 links       10.5 m"));
  EXPECT_THAT(text, HasSubstr("node A, node B: no depth"));
}

TEST(DescribeJson, HoldsTheSameFigures) {
  const auto json = nlohmann::json::parse(DescribeJson(TwoPipes()));
  EXPECT_EQ(json["all"]["pipes"], 2);
  EXPECT_NEAR(json["all"]["length_m"].get<double>(), 18.3, 1e-9);
  EXPECT_EQ(json["enterable"]["pipes"], 1);
  EXPECT_EQ(json["manholes"]["count"], 3);
  EXPECT_EQ(json["manholes"]["end"], 2);
  EXPECT_EQ(json["diameters"][1]["diameter_mm"], 500);
  EXPECT_EQ(json["faults"]["crack"], 1);
  EXPECT_EQ(json["skipped"].size(), 3u);
  EXPECT_EQ(json["skipped"][1]["reason"], "too short: 0.2 m");
  EXPECT_EQ(json["skipped"][1]["length_m"], 0.2);
  EXPECT_EQ(json["skipped"][2]["height_mm"], 750.0);
  EXPECT_EQ(json["remarks"][0]["line"], 7);
}

}  // namespace
}  // namespace kantaro::network
