#include "network/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

using ::testing::HasSubstr;

/// Spoils the sound network OnePipe and returns the field that Check complains of, "" if it is
/// content.
std::string FieldAfter(const std::function<void(Network&)>& spoil) {
  Network network = OnePipe();
  network.pipes[0].joints = {{2.0}, {4.0}};
  network.pipes[0].inlets = {{"I", 3.0, 0.1, 3.0}};
  network.pipes[0].faults = {{"F", FaultCategory::kCrack, FaultRank::kA, 5.0, 12.0, 0.1, 0.005}};
  spoil(network);
  try {
    Check(network, "test.yaml");
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("test.yaml: " + error.field() + ": "));
    EXPECT_FALSE(error.line().has_value());
    return error.field();
  }
  return "";
}

TEST(Check, AcceptsASoundNetwork) {
  EXPECT_EQ(FieldAfter([](Network&) {}), "");
}

TEST(Check, DemandsNamesThatAreUniqueAndPrintable) {
  EXPECT_EQ(FieldAfter([](Network& n) { n.manholes[1].name = "A"; }), "manholes[1].name");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes.push_back(n.pipes[0]); }), "pipes[1].name");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].name = ""; }), "pipes[0].name");
  EXPECT_EQ(FieldAfter([](Network& n) { n.name = "two\nlines"; }), "name");
  EXPECT_EQ(FieldAfter([](Network& n) { n.name = "\xE6"; }), "name");  // Latin-1, not UTF-8
  EXPECT_EQ(FieldAfter([](Network& n) { n.name = "\xC3\xA6"; }), "");
  EXPECT_EQ(FieldAfter([](Network& n) { n.name = std::string(201, 'x'); }), "name");
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.pipes[0].inlets.push_back({"I", 6.0, 0.1, 3.0});
            }),
            "pipes[0].inlets[1].name");
}

TEST(Check, DemandsKnownAndDifferentEnds) {
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].downstream = "Z"; }), "pipes[0].to");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].upstream = "Z"; }), "pipes[0].from");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].downstream = "A"; }), "pipes[0].to");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes.clear(); }), "pipes");
}

TEST(Check, DemandsPositiveFiniteSizes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {-0.3, 0.0, nan, 11.0}) {
    EXPECT_EQ(FieldAfter([&](Network& n) { n.pipes[0].diameter_m = bad; }), "pipes[0].diameter_mm");
  }
  EXPECT_EQ(FieldAfter([&](Network& n) { n.manholes[0].p_WM.z() = nan; }),
            "manholes[0].position_m");
  EXPECT_EQ(FieldAfter([&](Network& n) { n.manholes[0].depth_m = 0; }), "manholes[0].depth_m");
  EXPECT_EQ(FieldAfter([&](Network& n) { n.pipes[0].upstream_offset_m = -0.01; }),
            "pipes[0].from_offset_mm");
  EXPECT_EQ(FieldAfter([&](Network& n) { n.pipes[0].downstream_offset_m = nan; }),
            "pipes[0].to_offset_mm");
  EXPECT_EQ(FieldAfter([&](Network& n) { n.pipes[0].joints[1].gap_m = 0; }),
            "pipes[0].joints[1].gap_mm");
  EXPECT_EQ(FieldAfter([&](Network& n) { n.pipes[0].joints[1].depth_m = nan; }),
            "pipes[0].joints[1].depth_mm");
}

TEST(Check, DemandsAShaftThatTakesThePipe) {
  EXPECT_EQ(FieldAfter([](Network& n) { n.manholes[1].shaft_diameter_m = 0.3; }),
            "manholes[1].shaft_diameter_mm");
  EXPECT_EQ(FieldAfter([](Network& n) { n.manholes[1].channel_radius_m = 0.1; }),
            "manholes[1].channel_radius_mm");
  EXPECT_EQ(FieldAfter([](Network& n) { n.manholes[0].depth_m = 0.29; }), "manholes[0].depth_m");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].downstream_offset_m = 1.8; }),
            "manholes[1].depth_m");  // crown at 2.1 m, cover at 2.0 m
}

TEST(Check, DemandsACentreLine) {
  EXPECT_EQ(FieldAfter([](Network& n) { n.manholes[1].p_WM.x() = 0.8; }), "pipes[0].to");
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.pipes[0].bends = {{{5, 0.5}, 0.15}};
            }),
            "pipes[0].bends[0].radius_mm");
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.pipes[0].bends = {{{0.2, 0}, 0.45}};
            }),
            "pipes[0].bends");
}

TEST(Check, KeepsJointsInsideAndInOrder) {
  // The pipe is 9.2 m long between its shafts, a joint 8 mm wide.
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].joints = {{9.198}}; }),
            "pipes[0].joints[0].at_m");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].joints = {{9.195}}; }), "");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].joints = {{0.003}}; }),
            "pipes[0].joints[0].at_m");
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.pipes[0].joints = {{4.0}, {2.0}};
            }),
            "pipes[0].joints[1].at_m");
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.pipes[0].joints = {{4.0}, {4.007}};
            }),
            "pipes[0].joints[1].at_m");
}

TEST(Check, KeepsInletsAndFaultsOnTheWall) {
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].inlets[0].diameter_m = 0.3; }),
            "pipes[0].inlets[0].diameter_mm");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].inlets[0].chainage_m = 9.16; }),
            "pipes[0].inlets[0].at_m");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].inlets[0].clock_h = 0; }),
            "pipes[0].inlets[0].clock");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].faults[0].clock_h = 12.1; }),
            "pipes[0].faults[0].clock");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].faults[0].chainage_m = 9.16; }),
            "pipes[0].faults[0].at_m");
  EXPECT_EQ(FieldAfter([](Network& n) { n.pipes[0].faults[0].width_m = 0.95; }),
            "pipes[0].faults[0].width_mm");  // round the wall it is 0.942 m
}

/// OnePipe with one of everything; joints at 2 and 4 m. @returns as FieldAfter
std::string FieldAmongElements(const std::function<void(Pipe&)>& spoil) {
  return FieldAfter([&](Network& network) {
    Pipe& pipe = network.pipes[0];
    pipe.sags = {{1.0, 5.0, 0.02}};
    pipe.diameter_changes = {{6.0, 0.25}};
    pipe.obstacles = {{"O", ObstacleKind::kBrick, 7.0, 6.0, 0.065, 0.24, 0.115}};
    pipe.water_m = 0.02;
    spoil(pipe);
  });
}

TEST(Check, KeepsDisplacedJointsToWhatAPipeCanBear) {
  const double degree = std::acos(-1.0) / 180;
  EXPECT_EQ(FieldAmongElements([](Pipe&) {}), "");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.joints[0].offset_m = 0.15; }),
            "pipes[0].joints[0].offset_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.joints[0].offset_m = -0.01; }),
            "pipes[0].joints[0].offset_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.joints[0].offset_clock_h = 0; }),
            "pipes[0].joints[0].offset_clock");
  EXPECT_EQ(FieldAmongElements([&](Pipe& p) { p.joints[1].deflection_rad = 10 * degree; }), "");
  EXPECT_EQ(FieldAmongElements([&](Pipe& p) { p.joints[1].deflection_rad = 10.1 * degree; }),
            "pipes[0].joints[1].deflection_deg");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.joints[1].deflection_clock_h = 13; }),
            "pipes[0].joints[1].deflection_clock");
  EXPECT_EQ(FieldAmongElements([&](Pipe& p) {
              p.joints.clear();
              p.sags.clear();
              for (int i = 1; i < 6; ++i) {
                p.joints.push_back({static_cast<double>(i)});
                p.joints.back().deflection_rad = 10 * degree;
              }
            }),
            "pipes[0].joints");  // 5 x 10° one way
}

TEST(Check, WantsSagsBetweenJoints) {
  EXPECT_EQ(FieldAmongElements([](Pipe& p) {
              p.sags[0] = {2.0, 4.0, 0.02};
            }),
            "pipes[0].sags[0].from_m");  // both joints stand at its ends
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.sags[0].depth_m = 0; }),
            "pipes[0].sags[0].depth_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.sags[0].end_m = 0.5; }), "pipes[0].sags[0].to_m");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.sags[0].end_m = 9.3; }), "pipes[0].sags[0].to_m");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) {
              p.sags = {{1.0, 3.5, 0.02}, {3.0, 5.0, 0.02}};
            }),
            "pipes[0].sags[1].from_m");
}

TEST(Check, WantsDiameterChangesInsideAndNotInAGroove) {
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.diameter_changes[0].chainage_m = 4.003; }),
            "pipes[0].diameter_changes[0].at_m");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.diameter_changes[0].chainage_m = 4.005; }), "");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.diameter_changes[0].chainage_m = 0; }),
            "pipes[0].diameter_changes[0].at_m");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.diameter_changes[0].chainage_m = 9.5; }),
            "pipes[0].diameter_changes[0].at_m");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.diameter_changes[0].diameter_m = 0; }),
            "pipes[0].diameter_changes[0].diameter_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) {
              p.diameter_changes.push_back({5.0, 0.2});
            }),
            "pipes[0].diameter_changes[1].at_m");
}

TEST(Check, MeasuresWhatLiesInAPipeByTheDiameterThere) {
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.water_m = 0.25; }), "pipes[0].water_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.water_m = -0.01; }), "pipes[0].water_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.obstacles[0].height_m = 0.25; }),
            "pipes[0].obstacles[0].height_mm");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.inlets[0].diameter_m = 0.26; }), "");
  EXPECT_EQ(FieldAmongElements([](Pipe& p) {
              p.inlets[0].diameter_m = 0.26;
              p.inlets[0].chainage_m = 8.0;
            }),
            "pipes[0].inlets[0].diameter_mm");
}

TEST(Check, KeepsInletsAtAnAngleThatCanBeBuilt) {
  const double degree = std::acos(-1.0) / 180;
  for (const double good : {30.0, 45.0, 90.0, 150.0}) {
    EXPECT_EQ(FieldAmongElements([&](Pipe& p) { p.inlets[0].angle_rad = good * degree; }), "");
  }
  for (const double bad : {29.9, 151.0}) {
    EXPECT_EQ(FieldAmongElements([&](Pipe& p) { p.inlets[0].angle_rad = bad * degree; }),
              "pipes[0].inlets[0].angle_deg");
  }
  EXPECT_EQ(FieldAmongElements([](Pipe& p) { p.inlets[0].protrusion_m = 0.3; }),
            "pipes[0].inlets[0].protrusion_mm");
  // At 30° the mouth of 100 mm is 200 mm long.
  EXPECT_EQ(FieldAmongElements([&](Pipe& p) {
              p.inlets[0].angle_rad = 30 * degree;
              p.inlets[0].chainage_m = 0.09;
            }),
            "pipes[0].inlets[0].at_m");
}

TEST(Check, KnowsTheShapeOfEveryObstacle) {
  const auto after = [](ObstacleKind kind, const std::function<void(Obstacle&)>& spoil) {
    return FieldAmongElements([&](Pipe& p) {
      p.obstacles[0] = {"O", kind, 7.0, 6.0, 0.03, 0.08, 0.08};
      spoil(p.obstacles[0]);
    });
  };
  const std::string at = "pipes[0].obstacles[0].";
  EXPECT_EQ(after(ObstacleKind::kStone, [](Obstacle&) {}), "");
  EXPECT_EQ(after(ObstacleKind::kStone, [](Obstacle& o) { o.height_m = 0.041; }), at + "width_mm");
  EXPECT_EQ(after(ObstacleKind::kStone, [](Obstacle& o) { o.length_m = 0.1; }), at + "length_mm");
  EXPECT_EQ(after(ObstacleKind::kSediment, [](Obstacle&) {}), at + "width_mm");
  EXPECT_EQ(after(ObstacleKind::kSediment, [](Obstacle& o) { o.width_m = 0; }), "");
  EXPECT_EQ(after(ObstacleKind::kSediment,
                  [](Obstacle& o) {
                    o.width_m = 0;
                    o.clock_h = 5;
                  }),
            at + "clock");
  EXPECT_EQ(after(ObstacleKind::kMortarRidge, [](Obstacle& o) { o.width_m = 0; }), "");
  EXPECT_EQ(after(ObstacleKind::kMortarRidge, [](Obstacle& o) { o.width_m = 0.79; }),
            at + "width_mm");  // round the wall of 250 mm it is 0.785 m
  EXPECT_EQ(after(ObstacleKind::kBrick, [](Obstacle& o) { o.width_m = 0; }), at + "width_mm");
  EXPECT_EQ(after(ObstacleKind::kBrick, [](Obstacle& o) { o.length_m = 0; }), at + "length_mm");
  EXPECT_EQ(after(ObstacleKind::kBrick, [](Obstacle& o) { o.chainage_m = 9.19; }), at + "at_m");
  EXPECT_EQ(after(ObstacleKind::kBrick, [](Obstacle& o) { o.clock_h = 0; }), at + "clock");
}

TEST(Check, WantsAGivenBenchBetweenInvertAndCover) {
  const auto after = [](double bench_m) {
    return FieldAfter([&](Network& n) {
      n.manholes[0].bench_height = BenchHeight::kGiven;
      n.manholes[0].given_bench_m = bench_m;
    });
  };
  EXPECT_EQ(after(0.12), "");
  EXPECT_EQ(after(0.0), "manholes[0].bench_height");
  EXPECT_EQ(after(2.0), "manholes[0].bench_height");  // the cover
}

// A channel as wide as the pipe needs walls in the shaft's floor, 50 mm on either side.
TEST(Check, LeavesRoomForBenchingInTheShaft) {
  const auto field_for = [](double more_m) {
    return FieldAfter([&](Network& n) {
      n.manholes[1].shaft_diameter_m = n.pipes[0].diameter_m + more_m;
      n.manholes[1].channel_radius_m.reset();
    });
  };
  EXPECT_EQ(field_for(0.099), "manholes[1].shaft_diameter_mm");
  EXPECT_EQ(field_for(0.100), "");
}

TEST(Check, FitsTheShaftToTheDiameterAtEachEnd) {
  EXPECT_EQ(FieldAfter([](Network& n) {
              n.manholes[1].shaft_diameter_m = 0.45;
              n.pipes[0].diameter_changes = {{6.0, 0.5}};
            }),
            "manholes[1].shaft_diameter_mm");
}

}  // namespace
}  // namespace kantaro::network
