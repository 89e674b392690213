#include "navigation/wheel_watch.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace kantaro::navigation {
namespace {

robot::RunTime At(double time_s) { return robot::RunTime(std::llround(time_s * 1e9)); }

/// Feels the wheels every 20 ms from `from_s` to `to_s`, rolling this fast. @returns the first
/// complaint.
std::optional<std::string> Roll(WheelWatch& watch, double from_s, double to_s, double& travel_m,
                                double speed_m_s) {
  for (double time_s = from_s; time_s < to_s; time_s += 0.02) {
    if (const auto wrong = watch.Feel(At(time_s), travel_m)) return wrong;
    travel_m += 0.02 * speed_m_s;
  }
  return {};
}

TEST(WheelWatch, IsContentWhileWheelsDoAsTheyAreTold) {
  WheelWatch watch(1.5, 0.1);
  double travel_m = 3.0;
  watch.Tell(0.13);
  EXPECT_FALSE(Roll(watch, 0.0, 5.0, travel_m, 0.12));
  watch.Tell(-0.08);
  EXPECT_FALSE(Roll(watch, 5.0, 10.0, travel_m, -0.08));
  watch.Tell(0.0);
  EXPECT_FALSE(Roll(watch, 10.0, 20.0, travel_m, 0.0));
}

TEST(WheelWatch, SeesEncodersThatStandStill) {
  WheelWatch watch(1.5, 0.1);
  double travel_m = 0.0;
  watch.Tell(0.13);
  EXPECT_FALSE(Roll(watch, 0.0, 3.0, travel_m, 0.13));
  EXPECT_FALSE(Roll(watch, 3.0, 4.0, travel_m, 0.0));
  const auto wrong = Roll(watch, 4.0, 5.0, travel_m, 0.0);
  ASSERT_TRUE(wrong);
  EXPECT_THAT(*wrong, testing::HasSubstr("by their encoders"));
}

TEST(WheelWatch, SeesWheelsThatTurnTheOtherWay) {
  WheelWatch watch(1.5, 0.1);
  double travel_m = 0.0;
  watch.Tell(-0.08);
  EXPECT_TRUE(Roll(watch, 0.0, 3.0, travel_m, 0.08));
}

// Twice the motors' speed: 1 cm in 20 ms; 2 cm more are forgiven, once.
TEST(WheelWatch, SeesAJump) {
  WheelWatch watch(1.5, 0.1);
  watch.Tell(0.13);
  EXPECT_FALSE(watch.Feel(At(0.00), 0.0));
  EXPECT_FALSE(watch.Feel(At(0.02), 0.029));
  EXPECT_EQ(watch.Feel(At(0.04), 0.060), "the encoders jumped by 0.03 m");
}

}  // namespace
}  // namespace kantaro::navigation
