#include "scenarios/experiments/wilson.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace kantaro::scenarios {
namespace {

// By hand, z = 1.96: 65 of 70 has p = 0.92857; middle (p + z²/140) / (1 + z²/70) = 0.95601
// / 1.05488 = 0.90627; half 1.96 / 1.05488 · √(0.066327 / 70 + 3.8416 / 19600) = 1.85803 · 0.033812
// = 0.06282.
TEST(WilsonRate, AgreesWithTheFormulaByHand) {
  const Rate rate = WilsonRate(65, 70);
  EXPECT_NEAR(rate.share, 0.92857, 1e-5);
  EXPECT_NEAR(rate.low, 0.84345, 2e-4);
  EXPECT_NEAR(rate.high, 0.96909, 2e-4);
}

// With all of n: the low end is n / (n + z²), here 10 / 13.8416.
TEST(WilsonRate, NeverLeavesZeroToOne) {
  const Rate all = WilsonRate(10, 10);
  EXPECT_NEAR(all.low, 0.72246, 1e-4);
  EXPECT_EQ(all.high, 1.0);
  const Rate none = WilsonRate(0, 10);
  EXPECT_EQ(none.low, 0.0);
  EXPECT_NEAR(none.high, 0.27754, 1e-4);
  EXPECT_EQ(WilsonRate(0, 0).high, 1.0);
}

TEST(WilsonRate, RefusesMoreSuccessesThanTrials) {
  EXPECT_THROW((void)WilsonRate(2, 1), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::scenarios
