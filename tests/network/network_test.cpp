#include "network/network.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "network/network_index.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

TEST(Network, FindsManholesAndPipesByName) {
  const Network network = OnePipe();
  EXPECT_EQ(network.FindManhole("B"), 1u);
  EXPECT_EQ(network.FindPipe("P"), 0u);
  EXPECT_FALSE(network.FindManhole("P").has_value());
  EXPECT_EQ(network.PipeNamed("P").downstream, "B");
  EXPECT_THROW((void)network.ManholeNamed("C"), std::out_of_range);
  EXPECT_THROW((void)network.PipeNamed("A"), std::out_of_range);
}

TEST(Network, AShaftIsTheLargestPipePlusHalfAMetre) {
  Network network = OnePipe();
  network.manholes.push_back(ManholeAt("C", 20, 0));
  network.pipes.push_back(PipeFrom("Q", "B", "C", 0.25));
  EXPECT_DOUBLE_EQ(network.ShaftDiameter(network.manholes[1]), 0.8);  // 300 mm decides
  EXPECT_DOUBLE_EQ(network.ShaftDiameter(network.manholes[2]), 0.75);
  network.manholes[1].shaft_diameter_m = 1.2;
  EXPECT_DOUBLE_EQ(network.ShaftDiameter(network.manholes[1]), 1.2);
}

TEST(Network, OnlyPipesFrom200To350MillimetresAreEnterable) {
  EXPECT_FALSE(IsEnterable(PipeFrom("P", "A", "B", 0.150)));
  EXPECT_TRUE(IsEnterable(PipeFrom("P", "A", "B", 0.200)));
  EXPECT_TRUE(IsEnterable(PipeFrom("P", "A", "B", 0.350)));
  EXPECT_FALSE(IsEnterable(PipeFrom("P", "A", "B", 0.400)));
}

TEST(NetworkIndex, KnowsThePipesOfEveryManhole) {
  Network network = OnePipe();
  network.manholes.push_back(ManholeAt("C", 10, 5));
  network.pipes.push_back(PipeFrom("Q", "C", "B", 0.25));
  const NetworkIndex index(network);
  EXPECT_EQ(index.pipes_at[1], (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(index.upstream[1], 2u);
  EXPECT_EQ(index.downstream[1], 1u);
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    EXPECT_EQ(index.pipes_at[i], network.PipesAt(network.manholes[i].name));
    EXPECT_EQ(index.shaft_diameter_m[i], network.ShaftDiameter(network.manholes[i]));
  }
}

TEST(NetworkIndex, RefusesAPipeToNowhere) {
  Network network = OnePipe();
  network.pipes[0].downstream = "Z";
  EXPECT_THROW(NetworkIndex{network}, std::out_of_range);
}

}  // namespace
}  // namespace kantaro::network
