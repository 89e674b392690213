#include "perception/odometry.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace kantaro::perception {
namespace {

robot::Description FourWheels() {
  robot::Description description;
  description.wheels = {"fl", "fr", "rl", "rr"};
  for (const auto& wheel : description.wheels) description.tyres[wheel] = {0.045, 0.012};
  return description;
}

TEST(Odometry, TurnsAnglesIntoTravelPerSide) {
  const Odometry odometry(FourWheels());
  const OdometryObservation travel =
      odometry.Travel({{10.0, 20.0, 12.0, 22.0}}, std::chrono::milliseconds(5));
  EXPECT_NEAR(travel.left_m, 0.045 * 11.0, 1e-12);
  EXPECT_NEAR(travel.right_m, 0.045 * 21.0, 1e-12);
  EXPECT_NEAR(travel.travel_m, 0.045 * 16.0, 1e-12);
  EXPECT_EQ(travel.captured_at, std::chrono::milliseconds(5));
}

TEST(Odometry, IsNegativeRollingBackward) {
  EXPECT_NEAR(Odometry(FourWheels()).Travel({{-2, -2, -2, -2}}, {}).travel_m, -0.09, 1e-12);
}

TEST(Odometry, TakesEachWheelsOwnTyre) {
  robot::Description description = FourWheels();
  description.tyres["rl"].radius_m = 0.055;
  EXPECT_NEAR(Odometry(description).Travel({{1, 0, 1, 0}}, {}).left_m, 0.050, 1e-12);
}

TEST(Odometry, RefusesARobotItCannotMeasure) {
  robot::Description description = FourWheels();
  description.tyres.erase("fr");
  EXPECT_THROW(Odometry{description}, std::invalid_argument);
  description = FourWheels();
  description.wheels.pop_back();
  EXPECT_THROW(Odometry{description}, std::invalid_argument);
}

TEST(Odometry, RefusesNumbersThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)Odometry(FourWheels()).Travel({{0, nan, 0, 0}}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
