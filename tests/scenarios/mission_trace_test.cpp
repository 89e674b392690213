#include "scenarios/mission_trace.hpp"

#include <gtest/gtest.h>

namespace kantaro::scenarios {
namespace {

TEST(ClockDistance, GoesTheShorterWayRound) {
  EXPECT_DOUBLE_EQ(ClockDistance(11.0, 1.0), 2.0);
  EXPECT_DOUBLE_EQ(ClockDistance(3.0, 9.0), 6.0);
  EXPECT_DOUBLE_EQ(ClockDistance(12.0, 0.5), 0.5);
}

TEST(AddSighting, JoinsWhatLiesTogetherAcrossTheCrown) {
  std::vector<ReportedFault> reports;
  AddSighting(reports, {1.0, "P", 2.0, 11.5, 0.9});
  const ReportedFault& joined = AddSighting(reports, {2.0, "P", 2.1, 0.5, 0.7});
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(joined.sightings, 2);
  EXPECT_NEAR(joined.chainage_m, 2.05, 1e-12);
  EXPECT_NEAR(joined.clock_h, 12.0, 1e-12);
  EXPECT_EQ(joined.similarity, 0.7);
}

TEST(AddSighting, KeepsApartWhatLiesApart) {
  std::vector<ReportedFault> reports;
  AddSighting(reports, {1.0, "P", 2.0, 3.0, 0.9});
  AddSighting(reports, {1.0, "P", 2.3, 3.0, 0.9});
  AddSighting(reports, {1.0, "P", 2.0, 5.0, 0.9});
  AddSighting(reports, {1.0, "Q", 2.0, 3.0, 0.9});
  EXPECT_EQ(reports.size(), 4u);
}

}  // namespace
}  // namespace kantaro::scenarios
