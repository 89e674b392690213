#include "navigation/localiser.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kantaro::navigation {
namespace {

constexpr double kExact = 1e-6;

MapLeg LegOf(double length_m) {
  MapLeg leg;
  leg.length_m = length_m;
  return leg;
}

Parameters SomeErrors() {
  Parameters parameters;
  parameters.gate_deviations = 4.0;
  parameters.map_error = 0.03;
  parameters.travel_error = 0.004;
  parameters.scale_error = 0.01;
  parameters.start_error_m = 0.05;
  return parameters;
}

/// Wheels whose scale is known and a start that is known.
Parameters OnlyTravelError() {
  Parameters parameters = SomeErrors();
  parameters.scale_error = 0.0;
  parameters.start_error_m = 0.0;
  return parameters;
}

TEST(Localiser, StartsWhereTheCrewSetTheRobotDown) {
  const Localiser localiser(LegOf(10.0), 0.6, SomeErrors());
  EXPECT_DOUBLE_EQ(localiser.distance_m(), 0.6);
  EXPECT_DOUBLE_EQ(localiser.deviation_m(), 0.05);
  EXPECT_DOUBLE_EQ(localiser.length_m(), 10.0);
  EXPECT_NEAR(localiser.to_end_deviation_m(), std::hypot(0.05, 0.3), 1e-12);
}

// Slip that changes is a random walk: 0.004 · √25 = 0.02, in however many steps, and backwards too.
TEST(Localiser, GrowsLessSureByTheRootOfTheWay) {
  Localiser localiser(LegOf(30.0), 0.0, OnlyTravelError());
  for (int i = 0; i < 200; ++i) localiser.Advance(0.1);
  EXPECT_NEAR(localiser.deviation_m(), 0.004 * std::sqrt(20.0), 1e-9);
  for (int i = 0; i < 50; ++i) localiser.Advance(-0.1);
  EXPECT_NEAR(localiser.deviation_m(), 0.004 * std::sqrt(25.0), 1e-9);
  EXPECT_NEAR(localiser.distance_m(), 15.0, 1e-9);
}

// A wrong wheel radius is off by the same share all the way, and driving back undoes it.
TEST(Localiser, GrowsLessSureOfAConstantScaleByTheWay) {
  Parameters parameters = SomeErrors();
  parameters.travel_error = parameters.start_error_m = 0.0;
  Localiser localiser(LegOf(10.0), 0.0, parameters);
  localiser.Advance(7.0);
  EXPECT_NEAR(localiser.deviation_m(), 0.01 * 7.0, 1e-9);
  localiser.Advance(-7.0);
  EXPECT_NEAR(localiser.deviation_m(), 0.0, 1e-9);
}

TEST(Localiser, KnowsTheWayToTheEndWallOnceItIsSeen) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  localiser.Advance(8.0);
  EXPECT_TRUE(localiser.SeeEndWall(1.5, kExact));
  EXPECT_NEAR(localiser.to_end_m(), 1.5, 1e-6);
  EXPECT_NEAR(localiser.to_end_deviation_m(), kExact, 1e-7);
}

// Surprised by 0.5 m, the distance (0.05 m unsure) and the length (0.3 m) share it as their
// variances: 1 to 36.
TEST(Localiser, SharesASurpriseByWhatIsLessSure) {
  Parameters parameters = SomeErrors();
  parameters.travel_error = parameters.scale_error = 0.0;
  Localiser localiser(LegOf(10.0), 0.0, parameters);
  localiser.Advance(8.0);
  ASSERT_TRUE(localiser.SeeEndWall(2.5, 0.0));
  EXPECT_NEAR(localiser.distance_m(), 8.0 - 0.5 / 37.0, 1e-9);
  EXPECT_NEAR(localiser.length_m(), 10.0 + 0.5 * 36.0 / 37.0, 1e-9);
}

// Once the way to the end is known, whatever is learned about the distance holds for the length as
// well.
TEST(Localiser, MovesTheEndWithTheDistanceOnceTheWayBetweenIsKnown) {
  Localiser localiser(LegOf(10.0), 5.0, SomeErrors());
  ASSERT_TRUE(localiser.SeeEndWall(5.2, kExact));
  const double length_m = localiser.length_m();
  const double distance_m = localiser.distance_m();
  ASSERT_TRUE(localiser.SeeStartWall(distance_m + 0.06, kExact));
  EXPECT_NEAR(localiser.distance_m(), distance_m + 0.06, 1e-6);
  EXPECT_NEAR(localiser.length_m(), length_m + 0.06, 1e-6);
  EXPECT_NEAR(localiser.to_end_m(), 5.2, 1e-5);
}

// 3 % of 10 m and 0.05 m make 0.304 m: 4 deviations are 1.217 m.
TEST(Localiser, BelievesNoWallBeyondTheGate) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  EXPECT_FALSE(localiser.SeeEndWall(10.0 - 1.22, kExact));
  EXPECT_FALSE(localiser.SeeEndWall(10.0 + 1.22, kExact));
  EXPECT_DOUBLE_EQ(localiser.distance_m(), 0.0);
  EXPECT_DOUBLE_EQ(localiser.length_m(), 10.0);
  EXPECT_DOUBLE_EQ(localiser.deviation_m(), 0.05);
  EXPECT_TRUE(localiser.SeeEndWall(10.0 - 1.21, kExact));
}

TEST(Localiser, BelievesNoStartWallBeyondTheGate) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  EXPECT_FALSE(localiser.SeeStartWall(0.21, kExact));
  EXPECT_TRUE(localiser.SeeStartWall(0.19, kExact));
}

// The map has 10.5 m and an inlet at 6.3 m where 10 m and 6 m are true: the inlet tells how long
// the pipe is.
TEST(Localiser, LearnsTheTrueLengthFromALandmarkOnTheWay) {
  Parameters parameters = OnlyTravelError();
  parameters.travel_error = 0.0;
  Localiser localiser(LegOf(10.5), 0.0, parameters);
  localiser.Advance(5.0);
  EXPECT_TRUE(localiser.SeeLandmark(6.3, 1.0, kExact));
  EXPECT_NEAR(localiser.length_m(), 10.0, 1e-5);
  EXPECT_NEAR(localiser.distance_m(), 5.0, 1e-6);
}

// Halfway, half of the length's 0.3 m counts; once the way to a landmark is known, that to another
// of the same pipe is not.
TEST(Localiser, KnowsHowSureItIsOfTheWayToALandmark) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  EXPECT_NEAR(localiser.to_landmark_deviation_m(5.0), std::hypot(0.05, 0.15), 1e-12);
  EXPECT_NEAR(localiser.to_landmark_deviation_m(0.0), 0.05, 1e-12);
  ASSERT_TRUE(localiser.SeeLandmark(5.0, 5.0, kExact));
  EXPECT_NEAR(localiser.to_landmark_deviation_m(5.0), kExact, 1e-7);
  EXPECT_GT(localiser.to_landmark_deviation_m(10.0), 0.04);
}

// ... and with the length known, one tells where the robot is.
TEST(Localiser, FindsItselfByALandmark) {
  Parameters parameters = SomeErrors();
  parameters.map_error = 0.0;
  Localiser localiser(LegOf(10.0), 5.0, parameters);
  EXPECT_TRUE(localiser.SeeLandmark(6.0, 1.1, kExact));
  EXPECT_NEAR(localiser.distance_m(), 4.9, 1e-6);
  EXPECT_FALSE(localiser.SeeLandmark(6.0, 1.3, kExact)) << "that is another landmark";
}

TEST(Localiser, DrivesOnByTheScaleItLearned) {
  Localiser localiser(LegOf(10.0), 1.0, SomeErrors());
  localiser.SeeScale(0.95, kExact);
  EXPECT_NEAR(localiser.scale(), 0.95, 1e-6);
  localiser.Advance(2.0);
  EXPECT_NEAR(localiser.distance_m(), 1.0 + 1.9, 1e-6);
}

// As sure of 1 (± 0.01) as of what was measured: halfway.
TEST(Localiser, WeighsAScaleByItsDeviation) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  localiser.SeeScale(0.96, 0.01);
  EXPECT_NEAR(localiser.scale(), 0.98, 1e-9);
}

// From 0 to 4 m by the wheels, in truth 3.92 m: the start wall passed late tells that the wheels
// slip by 2 %.
TEST(Localiser, LearnsTheScaleFromAWallAfterALongWay) {
  Parameters parameters = OnlyTravelError();
  parameters.travel_error = 0.0;
  parameters.scale_error = 0.05;
  Localiser localiser(LegOf(10.0), 0.0, parameters);
  localiser.Advance(4.0);
  ASSERT_TRUE(localiser.SeeStartWall(3.92, kExact));
  EXPECT_NEAR(localiser.scale(), 0.98, 1e-6);
}

TEST(Localiser, BeginsALegAfreshButKeepsTheScale) {
  Localiser localiser(LegOf(10.0), 0.0, SomeErrors());
  localiser.SeeScale(0.97, kExact);
  localiser.Advance(9.0);
  ASSERT_TRUE(localiser.SeeEndWall(1.2, kExact));
  localiser.Begin(LegOf(20.0), -0.3, 0.1);
  EXPECT_DOUBLE_EQ(localiser.distance_m(), -0.3);
  EXPECT_DOUBLE_EQ(localiser.deviation_m(), 0.1);
  EXPECT_DOUBLE_EQ(localiser.length_m(), 20.0);
  EXPECT_NEAR(localiser.to_end_deviation_m(), std::hypot(0.1, 0.6), 1e-9);
  EXPECT_NEAR(localiser.scale(), 0.97, 1e-6);
}

}  // namespace
}  // namespace kantaro::navigation
