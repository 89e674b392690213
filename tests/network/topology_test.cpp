#include "network/topology.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

/// `arms` pipes meeting in "M" at the origin, 10 m long, at these headings [°].
Network Star(const std::vector<double>& headings) {
  Network network;
  network.manholes.push_back(ManholeAt("M", 0, 0));
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const double heading = headings[i] * std::numbers::pi / 180;
    const std::string end = "E" + std::to_string(i);
    network.manholes.push_back(ManholeAt(end, 10 * std::cos(heading), 10 * std::sin(heading)));
    network.pipes.push_back(PipeFrom("P" + std::to_string(i), "M", end));
  }
  return network;
}

ManholeKind KindOfStar(const std::vector<double>& headings) {
  const Network network = Star(headings);
  const ManholeKind kind = KindOf(network, network.manholes[0]);
  EXPECT_EQ(KindOf(network, NetworkIndex(network), 0), kind);
  return kind;
}

/// A, B, C, D in a row 10 m apart; A–B and C–D of 300 mm, B–C of 500 mm, and a way round over X.
Network Row() {
  Network network;
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("B", 10, 0), ManholeAt("C", 20, 0),
                      ManholeAt("D", 30, 0), ManholeAt("X", 15, 5)};
  network.pipes = {PipeFrom("AB", "A", "B"), PipeFrom("BC", "B", "C", 0.5),
                   PipeFrom("DC", "D", "C"), PipeFrom("BX", "B", "X"), PipeFrom("XC", "X", "C")};
  return network;
}

TEST(ManholeKind, FollowsFromThePipesThatMeet) {
  EXPECT_EQ(KindOfStar({}), ManholeKind::kOther);
  EXPECT_EQ(KindOfStar({0}), ManholeKind::kEnd);
  EXPECT_EQ(KindOfStar({0, 180}), ManholeKind::kStraight);
  EXPECT_EQ(KindOfStar({0, 166}), ManholeKind::kStraight);
  EXPECT_EQ(KindOfStar({0, 164}), ManholeKind::kCurve);
  EXPECT_EQ(KindOfStar({0, 90}), ManholeKind::kCurve);
  EXPECT_EQ(KindOfStar({0, 90, 180}), ManholeKind::kTee);
  EXPECT_EQ(KindOfStar({0, 166, 270}), ManholeKind::kTee);
  EXPECT_EQ(KindOfStar({61, 180, 0}), ManholeKind::kTee);  // 29° off square
  EXPECT_EQ(KindOfStar({59, 180, 0}), ManholeKind::kWye);
  EXPECT_EQ(KindOfStar({0, 135, 180}), ManholeKind::kWye);
  EXPECT_EQ(KindOfStar({0, 120, 240}), ManholeKind::kWye);
  EXPECT_EQ(KindOfStar({0, 90, 164}), ManholeKind::kWye);  // no two run straight through
  EXPECT_EQ(KindOfStar({0, 90, 180, 270}), ManholeKind::kCross);
  EXPECT_EQ(KindOfStar({0, 90, 180, 270, 300}), ManholeKind::kOther);
}

TEST(DirectionFrom, PointsAlongTheFirstLegFromEitherEnd) {
  Network network = OnePipe();
  network.pipes[0].bends = {{{5, 5}, 0.5}};
  const double half = std::sqrt(0.5);
  const auto from_a = DirectionFrom(network, network.pipes[0], network.manholes[0]);
  const auto from_b = DirectionFrom(network, network.pipes[0], network.manholes[1]);
  EXPECT_NEAR(from_a.x(), half, 1e-12);
  EXPECT_NEAR(from_b.x(), -half, 1e-12);
  EXPECT_NEAR(from_b.y(), half, 1e-12);
}

TEST(ShortestRoute, GoesRoundPipesTheRobotCannotEnter) {
  const std::vector<RouteLeg> route = ShortestRoute(Row(), {"A", "D"});
  ASSERT_EQ(route.size(), 4u);
  EXPECT_EQ(route[0].pipe, "AB");
  EXPECT_EQ(route[1].pipe, "BX");
  EXPECT_EQ(route[2].pipe, "XC");
  EXPECT_EQ(route[3].pipe, "DC");
  EXPECT_TRUE(route[2].downstream);
  EXPECT_FALSE(route[3].downstream);
}

TEST(ShortestRoute, PrefersTheShorterWay) {
  Network network = Row();
  network.pipes[1].diameter_m = 0.3;
  const std::vector<RouteLeg> route = ShortestRoute(network, {"A", "C"});
  ASSERT_EQ(route.size(), 2u);
  EXPECT_EQ(route[1].pipe, "BC");
}

std::vector<std::string> PipesOf(const std::vector<RouteLeg>& route) {
  std::vector<std::string> pipes;
  for (const RouteLeg& leg : route) pipes.push_back(leg.pipe);
  return pipes;
}

using Pipes = std::vector<std::string>;

TEST(ShortestRoute, PassesManholesInOrder) {
  EXPECT_EQ(PipesOf(ShortestRoute(Row(), {"A", "X", "X", "C", "D"})),
            (Pipes{"AB", "BX", "XC", "DC"}));
  EXPECT_TRUE(ShortestRoute(Row(), {"A", "X", "A"}).empty());  // it cannot turn round in X ...
  EXPECT_EQ(PipesOf(ShortestRoute(Row(), {"A", "X", "A"}, Turns::kAny)),
            (Pipes{"AB", "BX", "BX", "AB"}));
}

// From E0 heading 180° to M; E1 lies 125° off the way, E2 90° off.
TEST(ShortestRoute, TurnsByNoMoreThan120Degrees) {
  const Network sharp = Star({0, 55, 90});
  EXPECT_TRUE(ShortestRoute(sharp, {"E0", "E1"}).empty());
  EXPECT_EQ(ShortestRoute(sharp, {"E0", "E2"}).size(), 2u);
  EXPECT_EQ(ShortestRoute(sharp, {"E0", "E1"}, Turns::kAny).size(), 2u);
  EXPECT_EQ(ShortestRoute(Star({0, 60}), {"E0", "E1"}).size(), 2u);  // 120°
  EXPECT_EQ(ShortestRoute(Star({0, 60}), {"E1", "E0"}).size(), 2u);
}

// A triangle hangs at the end of a street: one way round it and back.
TEST(ShortestRoute, TakesADetourToTurnRound) {
  Network network;
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("B", 10, 0), ManholeAt("C", 20, 10),
                      ManholeAt("D", 20, -10)};
  network.pipes = {PipeFrom("AB", "A", "B"), PipeFrom("BC", "B", "C"), PipeFrom("CD", "C", "D"),
                   PipeFrom("DB", "D", "B")};
  EXPECT_TRUE(ShortestRoute(network, {"A", "B", "A"}).empty());  // 135° in C and D
  const double far_m = 10 + 10 * std::sqrt(3.0);                 // equal sides: 120°
  network.manholes[2].p_WM.x() = network.manholes[3].p_WM.x() = far_m;
  EXPECT_EQ(ShortestRoute(network, {"A", "B", "A"}).size(), 5u);
}

TEST(TurnInto, IsPositiveToTheLeft) {
  const Network network = Star({180, 90, -45});
  const auto turn = [&](std::size_t to) {
    return TurnInto(network, network.manholes[0], network.pipes[0], network.pipes[to]) * 180 /
           std::numbers::pi;
  };
  EXPECT_NEAR(turn(1), 90, 1e-9);
  EXPECT_NEAR(turn(2), -45, 1e-9);
}

TEST(ShortestRoute, IsEmptyWithoutAWayAndThrowsForStrangers) {
  Network network = Row();
  EXPECT_TRUE(ShortestRoute(network, {"A", "A"}).empty());
  network.pipes.pop_back();
  EXPECT_TRUE(ShortestRoute(network, {"A", "D"}).empty());
  EXPECT_THROW((void)ShortestRoute(network, {"A", "Z"}), std::out_of_range);
}

TEST(Neighbourhood, KeepsEveryPipeThatBeginsWithinReach) {
  Network network = Row();
  network.skipped = {{"weir", "A", "B", "a weir"}, {"pump", "C", "D", "a pump"}};
  const Network part = Neighbourhood(network, {"A"}, 10.5);  // B is 10 m away, C 20 m
  ASSERT_EQ(part.pipes.size(), 3u);
  EXPECT_TRUE(part.FindPipe("AB") && part.FindPipe("BC") && part.FindPipe("BX"));
  EXPECT_EQ(part.manholes.size(), 4u);
  EXPECT_FALSE(part.FindManhole("D"));
  ASSERT_EQ(part.skipped.size(), 1u);
  EXPECT_EQ(part.skipped[0].name, "weir");
}

TEST(Neighbourhood, KeepsEverythingInItsPipesAndManholes) {
  const Network whole = RandomSewer(7);
  const Network part = Neighbourhood(whole, {"M1"}, 1.0);
  ASSERT_EQ(part.pipes.size(), 2u);
  EXPECT_TRUE(part.pipes[0] == whole.pipes[0] && part.pipes[1] == whole.pipes[1]);
  ASSERT_EQ(part.manholes.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    Manhole manhole = whole.manholes[i];
    manhole.shaft_diameter_m = whole.ShaftDiameter(manhole);
    EXPECT_TRUE(part.manholes[i] == manhole);
  }
}

TEST(Neighbourhood, LeavesShaftsAsWideAsInTheWhole) {
  const Network part =
      Neighbourhood(Row(), {"X"}, 1.0);  // C keeps BX and XC, loses the 500 mm pipe
  ASSERT_FALSE(part.FindPipe("BC"));
  EXPECT_DOUBLE_EQ(part.ShaftDiameter(part.ManholeNamed("C")), 1.0);
}

TEST(Neighbourhood, KeepsAManholeWithoutPipes) {
  Network network = Row();
  network.manholes.push_back(ManholeAt("lonely", 90, 90));
  const Network part = Neighbourhood(network, {"lonely"}, 5.0);
  EXPECT_EQ(part.manholes.size(), 1u);
  EXPECT_TRUE(part.pipes.empty());
}

}  // namespace
}  // namespace kantaro::network
