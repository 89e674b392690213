#include "navigation/map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "tests/navigation/sewers.hpp"

namespace kantaro::navigation {
namespace {

using std::numbers::pi;

std::vector<std::string> PipesOf(const MapRoute& route) {
  std::vector<std::string> pipes;
  for (const MapLeg& leg : route.legs) pipes.push_back(leg.pipe);
  return pipes;
}

/// The tee field with an inlet at 9 o'clock at 2 m, one at 3 o'clock at 5 m and a joint at 1.5 m,
/// all in P1.
network::Network Furnished() {
  network::Network network = TeeField();
  network.pipes[0].inlets = {{"at nine", 2.0, 0.1, 9.0}, {"at three", 5.0, 0.1, 3.0}};
  network.pipes[0].joints = {{1.5, 0.008, 0.006}};
  return network;
}

// 8 m from centre to centre, less two shafts' radii of 0.4 m.
TEST(Map, MeasuresALegFromWallToWall) {
  const MapRoute route = MakeRoute(TeeField(), {"A", "B"}, {});
  ASSERT_EQ(route.legs.size(), 2u);
  EXPECT_EQ(route.start_manhole, "A");
  EXPECT_NEAR(route.legs[0].length_m, 7.2, 1e-9);
  EXPECT_DOUBLE_EQ(route.legs[0].diameter_m, 0.3);
  EXPECT_EQ(route.legs[0].end_manhole, "M");
  EXPECT_NEAR(route.legs[0].end_shaft_radius_m, 0.4, 1e-9);
}

TEST(Map, KnowsWhatKindOfManholeALegEndsIn) {
  const MapRoute route = MakeRoute(TeeField(), {"A", "E"}, {});
  ASSERT_EQ(route.legs.size(), 3u);
  EXPECT_EQ(route.legs[0].end_kind, network::ManholeKind::kTee);
  EXPECT_EQ(route.legs[1].end_kind, network::ManholeKind::kStraight);
  EXPECT_EQ(route.legs[2].end_kind, network::ManholeKind::kEnd);
}

// A pipe's map is off as a whole: its length and every landmark on it by the same factor, shafts
// not at all.
TEST(Map, StretchesLengthAndLandmarksByThePipesFactor) {
  const MapRoute route = MakeRoute(Furnished(), {"A", "B"}, {{"P1", 1.05}});
  EXPECT_NEAR(route.legs[0].length_m, 7.2 * 1.05, 1e-9);
  ASSERT_EQ(route.legs[0].landmarks.size(), 3u);
  EXPECT_NEAR(route.legs[0].landmarks[0].distance_m, 1.5 * 1.05, 1e-9);
  EXPECT_NEAR(route.legs[0].landmarks[2].distance_m, 5.0 * 1.05, 1e-9);
  EXPECT_NEAR(route.legs[0].end_shaft_radius_m, 0.4, 1e-9);
  EXPECT_NEAR(route.legs[1].length_m, 7.2, 1e-9) << "the next pipe has its own factor";
}

TEST(Map, SeesInletsAsTheClockSaysDrivenDownstream) {
  const std::vector<MapLandmark> landmarks =
      MakeRoute(Furnished(), {"A", "M"}, {}).legs[0].landmarks;
  ASSERT_EQ(landmarks.size(), 3u);
  EXPECT_EQ(landmarks[0].kind, LandmarkKind::kJoint);
  EXPECT_EQ(landmarks[1].kind, LandmarkKind::kInletLeft);
  EXPECT_EQ(landmarks[2].kind, LandmarkKind::kInletRight);
}

// Driven against the flow the last landmark comes first, at its distance from the other wall, and 9
// o'clock is right.
TEST(Map, MirrorsLandmarksDrivenUpstream) {
  const MapRoute route = MakeRoute(Furnished(), {"M", "A"}, {});
  const std::vector<MapLandmark>& landmarks = route.legs[0].landmarks;
  EXPECT_FALSE(route.legs[0].downstream);
  ASSERT_EQ(landmarks.size(), 3u);
  EXPECT_EQ(landmarks[0].kind, LandmarkKind::kInletLeft);
  EXPECT_NEAR(landmarks[0].distance_m, 7.2 - 5.0, 1e-9);
  EXPECT_EQ(landmarks[1].kind, LandmarkKind::kInletRight);
  EXPECT_NEAR(landmarks[1].distance_m, 7.2 - 2.0, 1e-9);
  EXPECT_EQ(landmarks[2].kind, LandmarkKind::kJoint);
  EXPECT_NEAR(landmarks[2].distance_m, 7.2 - 1.5, 1e-9);
}

// Its mouth shows in the laser's top window, which looks for manholes.
TEST(Map, TakesAnInletAtTheCrownForNoLandmarkOfASide) {
  for (const double clock_h : {12.0, 11.0, 1.0}) {
    network::Network network = Furnished();
    for (network::Inlet& inlet : network.pipes[0].inlets) inlet.clock_h = clock_h;
    EXPECT_EQ(MakeRoute(network, {"A", "M"}, {}).legs[0].landmarks.size(), 1u) << clock_h;
  }
}

TEST(Map, KnowsWhereThePipeGoesStraightOn) {
  EXPECT_TRUE(MakeRoute(TeeField(), {"A", "C"}, {}).legs[0].straight_on) << "to B, not driven";
  EXPECT_FALSE(MakeRoute(TeeField(), {"C", "A"}, {}).legs[0].straight_on) << "the tee's stem";
  EXPECT_FALSE(MakeRoute(Curve(), {"A", "C"}, {}).legs[0].straight_on);
}

// From A eastwards, C lies to the north: left. From E westwards it lies to the right.
TEST(Map, CountsTurnsToTheLeftPositive) {
  EXPECT_NEAR(MakeRoute(TeeField(), {"A", "C"}, {}).legs[0].turn_rad, pi / 2.0, 1e-9);
  EXPECT_NEAR(MakeRoute(TeeField(), {"B", "C"}, {}).legs[0].turn_rad, -pi / 2.0, 1e-9);
  EXPECT_NEAR(MakeRoute(TeeField(), {"C", "A"}, {}).legs[0].turn_rad, -pi / 2.0, 1e-9);
}

TEST(Map, NeedsNoTurnStraightAcrossOrAtTheGoal) {
  const MapRoute route = MakeRoute(TeeField(), {"A", "B"}, {});
  EXPECT_EQ(route.legs[0].turn_rad, 0.0);
  EXPECT_EQ(route.legs[0].channel_radius_m, 0.0);
  EXPECT_EQ(route.legs[1].turn_rad, 0.0);
  EXPECT_NEAR(route.legs[0].ThroughManhole_m(), 0.8, 1e-9) << "the shaft's diameter";
}

// R = 0.4, ρ = 0.66 R = 0.264: straight for R − ρ = 0.136, a quarter of a circle of 0.264 π / 2 =
// 0.4147, straight again.
TEST(Map, LaysTheChannelOfARightAngleThroughTheShaft) {
  const MapLeg leg = MakeRoute(TeeField(), {"A", "C"}, {}).legs[0];
  EXPECT_NEAR(leg.channel_radius_m, 0.264, 1e-9);
  EXPECT_NEAR(leg.StraightBeforeTurn_m(), 0.136, 1e-9);
  EXPECT_NEAR(leg.ThroughManhole_m(), 2.0 * 0.136 + 0.264 * pi / 2.0, 1e-9);
}

TEST(Map, TakesTheChannelRadiusThatTheNetworkGives) {
  network::Network network = TeeField();
  network.manholes[1].channel_radius_m = 0.3;
  EXPECT_NEAR(MakeRoute(network, {"A", "C"}, {}).legs[0].channel_radius_m, 0.3, 1e-9);
}

// A circle tangent to two lines that meet at the centre at 90° and begin 0.4 m from it has a radius
// of at most 0.4 m.
TEST(Map, KeepsTheBendInsideTheShaft) {
  network::Network network = TeeField();
  network.manholes[1].channel_radius_m = 1.0;
  const MapLeg leg = MakeRoute(network, {"A", "C"}, {}).legs[0];
  EXPECT_NEAR(leg.channel_radius_m, 0.4, 1e-9);
  EXPECT_NEAR(leg.StraightBeforeTurn_m(), 0.0, 1e-9);
}

TEST(Map, GoesOverTheManholesInBetween) {
  EXPECT_THAT(PipesOf(MakeRoute(Block(), {"A", "Y"}, {})), testing::ElementsAre("AT", "YT"));
  EXPECT_THAT(PipesOf(MakeRoute(Block(), {"A", "X", "Z", "Y"}, {})),
              testing::ElementsAre("AT", "TX", "XZ", "ZY"));
}

// The way round the block ends in the tee that was passed first.
TEST(Map, MayReachAManholeThatWasPassedBefore) {
  const MapRoute route = MakeRoute(Block(), {"A", "X", "Z", "Y", "T"}, {});
  EXPECT_THAT(PipesOf(route), testing::ElementsAre("AT", "TX", "XZ", "ZY", "YT"));
  EXPECT_EQ(route.legs.front().end_manhole, route.legs.back().end_manhole);
  EXPECT_EQ(route.legs.back().turn_rad, 0.0);
}

TEST(Map, RefusesARouteThatIsNone) {
  network::Network network = TeeField();
  network.pipes[2].diameter_m = 0.1;
  EXPECT_THROW((void)MakeRoute(network, {"A", "C"}, {}), std::invalid_argument)
      << "KANTARO does not fit into 100 mm";
  EXPECT_THROW((void)MakeRoute(TeeField(), {"A"}, {}), std::invalid_argument);
  EXPECT_THROW((void)MakeRoute(TeeField(), {"A", "A"}, {}), std::invalid_argument);
  EXPECT_THROW((void)MakeRoute(TeeField(), {"A", "nowhere"}, {}), std::out_of_range);
}

}  // namespace
}  // namespace kantaro::navigation
