#include "perception/pipe_slice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace kantaro::perception {
namespace {

using robot::RangeStatus;
using std::numbers::pi;

/// 336 beams over 70 to 190 mm whose range a function gives; a millimetre of error, up and down.
robot::LaserRevolution Scan(const std::function<double(double angle_rad)>& range,
                            double error_m = 0.0) {
  robot::LaserRevolution revolution;
  for (int i = 0; i < 336; ++i) {
    const double angle_rad = 2 * pi * i / 336;
    const double range_m = range(angle_rad) + (i % 2 == 0 ? error_m : -error_m);
    const auto status = range_m < 0.070   ? RangeStatus::kTooNear
                        : range_m > 0.190 ? RangeStatus::kTooFar
                                          : RangeStatus::kValid;
    revolution.samples.push_back({angle_rad, std::clamp(range_m, 0.070, 0.190), status});
  }
  return revolution;
}

/// Range to a circle whose middle lies at (right, up) of the scanner: the farther root of
/// |t u − m| = r.
double ToCircle(double right_m, double up_m, double radius_m, double angle_rad) {
  const double towards = right_m * std::cos(angle_rad) + up_m * std::sin(angle_rad);
  const double across = right_m * std::sin(angle_rad) - up_m * std::cos(angle_rad);
  return towards + std::sqrt(radius_m * radius_m - across * across);
}

bool Above(double angle_rad, double degrees) {
  return std::sin(angle_rad) > std::sin(degrees * pi / 180);
}

TEST(PipeSlice, FindsTheCircleOffItsMiddle) {
  const auto slice =
      FitPipeSlice(Scan([](double a) { return ToCircle(0.012, -0.016, 0.150, a); }, 0.001));
  ASSERT_TRUE(slice);
  EXPECT_NEAR(slice->right_m, 0.012, 0.0002);
  EXPECT_NEAR(slice->up_m, -0.016, 0.0002);
  EXPECT_NEAR(slice->radius_m, 0.150, 0.0002);
  EXPECT_EQ(slice->wall_share, 1.0);
  EXPECT_NEAR(slice->RangeAt(1.0), ToCircle(0.012, -0.016, 0.150, 1.0), 0.0003);
}

// A channel: round below the axis, upright walls above, nothing overhead.
TEST(PipeSlice, BelievesTheChannelUnderAnOpenShaft) {
  const auto slice = FitPipeSlice(Scan([](double a) {
    if (!Above(a, 0)) return 0.150;
    return 0.150 / std::max(1e-9, std::abs(std::cos(a)));
  }));
  ASSERT_TRUE(slice);
  EXPECT_NEAR(slice->radius_m, 0.150, 0.001);
  EXPECT_NEAR(slice->up_m, 0.0, 0.0015);
}

// Sediment lies 10 mm deep along the invert, and a side inlet is open.
TEST(PipeSlice, LeavesOutWhatIsNotTheWall) {
  const auto slice = FitPipeSlice(Scan([](double a) {
    if (std::abs(std::remainder(a - pi, 2 * pi)) < 0.3) return 1.0;
    if (std::abs(std::remainder(a + pi / 2, 2 * pi)) < 0.25) return 0.115 / -std::sin(a);
    return 0.125;
  }));
  ASSERT_TRUE(slice);
  EXPECT_NEAR(slice->radius_m, 0.125, 0.001);
  EXPECT_NEAR(slice->right_m, 0.0, 0.001);
}

TEST(PipeSlice, IsAbsentWhereThereIsNoPipe) {
  EXPECT_FALSE(FitPipeSlice({}));
  EXPECT_FALSE(FitPipeSlice(Scan([](double) { return 1.0; })));
  // A flat floor 100 mm below is no circle of any pipe.
  EXPECT_FALSE(FitPipeSlice(Scan([](double a) { return a > pi ? 0.100 / -std::sin(a) : 1.0; })));
}

double Held(PipeSliceTracker& tracker, double radius_m) {
  const auto& held = tracker.Update(Scan([&](double a) { return ToCircle(0, 0, radius_m, a); }));
  return held ? held->radius_m : 0.0;
}

TEST(PipeSliceTracker, HoldsThePipeThroughALandmark) {
  PipeSliceTracker tracker(30);
  EXPECT_FALSE(tracker.Update({}));
  EXPECT_NEAR(Held(tracker, 0.150), 0.150, 1e-6);
  const auto& in_shaft = tracker.Update(Scan([](double) { return 1.0; }));
  ASSERT_TRUE(in_shaft);
  EXPECT_NEAR(in_shaft->radius_m, 0.150, 1e-6);
}

// In a tee the robot leans 20 mm towards the branch: left and above
// all is open, and of the pipe only the lower right is left.
TEST(PipeSliceTracker, FollowsTheRobotSwayingInABranch) {
  PipeSliceTracker tracker(30);
  EXPECT_NEAR(Held(tracker, 0.150), 0.150, 1e-6);
  for (double sway_m = 0.0; sway_m <= 0.020; sway_m += 0.002) {
    (void)tracker.Update(
        Scan([&](double a) { return a > 1.4 * pi ? ToCircle(sway_m, 0.0, 0.150, a) : 1.0; }));
  }
  const auto& held = tracker.Update({});
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->right_m, 0.020, 0.004);  // it lags
  EXPECT_NEAR(held->radius_m, 0.150, 1e-6);
}

// Only the invert is left, 20° to either side of it: up and down is seen, left and right is not.
TEST(PipeSliceTracker, KnowsWhichWayItNoLongerSees) {
  PipeSliceTracker tracker(30);
  EXPECT_NEAR(Held(tracker, 0.150), 0.150, 1e-6);
  for (int i = 0; i < 30; ++i)
    (void)tracker.Update(Scan([](double a) { return Above(a, -70) ? 1.0 : 0.150; }));
  const auto& held = tracker.Update({});
  ASSERT_TRUE(held);
  EXPECT_LT(held->DeviationAt(-pi / 2), 0.001);
  EXPECT_GT(held->DeviationAt(0.0), 1.5 * held->DeviationAt(-pi / 2));
}

TEST(PipeSliceTracker, FollowsSmallStepsAtOnceAndAnotherPipeAfterAWhile) {
  PipeSliceTracker tracker(3);
  EXPECT_NEAR(Held(tracker, 0.150), 0.150, 1e-6);
  EXPECT_NEAR(Held(tracker, 0.152), 0.152, 1e-6);
  EXPECT_NEAR(Held(tracker, 0.125), 0.152, 1e-6);
  EXPECT_NEAR(Held(tracker, 0.125), 0.152, 1e-6);
  EXPECT_NEAR(Held(tracker, 0.125), 0.125, 1e-6);
}

}  // namespace
}  // namespace kantaro::perception
