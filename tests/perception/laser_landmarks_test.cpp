#include "perception/laser_landmarks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace kantaro::perception {
namespace {

using robot::RangeStatus;
using std::numbers::pi;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where a wall is: range by angle, 0 right, counterclockwise.
struct Walls {
  double pipe_radius_m{0.150};
  double height_m{};            ///< of the laser over the pipe's axis
  double roll_rad{};            ///< of the robot
  bool top{}, left{}, right{};  ///< opened to a shaft of 0.4 m, or an inlet without end
};

double DistanceToWall(const Walls& walls, double angle_rad) {
  const double a = angle_rad + walls.roll_rad;
  // Solves |(0, h) + t (cos a, sin a)| = R.
  const double b = walls.height_m * std::sin(a);
  const double pipe_m = -b + std::sqrt(b * b + walls.pipe_radius_m * walls.pipe_radius_m -
                                       walls.height_m * walls.height_m);
  const double x = pipe_m * std::cos(a), y = walls.height_m + pipe_m * std::sin(a);
  const auto within = [](double p, double half) { return std::abs(p) < half; };
  if (walls.top && y > 0 && within(x, 0.06)) return 1.5;
  if (walls.left && x < 0 && within(y, 0.05)) return kInfinity;
  if (walls.right && x > 0 && within(y, 0.05)) return kInfinity;
  return pipe_m;
}

/// A noiseless revolution of 336 beams over 70 to 190 mm, from the first angle on.
robot::LaserRevolution Scan(const Walls& walls, double first_rad = 0.001) {
  robot::LaserRevolution revolution;
  for (int i = 0; i < 336; ++i) {
    robot::LaserSample sample;
    sample.angle_rad = std::fmod(first_rad + 2 * pi * i / 336, 2 * pi);
    const double range_m = DistanceToWall(walls, sample.angle_rad);
    sample.range_m = std::clamp(range_m, 0.070, 0.190);
    sample.status = range_m < 0.070   ? RangeStatus::kTooNear
                    : range_m > 0.190 ? RangeStatus::kTooFar
                                      : RangeStatus::kValid;
    revolution.samples.push_back(sample);
  }
  return revolution;
}

LaserObservation Read(const Walls& walls) {
  const auto observation = ReadWindows(Scan(walls), std::chrono::seconds(7), {});
  EXPECT_TRUE(observation.has_value());
  return observation.value_or(LaserObservation{});
}

TEST(LaserLandmarks, SeeNoLandmarkInAPlainPipe) {
  const LaserObservation seen = Read({});
  EXPECT_EQ(seen.status, LaserStatus::kNoLandmark);
  EXPECT_FALSE(seen.top_open || seen.left_open || seen.right_open);
  EXPECT_NEAR(seen.top_m, 0.150, 1e-9);
  EXPECT_NEAR(seen.left_m, 0.150, 1e-9);
  EXPECT_NEAR(seen.right_m, 0.150, 1e-9);
  EXPECT_EQ(seen.captured_at, std::chrono::seconds(7));
}

TEST(LaserLandmarks, FollowTable53) {
  EXPECT_EQ(Read({.top = true}).status, LaserStatus::kManhole);
  EXPECT_EQ(Read({.left = true}).status, LaserStatus::kInletLeft);
  EXPECT_EQ(Read({.right = true}).status, LaserStatus::kInletRight);
  EXPECT_EQ(Read({.top = true, .left = true}).status, LaserStatus::kManholeWithJunction);
  EXPECT_EQ(Read({.top = true, .right = true}).status, LaserStatus::kManholeWithJunction);
  EXPECT_EQ(Read({.top = true, .left = true, .right = true}).status, LaserStatus::kOutsideThePipe);
}

TEST(LaserLandmarks, ReadTwoOpenSidesUnderACrownAsTheWiderInlet) {
  EXPECT_EQ(ClassifyWindows(false, true, true, 0.180, 0.185), LaserStatus::kInletRight);
  EXPECT_EQ(ClassifyWindows(false, true, true, 0.185, 0.180), LaserStatus::kInletLeft);
  EXPECT_EQ(ClassifyWindows(false, true, true, 0.190, 0.190), LaserStatus::kInletLeft);
}

TEST(LaserLandmarks, ReportTheFarLimitWhereNothingReturned) {
  EXPECT_DOUBLE_EQ(Read({.top = true}).top_m, 0.190);
}

TEST(LaserLandmarks, AreTheSameWithTheRobotRolledThreeDegrees) {
  const double roll_rad = 3 * pi / 180;
  EXPECT_EQ(Read({.roll_rad = roll_rad}).status, LaserStatus::kNoLandmark);
  EXPECT_EQ(Read({.roll_rad = -roll_rad, .top = true}).status, LaserStatus::kManhole);
  EXPECT_EQ(Read({.roll_rad = roll_rad, .left = true}).status, LaserStatus::kInletLeft);
}

// 20 mm above the axis of a 300 mm pipe: 130 mm to the crown, √(150² − 20²) = 148.7 mm to the
// sides.
TEST(LaserLandmarks, MeasureFromTheLasersOwnHeight) {
  const LaserObservation seen = Read({.height_m = 0.020});
  EXPECT_NEAR(seen.top_m, 0.130, 0.0002);
  EXPECT_NEAR(seen.right_m, 0.1487, 0.0006);  // the window is 15° wide
}

TEST(LaserLandmarks, CollectTheRightWindowFromBothEndsOfTheRevolution) {
  robot::LaserRevolution revolution = Scan({});
  const auto open = [&](double from_rad, double to_rad) {
    for (auto& sample : revolution.samples) {
      if (sample.angle_rad > from_rad && sample.angle_rad < to_rad) {
        sample.range_m = 0.190;
        sample.status = RangeStatus::kTooFar;
      }
    }
  };
  open(0, 0.1);  // less than half of the window
  EXPECT_FALSE(ReadWindows(revolution, {}, {})->right_open);
  open(2 * pi - 0.1, 2 * pi);  // more than half, from both ends
  EXPECT_TRUE(ReadWindows(revolution, {}, {})->right_open);
}

TEST(LaserLandmarks, TakeTooNearBeamsAsClosed) {
  robot::LaserRevolution revolution = Scan({});
  for (auto& sample : revolution.samples) {
    sample.range_m = 0.070;
    sample.status = RangeStatus::kTooNear;
  }
  const auto seen = ReadWindows(revolution, {}, {});
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->status, LaserStatus::kNoLandmark);
}

TEST(LaserLandmarks, OutvoteAFewStrayBeams) {
  robot::LaserRevolution revolution = Scan({});
  int strays = 0;
  for (auto& sample : revolution.samples) {
    if (std::abs(sample.angle_rad - pi / 2) < 0.13 && strays++ < 5)
      sample.status = RangeStatus::kTooFar;
  }
  EXPECT_FALSE(ReadWindows(revolution, {}, {})->top_open);
}

TEST(LaserLandmarks, SayNothingWithoutSamplesInAWindow) {
  EXPECT_FALSE(ReadWindows({}, {}, {}));
  robot::LaserRevolution revolution = Scan({});
  std::erase_if(revolution.samples,
                [](const auto& sample) { return std::abs(sample.angle_rad - pi) < 0.2; });
  EXPECT_FALSE(ReadWindows(revolution, {}, {}));
}

TEST(LaserLandmarks, DoNotCallExactlyTheThresholdOpen) {
  EXPECT_FALSE(Read({.pipe_radius_m = 0.175 - 1e-9}).top_open);
  EXPECT_TRUE(Read({.pipe_radius_m = 0.176}).top_open);
}

/// Read by beams against the circle of the wall, as it was before the landmark.
LaserObservation ReadOurs(const Walls& walls, const robot::LaserRevolution& revolution) {
  Walls before = walls;
  before.top = before.left = before.right = false;
  LaserParameters parameters;
  parameters.method = LaserMethod::kOurs;
  return ReadWindows(revolution, {}, parameters, FitPipeSlice(Scan(before)))
      .value_or(LaserObservation{});
}
LaserObservation ReadOurs(const Walls& walls) { return ReadOurs(walls, Scan(walls)); }

/// The same in a channel that reaches the crown, under a shaft: upright walls above the axis.
robot::LaserRevolution ScanChannel(double radius_m, bool left = false) {
  robot::LaserRevolution revolution = Scan({.pipe_radius_m = radius_m});
  for (robot::LaserSample& sample : revolution.samples) {
    const double up = std::sin(sample.angle_rad), right = std::cos(sample.angle_rad);
    if (up > 0) sample.range_m = radius_m / std::max(1e-9, std::abs(right));
    if (left && right < -0.5 && up > -0.9) sample.range_m = 1.0;
    sample.status = sample.range_m > 0.190 ? RangeStatus::kTooFar : RangeStatus::kValid;
    sample.range_m = std::min(sample.range_m, 0.190);
  }
  return revolution;
}

// Table 5.3's threshold calls the wall of a 350 mm pipe open as soon as the scanner is off the
// axis.
TEST(OurLaserLandmarks, SeeNoLandmarkInAPipeAsWideAsTheThreshold) {
  const Walls askew{.pipe_radius_m = 0.175, .height_m = -0.010};
  EXPECT_EQ(Read(askew).status, LaserStatus::kManhole);
  EXPECT_EQ(ReadOurs(askew).status, LaserStatus::kNoLandmark);
}

// Out of the scanner's reach there is no evidence.
TEST(OurLaserLandmarks, DoNotTakeACrownOutOfReachForAShaft) {
  const Walls low{.pipe_radius_m = 0.175, .height_m = -0.020};
  EXPECT_EQ(Read(low).status, LaserStatus::kManhole);
  EXPECT_EQ(ReadOurs(low).status, LaserStatus::kNoLandmark);
}

TEST(OurLaserLandmarks, FindInletsInEveryPipe) {
  for (const double radius_m : {0.100, 0.125, 0.150, 0.175}) {
    EXPECT_EQ(ReadOurs({.pipe_radius_m = radius_m, .left = true}).status, LaserStatus::kInletLeft);
    EXPECT_EQ(ReadOurs({.pipe_radius_m = radius_m, .right = true}).status,
              LaserStatus::kInletRight);
  }
}

// An inlet 20° above the side leaves more than half of the thesis' window to the wall.
TEST(OurLaserLandmarks, FindAnInletThatIsNotLevel) {
  const Walls rolled{.roll_rad = 22 * pi / 180, .left = true};
  EXPECT_EQ(Read(rolled).status, LaserStatus::kNoLandmark);
  EXPECT_EQ(ReadOurs(rolled).status, LaserStatus::kInletLeft);
}

TEST(OurLaserLandmarks, TellAnInletAtTheCrownFromAManhole) {
  EXPECT_EQ(Read({.top = true}).status, LaserStatus::kManhole);  // 120 mm wide in 300 mm
  EXPECT_EQ(ReadOurs({.top = true}).status, LaserStatus::kNoLandmark);
}

TEST(OurLaserLandmarks, FindManholesAndTheirBranchesInEveryPipe) {
  for (const double radius_m : {0.100, 0.125, 0.150, 0.175}) {
    const Walls pipe{.pipe_radius_m = radius_m};
    EXPECT_EQ(ReadOurs(pipe, ScanChannel(radius_m)).status, LaserStatus::kManhole);
    EXPECT_EQ(ReadOurs(pipe, ScanChannel(radius_m, true)).status,
              LaserStatus::kManholeWithJunction);
  }
}

LaserObservation At(int ms, bool top, bool left = false) {
  LaserObservation observation;
  observation.captured_at = std::chrono::milliseconds(ms);
  observation.top_open = top;
  observation.left_open = left;
  return observation;
}

// The circle's middle is known to 2 mm only, and the wall 5 mm before the scanner's reach.
TEST(OurLaserLandmarks, DoNotKnowWhereTheWallMayBeOutOfReach) {
  LaserParameters parameters;
  parameters.method = LaserMethod::kOurs;
  const robot::LaserRevolution open_left = Scan({.pipe_radius_m = 0.175, .left = true});
  PipeSlice wall{-0.010, 0.0, 0.175, 1.0};
  EXPECT_TRUE(ReadWindows(open_left, {}, parameters, wall)->left_open);
  wall.covariance_m2(0, 0) = 0.002 * 0.002;
  const auto unsure = ReadWindows(open_left, {}, parameters, wall);
  EXPECT_FALSE(unsure->left_known);
  EXPECT_TRUE(unsure->right_known);
  EXPECT_FALSE(unsure->right_open);
}

TEST(LaserTracker, KeepsAWindowThatIsNotKnown) {
  LaserTracker tracker(1);
  EXPECT_EQ(tracker.Update(At(0, true)).size(), 1U);
  LaserObservation unknown = At(33, false);
  unknown.top_known = false;
  EXPECT_TRUE(tracker.Update(unknown).empty());
  EXPECT_TRUE(tracker.IsOpen(LaserWindow::kTop));
}

TEST(LaserTracker, ReportsTheFirstRevolutionOfTheRunThatOpenedAWindow) {
  LaserTracker tracker(3);
  EXPECT_TRUE(tracker.Update(At(0, false)).empty());
  EXPECT_TRUE(tracker.Update(At(33, true)).empty());
  EXPECT_TRUE(tracker.Update(At(66, true)).empty());
  EXPECT_FALSE(tracker.IsOpen(LaserWindow::kTop));
  const auto edges = tracker.Update(At(100, true));
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].window, LaserWindow::kTop);
  EXPECT_TRUE(edges[0].open);
  EXPECT_EQ(edges[0].at, std::chrono::milliseconds(33));
  EXPECT_TRUE(tracker.IsOpen(LaserWindow::kTop));
  EXPECT_TRUE(tracker.Update(At(133, true)).empty());
}

TEST(LaserTracker, StartsTheRunAnewAfterOneRevolutionThatDisagrees) {
  LaserTracker tracker(2);
  EXPECT_TRUE(tracker.Update(At(0, true)).empty());
  EXPECT_TRUE(tracker.Update(At(33, false)).empty());
  EXPECT_TRUE(tracker.Update(At(66, true)).empty());
  EXPECT_EQ(tracker.Update(At(100, true)).at(0).at, std::chrono::milliseconds(66));
}

TEST(LaserTracker, ReportsClosingLikeOpening) {
  LaserTracker tracker(1);
  EXPECT_EQ(tracker.Update(At(0, true)).size(), 1U);
  const auto edges = tracker.Update(At(33, false));
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_FALSE(edges[0].open);
  EXPECT_FALSE(tracker.IsOpen(LaserWindow::kTop));
}

TEST(LaserTracker, KeepsItsWindowsApart) {
  LaserTracker tracker(2);
  EXPECT_TRUE(tracker.Update(At(0, true, false)).empty());
  EXPECT_EQ(tracker.Update(At(33, true, true)).at(0).window, LaserWindow::kTop);
  const auto edges = tracker.Update(At(66, true, true));
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].window, LaserWindow::kLeft);
  EXPECT_EQ(edges[0].at, std::chrono::milliseconds(33));
}

// The mirror looks up a quarter after the turn's begin, so three quarters before its end; the edge
// passed between two such looks. The left is seen at half a turn.
TEST(LaserTracker, DatesAnEdgeWithinTheTurn) {
  LaserTracker tracker(1, std::chrono::milliseconds(40));
  const auto edges = tracker.Update(At(1000, true, true));
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_EQ(edges[0].window, LaserWindow::kTop);
  EXPECT_EQ(edges[0].at, std::chrono::milliseconds(1000 - 30 - 20));
  EXPECT_EQ(edges[1].window, LaserWindow::kLeft);
  EXPECT_EQ(edges[1].at, std::chrono::milliseconds(1000 - 20 - 20));
}

TEST(LaserTracker, NeedsAtLeastOneRevolution) {
  EXPECT_THROW(LaserTracker(0), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
