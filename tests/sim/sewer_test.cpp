#include "sim/sewer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "network/formats.hpp"
#include "sim/void_field.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

Sewer TestField() {
  return BuildSewer(network::ReadNetwork(KANTARO_SOURCE_DIR "/models/networks/test_field.yaml"));
}

/// Distance to the wall from a point along a direction, by marching with the field.
double March(const VoidField& field, Vector3d p, const Vector3d& direction, double limit_m) {
  double travelled = 0.0;
  while (travelled < limit_m) {
    const double step = VoidField::NearestWall(field.Around(p, 0.2), p, 0.2).distance_m;
    if (step < 1e-6) break;
    // Far from a wall the field may say a few per cent too much.
    p += 0.8 * step * direction;
    travelled += 0.8 * step;
  }
  return travelled;
}

TEST(Sewer, EveryPipeIsOpenFromShaftToShaft) {
  const Sewer sewer = TestField();
  const VoidField field(sewer.voids, sewer.solids);
  for (std::size_t i = 0; i < sewer.axes.size(); ++i) {
    const double radius = sewer.network.pipes[i].diameter_m / 2.0;
    for (double s = -0.05; s <= sewer.axes[i].length_m() + 0.05; s += 0.01) {
      const Vector3d p = sewer.axes[i].PoseAt(s).translation();
      EXPECT_GT(VoidField::NearestWall(field.Around(p, 0.2), p, 0.2).distance_m, radius - 0.002)
          << sewer.network.pipes[i].name << " at " << s;
    }
  }
}

// Benching that reaches the crown: from the middle of a straight manhole, at the height of the
// axis, the sides are as near as in the pipe and only the top is open (thesis Table 5.3, status 1).
TEST(Sewer, APlainManholeOpensOnlyTheTop) {
  const Sewer sewer = TestField();
  const VoidField field(sewer.voids, sewer.solids);
  const network::Manhole& manhole = sewer.network.ManholeNamed("M1");
  const Vector3d p = manhole.p_WM + Vector3d(0.0, 0.0, 0.15);
  EXPECT_NEAR(March(field, p, Vector3d::UnitY(), 2.0), 0.15, 1e-3);
  EXPECT_NEAR(March(field, p, -Vector3d::UnitY(), 2.0), 0.15, 1e-3);
  EXPECT_GT(March(field, p, Vector3d::UnitZ(), 2.0), 1.0);
}

TEST(Sewer, ATeeOpensTheSideOfItsBranchToo) {
  const Sewer sewer = TestField();
  const VoidField field(sewer.voids, sewer.solids);
  const network::Manhole& manhole = sewer.network.ManholeNamed("M2");
  const Vector3d p = manhole.p_WM + Vector3d(0.0, 0.0, 0.15);
  EXPECT_GT(March(field, p, Vector3d::UnitY(), 2.0), 1.9);  // down the branch to the left
  EXPECT_NEAR(March(field, p, -Vector3d::UnitY(), 2.0), 0.15, 1e-3);
  EXPECT_GT(March(field, p, Vector3d::UnitZ(), 2.0), 1.0);
}

TEST(Sewer, ShaftsAreHalfAMetreWiderThanTheirLargestPipe) {
  const Sewer sewer = TestField();
  int shafts = 0;
  for (const VoidPrimitive& primitive : sewer.voids) {
    if (primitive.feature != Feature::kShaft) continue;
    const network::Manhole& manhole = sewer.network.manholes[sewer.parts[primitive.part].index];
    double largest = 0.0;
    for (const std::size_t i : sewer.network.PipesAt(manhole.name)) {
      largest = std::max(largest, sewer.network.pipes[i].diameter_m);
    }
    EXPECT_NEAR(2.0 * primitive.radius_m, largest + 0.5, 1e-12) << manhole.name;
    ++shafts;
  }
  EXPECT_EQ(shafts, 6);
}

TEST(Sewer, JointsAreGroovesOfTheirDepth) {
  const Sewer sewer = TestField();
  const VoidField field(sewer.voids, sewer.solids);
  const std::size_t pipe = sewer.network.FindPipe("P1").value();
  for (const network::Joint& joint : sewer.network.pipes[pipe].joints) {
    const Eigen::Isometry3d X_WP = sewer.axes[pipe].PoseAt(joint.chainage_m);
    EXPECT_NEAR(March(field, X_WP.translation(), X_WP.linear().col(2), 0.5), 0.150 + joint.depth_m,
                1e-4);
  }
}

TEST(Sewer, RefusesAShaftNarrowerThanItsPipes) {
  network::Network network = TestField().network;
  network.manholes[1].shaft_diameter_m = 0.32;
  EXPECT_THROW((void)BuildSewer(network), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::sim
