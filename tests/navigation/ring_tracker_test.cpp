#include "navigation/ring_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kantaro::navigation {
namespace {

using perception::RingKind;
using perception::RingSighting;

RingSighting RingAt(double distance_m, RingKind kind = RingKind::kJoint) {
  RingSighting ring;
  ring.kind = kind;
  ring.distance_m = distance_m;
  return ring;
}

/// Frames without any ring until tracks are given up.
std::vector<ScaleSighting> LoseSight(RingTracker& tracker, double wheel_travel_m) {
  for (int i = 0; i < 2; ++i)
    EXPECT_TRUE(tracker.Follow({}, wheel_travel_m).empty()) << "two frames may miss a ring";
  return tracker.Follow({}, wheel_travel_m);
}

// Travels 0, 0.1 … 0.4 m: squares about their mean add up to 0.04 + 0.01 + 0 + 0.01 + 0.04 = 0.1.
constexpr double kSpread = 0.1;
const std::vector<double> kTravel_m{0.0, 0.1, 0.2, 0.3, 0.4};

TEST(FitScale, IsTheSlopeOfDistanceOverTravel) {
  const auto scale = FitScale(kTravel_m, {1.5, 1.404, 1.308, 1.212, 1.116});
  ASSERT_TRUE(scale.has_value());
  EXPECT_NEAR(scale->scale, 0.96, 1e-9);
  EXPECT_NEAR(scale->deviation, 0.01 / std::sqrt(kSpread), 1e-9)
      << "no better than 1 cm is any one distance";
}

// Errors of (2, −1, −2, −1, 2) cm lean neither way: they leave the slope alone. Their squares make
// 14 cm²; five points less two unknowns leave 3.
TEST(FitScale, IsLessSureWhereTheDistancesScatter) {
  const auto scale = FitScale(kTravel_m, {1.52, 1.39, 1.28, 1.19, 1.12});
  ASSERT_TRUE(scale.has_value());
  EXPECT_NEAR(scale->scale, 1.0, 1e-9);
  EXPECT_NEAR(scale->deviation, std::sqrt(14e-4 / 3.0) / std::sqrt(kSpread), 1e-9);
}

TEST(FitScale, NeedsFiveSightingsAndAQuarterMetre) {
  EXPECT_FALSE(FitScale({0.0, 0.1, 0.2, 0.3}, {1.5, 1.4, 1.3, 1.2}));
  EXPECT_FALSE(FitScale({0.0, 0.06, 0.12, 0.18, 0.24}, {1.5, 1.44, 1.38, 1.32, 1.26}));
  EXPECT_TRUE(FitScale({0.0, 0.06, 0.12, 0.18, 0.26}, {1.5, 1.44, 1.38, 1.32, 1.24}));
  EXPECT_FALSE(FitScale({}, {}));
}

TEST(RingTracker, MeasuresTheScaleOfARingThatWentBy) {
  RingTracker tracker;
  for (int i = 0; i <= 10; ++i)
    EXPECT_TRUE(tracker.Follow({RingAt(1.5 - 0.95 * 0.05 * i)}, 0.05 * i).empty());
  const auto scales = LoseSight(tracker, 0.55);
  ASSERT_EQ(scales.size(), 1u);
  EXPECT_NEAR(scales[0].scale, 0.95, 1e-9);
  EXPECT_TRUE(tracker.Follow({}, 0.6).empty()) << "a track is told once";
}

TEST(RingTracker, FollowsTwoRingsAtOnce) {
  RingTracker tracker;
  for (int i = 0; i <= 10; ++i) {
    const double driven_m = 0.05 * i;
    (void)tracker.Follow({RingAt(1.0 - 0.98 * driven_m), RingAt(1.3 - 0.98 * driven_m)}, driven_m);
  }
  const auto scales = LoseSight(tracker, 0.55);
  ASSERT_EQ(scales.size(), 2u);
  for (const ScaleSighting& scale : scales) EXPECT_NEAR(scale.scale, 0.98, 1e-9);
}

TEST(RingTracker, HoldsOnOverTwoFramesWithoutTheRing) {
  RingTracker tracker;
  for (const int i : {0, 1, 2, 5, 8}) {
    for (int missed = 0; i > 2 && missed < 2; ++missed) (void)tracker.Follow({}, 0.05 * i);
    (void)tracker.Follow({RingAt(1.5 - 0.05 * i)}, 0.05 * i);
  }
  EXPECT_EQ(LoseSight(tracker, 0.4).size(), 1u);
}

// 10 cm from where it should be is another ring: neither piece is long enough to tell anything.
TEST(RingTracker, TakesARingThatJumpsForAnother) {
  RingTracker tracker;
  for (int i = 0; i < 8; ++i) {
    const double jump_m = i < 4 ? 0.0 : 0.10;
    (void)tracker.Follow({RingAt(1.5 - 0.05 * i + jump_m)}, 0.05 * i);
  }
  EXPECT_TRUE(LoseSight(tracker, 0.4).empty());
}

TEST(RingTracker, TakesNoMouthForAJoint) {
  RingTracker tracker;
  for (int i = 0; i < 8; ++i) {
    (void)tracker.Follow(
        {RingAt(1.5 - 0.05 * i, i % 2 == 0 ? RingKind::kJoint : RingKind::kManholeMouth)},
        0.05 * i);
  }
  EXPECT_TRUE(LoseSight(tracker, 0.4).empty()) << "four sightings of each";
}

TEST(RingTracker, Forgets) {
  RingTracker tracker;
  for (int i = 0; i <= 10; ++i) (void)tracker.Follow({RingAt(1.5 - 0.05 * i)}, 0.05 * i);
  tracker.Forget();
  EXPECT_TRUE(LoseSight(tracker, 0.55).empty());
}

}  // namespace
}  // namespace kantaro::navigation
