#include "network/joints.hpp"

#include <gtest/gtest.h>

namespace kantaro::network {
namespace {

TEST(LayJoints, RepeatsUntilAShortStubWouldRemain) {
  // Six metres in lengths of 1.8 m: 5.4 leaves a stub of 0.6 m, above a quarter of 1.8 m.
  const std::vector<Joint> joints = LayJoints({1.8, 1.8, 0.010, 0.004}, 6.0);
  ASSERT_EQ(joints.size(), 3u);
  EXPECT_DOUBLE_EQ(joints[2].chainage_m, 5.4);
  EXPECT_DOUBLE_EQ(joints[2].gap_m, 0.010);
  EXPECT_DOUBLE_EQ(joints[2].depth_m, 0.004);
  EXPECT_EQ(LayJoints({1.8, 1.8}, 5.8).size(), 2u);  // a stub of 0.4 m is not laid
  EXPECT_TRUE(LayJoints({1.8, 1.8}, 1.0).empty());
}

}  // namespace
}  // namespace kantaro::network
