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

}  // namespace
}  // namespace kantaro::network
