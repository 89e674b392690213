#include "navigation/rate_bias.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"

namespace kantaro::navigation {
namespace {

robot::RunTime At(double time_s) { return robot::RunTime(std::llround(time_s * 1e9)); }

TEST(RateBias, KnowsNothingAtFirst) {
  RateBias bias;
  for (int i = 0; i < 100; ++i) bias.Learn(At(0.01 * i), 0.02);
  EXPECT_EQ(bias.rad_s(), 0.0);  // of 1 s only
}

// Noise of 2 mrad/s, means of ten: the median of 80 is known to 0.1 mrad/s.
TEST(RateBias, FindsABiasUnderNoise) {
  RateBias bias;
  RandomStream noise(1, "gyro");
  for (int i = 0; i < 1000; ++i) bias.Learn(At(0.01 * i), 0.004 + noise.Normal(0.002));
  EXPECT_NEAR(bias.rad_s(), 0.004, 0.0005);
}

// A bend of 45° of 1.5 diameters in a 250 mm pipe: 0.35 rad/s for 2.3 s, of the 8 s remembered.
TEST(RateBias, TakesNoBendForABias) {
  RateBias bias;
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const bool bend = i > 1000 && i < 1230;
    bias.Learn(At(0.01 * i), bend ? 0.35 : 0.001);
    most = std::max(most, bias.rad_s());
  }
  EXPECT_NEAR(most, 0.001, 1e-9);
}

TEST(RateBias, FollowsADrift) {
  RateBias bias;
  for (int i = 0; i < 4000; ++i) bias.Learn(At(0.01 * i), i < 2000 ? 0.0 : 0.02);
  EXPECT_NEAR(bias.rad_s(), 0.02, 1e-9);
}

}  // namespace
}  // namespace kantaro::navigation
