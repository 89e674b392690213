#include <gtest/gtest.h>

#include <algorithm>

#include "network/generator.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {
namespace {

// Each pipe and each manhole becomes a part of the world, whatever meets in it.
TEST(GeneratedSewers, CanAllBeBuilt) {
  for (const auto layout :
       {network::Layout::kGrid, network::Layout::kTree, network::Layout::kCity}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const network::Network network =
          network::Generate({layout, 150, {}, seed == 1 ? 6.0 : 35.8, seed});
      const Sewer sewer = BuildSewer(network);
      EXPECT_EQ(sewer.axes.size(), 150u);
      EXPECT_EQ(sewer.parts.size(), network.pipes.size() + network.manholes.size());
      EXPECT_GE(sewer.voids.size(), sewer.parts.size());
    }
  }
}

}  // namespace
}  // namespace kantaro::sim
