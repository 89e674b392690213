#include "sim/fault_geometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kantaro::sim {
namespace {

using network::FaultCategory;
using network::FaultRank;

constexpr double kRadius_m = 0.15;

/// A level pipe of 300 mm along W's x axis; its axis lies 0.15 m above z = 0.
network::Network LevelPipe() {
  network::Network net;
  network::Manhole upstream, downstream;
  upstream.name = "A";
  downstream.name = "B";
  downstream.p_WM = {6.0, 0.0, 0.0};
  net.manholes = {upstream, downstream};
  network::Pipe pipe;
  pipe.name = "P";
  pipe.upstream = "A";
  pipe.downstream = "B";
  pipe.diameter_m = 2.0 * kRadius_m;
  net.pipes = {pipe};
  return net;
}

class FaultOfEveryCategory : public testing::TestWithParam<FaultCategory> {
 protected:
  /// How far into the pipe the fault reaches from the wall, after checking that it is where it
  /// should be.
  double Reach(FaultRank rank) {
    const network::Network net = LevelPipe();
    const network::PipeAxis axis(net, net.pipes[0]);
    network::Fault fault{"f", GetParam(), rank, 2.0, 3.0, 0.10, 0.08};
    if (GetParam() == FaultCategory::kCrack) fault.width_m = 0.005;
    RandomStream random(1, "fault");
    double reach_m = 0.0;
    for (const Visual& visual : BuildFault(axis, kRadius_m, fault, random)) {
      EXPECT_FALSE(visual.mesh.triangles.empty());
      EXPECT_EQ(visual.mesh.normals.size(), visual.mesh.positions.size());
      EXPECT_EQ(visual.mesh.texture.size(), visual.mesh.positions.size());
      for (const Eigen::Vector3f& p_OV : visual.mesh.positions) {
        const network::PipePosition place = axis.Locate(visual.mesh.p_WO + p_OV.cast<double>());
        EXPECT_NEAR(place.chainage_m, 2.0, 0.25);
        EXPECT_LT(place.offset_m, kRadius_m + 0.03);  // a stub's foot stands behind the curved wall
        reach_m = std::max(reach_m, kRadius_m - place.offset_m);
      }
    }
    return reach_m;
  }
};

TEST_P(FaultOfEveryCategory, IsSeenOffTheWallNearItsPlace) {
  EXPECT_GT(Reach(FaultRank::kA), 0.0003);
}

TEST_P(FaultOfEveryCategory, StandsOutLessTheLowerItsRank) {
  EXPECT_LE(Reach(FaultRank::kC), Reach(FaultRank::kA) + 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Jswa, FaultOfEveryCategory,
                         testing::Values(FaultCategory::kCrack, FaultCategory::kWaterInfiltration,
                                         FaultCategory::kRootInvasion, FaultCategory::kPipeBreak,
                                         FaultCategory::kJointAndGap,
                                         FaultCategory::kMountingPipeProjection,
                                         FaultCategory::kAdhesionOfMortar,
                                         FaultCategory::kForeignSubstance,
                                         FaultCategory::kAdhesionOfGrease));

// Looking downstream (+x) with z up, three o'clock is at −y.
TEST(BuildFault, PutsThreeOClockOnTheRight) {
  const network::Network net = LevelPipe();
  const network::PipeAxis axis(net, net.pipes[0]);
  RandomStream random(1, "fault");
  const network::Fault fault{"f", FaultCategory::kAdhesionOfMortar, FaultRank::kA, 2.0, 3.0, 0.10,
                             0.08};
  const VisualMesh mesh = BuildFault(axis, kRadius_m, fault, random).front().mesh;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p_OV : mesh.positions) sum += mesh.p_WO + p_OV.cast<double>();
  const Eigen::Vector3d middle = sum / static_cast<double>(mesh.positions.size());
  EXPECT_NEAR(middle.y(), -kRadius_m, 0.04);
  EXPECT_NEAR(middle.z(), kRadius_m, 0.02);
}

TEST(BuildFault, FacesTheAxis) {
  const network::Network net = LevelPipe();
  const network::PipeAxis axis(net, net.pipes[0]);
  RandomStream random(1, "fault");
  const network::Fault fault{"f", FaultCategory::kCrack, FaultRank::kA, 2.0, 10.0, 0.10, 0.005};
  for (const Visual& visual : BuildFault(axis, kRadius_m, fault, random)) {
    for (std::size_t i = 0; i < visual.mesh.positions.size(); ++i) {
      const Eigen::Vector3d p_W = visual.mesh.p_WO + visual.mesh.positions[i].cast<double>();
      const Eigen::Vector3d inward = Eigen::Vector3d(p_W.x(), 0.0, kRadius_m) - p_W;
      EXPECT_GT(visual.mesh.normals[i].cast<double>().dot(inward.normalized()), 0.7);
    }
  }
}

TEST(BuildJointRims, LieBesideTheGrooveAllRound) {
  const network::Network net = LevelPipe();
  const network::PipeAxis axis(net, net.pipes[0]);
  RandomStream random(1, "joint");
  // On one side the groove reaches further than its gap.
  const auto in_groove = [&](const Eigen::Vector3d& p_W) {
    return std::abs(axis.Locate(p_W).chainage_m - 2.002) < 0.006;
  };
  const std::vector<Visual> rims =
      BuildJointRims(axis, kRadius_m, {2.0, 0.008, 0.006}, random, Look{}, in_groove);
  ASSERT_EQ(rims.size(), 2u);
  for (const Visual& rim : rims) {
    for (const Eigen::Vector3f& p_OV : rim.mesh.positions) {
      const network::PipePosition place = axis.Locate(rim.mesh.p_WO + p_OV.cast<double>());
      EXPECT_GE(std::abs(place.chainage_m - 2.002), 0.006 - 2.1e-4);
      EXPECT_LT(std::abs(place.chainage_m - 2.0), 0.02);
      EXPECT_NEAR(place.offset_m, kRadius_m, 0.001);
    }
  }
}

}  // namespace
}  // namespace kantaro::sim
