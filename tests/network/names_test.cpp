#include "network/names.hpp"

#include <gtest/gtest.h>

namespace kantaro::network {
namespace {

TEST(Words, ReadBackAsTheirValue) {
  for (int i = 0; i < 9; ++i) {
    const auto category = static_cast<FaultCategory>(i);
    EXPECT_EQ(FromWord<FaultCategory>(WordFor(category)), category);
  }
  EXPECT_EQ(WordFor(FaultCategory::kAdhesionOfGrease), "adhesion_of_grease");
  EXPECT_EQ(WordFor(Material::kLined), "lined");
  EXPECT_EQ(FromWord<FaultRank>("C"), FaultRank::kC);
  EXPECT_EQ(FromWord<BenchHeight>("crown"), BenchHeight::kCrown);
}

TEST(Words, AreAbsentForStrangers) {
  EXPECT_FALSE(FromWord<Material>("steel").has_value());
  EXPECT_FALSE(FromWord<FaultRank>("a").has_value());
}

}  // namespace
}  // namespace kantaro::network
