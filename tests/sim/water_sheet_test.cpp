#include "sim/water_sheet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "tests/network/sewers.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.15;
constexpr double kDepth_m = 0.02;

network::Network Watered(double slope = 0.0) {
  network::Network network = network::OnePipe();
  network.manholes[0].p_WM.z() = 10.0 * slope;
  network.pipes[0].water_m = kDepth_m;
  return network;
}

Vector3d Place(const WaterSheet& sheet, const WaterSheet::Vertex& vertex) {
  return sheet.p_WO + vertex.p_OV.cast<double>();
}

TEST(WaterSheets, AreNoneInADrySewer) {
  EXPECT_TRUE(BuildWaterSheets(BuildSewer(network::OnePipe()), 1.0).empty());
}

// A chord 130 mm below the axis of a pipe of 150 mm radius is 2 * sqrt(150^2 - 130^2) = 150 mm
// wide.
TEST(WaterSheets, LieLevelAcrossAndFollowTheInvert) {
  const Sewer sewer = BuildSewer(Watered(0.03));
  const double half_width_m = std::sqrt(kRadius_m * kRadius_m - 0.13 * 0.13);
  std::size_t in_pipe = 0;
  for (const WaterSheet& sheet : BuildWaterSheets(sewer, 1.0)) {
    for (const WaterSheet::Vertex& vertex : sheet.vertices) {
      const Eigen::Vector3f& axis = vertex.wall_axis;
      if (std::abs(axis.z()) > 0.5f) continue;  // a manhole's: its wall is upright
      ++in_pipe;
      const Vector3d p_P =
          sewer.axes[0].PoseAt(vertex.along_left_m.x()).inverse() * Place(sheet, vertex);
      EXPECT_NEAR(std::abs(p_P.y()), half_width_m, 0.001);
      EXPECT_NEAR(p_P.z(), kDepth_m - kRadius_m, 1e-5);
      // What it says of the wall around leads to the axis.
      EXPECT_NEAR(
          (p_P + sewer.axes[0].PoseAt(0.0).linear().transpose() * vertex.p_VAxis.cast<double>())
              .tail<2>()
              .norm(),
          0.0, 1e-5);
    }
  }
  EXPECT_GE(in_pipe, 4u * 9u);  // 9.2 m in pieces of up to a metre
}

TEST(WaterSheets, GoOnThroughTheManholesAtTheSameDepth) {
  const Sewer sewer = BuildSewer(Watered());
  double furthest_m = 0.0;
  for (const WaterSheet& sheet : BuildWaterSheets(sewer, 1.0)) {
    for (const WaterSheet::Vertex& vertex : sheet.vertices) {
      EXPECT_NEAR(Place(sheet, vertex).z(), kDepth_m, 1e-5);
      furthest_m = std::max(furthest_m, Place(sheet, vertex).x());
    }
  }
  EXPECT_GT(furthest_m, 10.2);
}

TEST(WaterSheets, CoverAFlatFloor) {
  network::Network network = Watered();
  for (network::Manhole& manhole : network.manholes)
    manhole.bench_height = network::BenchHeight::kFlat;
  double widest_m = 0.0;
  for (const WaterSheet& sheet : BuildWaterSheets(BuildSewer(network), 1.0)) {
    for (const WaterSheet::Vertex& vertex : sheet.vertices)
      widest_m = std::max(widest_m, std::abs(Place(sheet, vertex).y()));
  }
  EXPECT_NEAR(widest_m, 0.4, 0.001);  // the shaft: 300 + 500 mm wide
}

// Each way across a manhole of three pipes has a channel of its own; at a mouth two begin alike.
TEST(WaterSheets, LieOnceWhereTwoWaysAcrossAManholeShareOne) {
  network::Network network = Watered();
  network::Manhole end = network.manholes[1];
  for (const double turn : {0.0, 1.0}) {
    end.name = turn == 0.0 ? "ahead" : "aside";
    end.p_WM = network.manholes[1].p_WM + Vector3d(10.0 * (1.0 - turn), 10.0 * turn, 0.0);
    network.manholes.push_back(end);
    network::Pipe pipe = network.pipes[0];
    pipe.name = "to " + end.name;
    pipe.upstream = network.manholes[1].name;
    pipe.downstream = end.name;
    network.pipes.push_back(pipe);
  }
  const auto corners = [](const WaterSheet& sheet) {
    std::vector<std::array<long, 3>> rounded;
    for (const WaterSheet::Vertex& vertex : sheet.vertices) {
      const Vector3d p_W = Place(sheet, vertex);
      rounded.push_back(
          {std::lround(1e4 * p_W.x()), std::lround(1e4 * p_W.y()), std::lround(1e4 * p_W.z())});
    }
    std::ranges::sort(rounded);
    return rounded;
  };
  std::set<std::vector<std::array<long, 3>>> places;
  for (const WaterSheet& sheet : BuildWaterSheets(BuildSewer(network), 1.0))
    EXPECT_TRUE(places.insert(corners(sheet)).second) << sheet.p_WCentre.transpose();
  EXPECT_GT(places.size(), 30U);  // 28 m of pipe, and the manholes
}

}  // namespace
}  // namespace kantaro::sim
