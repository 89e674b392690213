#include "sim/void_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

VoidPrimitive Tube(const Vector3d& from, const Vector3d& along, double length_m, double radius_m) {
  VoidPrimitive tube;
  tube.X_WS.translation() = from;
  tube.X_WS.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix();
  tube.length_m = length_m;
  tube.radius_m = radius_m;
  return tube;
}

double Distance(const VoidField& field, const Vector3d& p_W, double cap_m = 0.2) {
  return VoidField::NearestWall(field.Around(p_W, cap_m), p_W, cap_m).distance_m;
}

TEST(VoidField, MeasuresARoundPipeFromItsAxisOutward) {
  const VoidField field({Tube(Vector3d::Zero(), Vector3d::UnitX(), 4.0, 0.15)});
  EXPECT_NEAR(Distance(field, {2.0, 0.0, 0.0}), 0.15, 1e-12);
  EXPECT_NEAR(Distance(field, {2.0, 0.06, -0.08}), 0.05, 1e-12);
  EXPECT_NEAR(Distance(field, {2.0, 0.0, 0.16}), -0.01, 1e-12);
  const Wall wall =
      VoidField::NearestWall(field.Around({2.0, 0.0, -0.1}, 0.1), {2.0, 0.0, -0.1}, 0.1);
  EXPECT_TRUE(wall.normal_W.isApprox(Vector3d::UnitZ(), 1e-9));
}

TEST(VoidField, SaysTheCapWhereNoWallIsNear) {
  const VoidField field({Tube(Vector3d::Zero(), Vector3d::UnitX(), 4.0, 0.15)});
  EXPECT_EQ(Distance(field, {2.0, 0.0, 0.0}, 0.05), 0.05);
}

// Two pipe lengths that overlap by a hair are one pipe: no wall closes between them.
TEST(VoidField, HasNoSeamBetweenPipeLengths) {
  const VoidField field({Tube(Vector3d::Zero(), Vector3d::UnitX(), 2.001, 0.15),
                         Tube({1.999, 0.0, 0.0}, Vector3d::UnitX(), 2.0, 0.15)});
  for (double x = 1.98; x <= 2.02; x += 0.0005) {
    EXPECT_NEAR(Distance(field, {x, 0.0, -0.138}), 0.012, 1e-9) << x;
  }
}

// Seen from inside a side branch, the mouth's edge is the nearest solid, at its true distance.
TEST(VoidField, RoundsTheEdgeOfAMouth) {
  const double pipe = 0.15;
  const double branch = 0.05;
  const VoidField field({Tube(Vector3d::Zero(), Vector3d::UnitX(), 4.0, pipe),
                         Tube({2.0, 0.0, 0.0}, Vector3d::UnitY(), 0.5, branch)});
  // The edge nearest to the branch's downstream side lies at (2.05, 0.15, 0): 3-4-5 from the point,
  // in the middle of the mouth's opening and inside the pipe's surface line.
  const Vector3d p(2.05 - 0.006, pipe - 0.008, 0.0);
  EXPECT_NEAR(Distance(field, p), 0.010, 1e-4);
  const Wall wall = VoidField::NearestWall(field.Around(p, 0.05), p, 0.05);
  EXPECT_TRUE(wall.normal_W.isApprox(Vector3d(-0.6, -0.8, 0.0), 0.02)) << wall.normal_W.transpose();
}

// An independent measure: the nearest of many points known to be solid, from marching a fine grid
// around the query.
double BruteForce(const std::vector<VoidPrimitive>& voids, const Vector3d& p, double reach_m,
                  double grid_m) {
  double nearest = reach_m;
  const int n = static_cast<int>(reach_m / grid_m);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      for (int k = -n; k <= n; ++k) {
        const Vector3d offset = grid_m * Vector3d(i, j, k);
        if (offset.norm() >= nearest) continue;
        bool solid = true;
        for (const VoidPrimitive& v : voids) solid = solid && InsideDistance(v, p + offset) <= 0.0;
        if (solid) nearest = offset.norm();
      }
    }
  }
  return nearest;
}

TEST(VoidField, AgreesWithMarchingAGridAroundAJunction) {
  VoidPrimitive shaft = Tube({2.0, 0.0, 0.15}, Vector3d::UnitZ(), 1.5, 0.4);
  VoidPrimitive channel = Tube({1.6, 0.0, 0.0}, Vector3d::UnitX(), 0.8, 0.15);
  channel.profile = Profile::kU;
  channel.wall_height_m = 0.151;
  VoidPrimitive curve = channel;
  curve.X_WS.translation().x() = 1.736;
  curve.curvature = 1.0 / 0.264;
  curve.length_m = 0.264 * std::numbers::pi / 2.0;
  const std::vector<VoidPrimitive> voids{Tube({-1.0, 0.0, 0.0}, Vector3d::UnitX(), 2.602, 0.15),
                                         Tube({2.398, 0.0, 0.0}, Vector3d::UnitX(), 2.0, 0.15),
                                         channel, curve, shaft};
  const VoidField field(voids);
  RandomStream random(1, "junction");
  constexpr double kReach = 0.03;
  constexpr double kGrid = 0.001;
  int near = 0;
  for (int i = 0; i < 400; ++i) {
    const Vector3d p(random.Uniform(1.5, 2.5), random.Uniform(-0.2, 0.4),
                     random.Uniform(-0.15, 0.25));
    const double distance = Distance(field, p, kReach);
    if (distance <= 0.0) continue;
    const double brute = BruteForce(voids, p, kReach, kGrid);
    near += brute < kReach ? 1 : 0;
    // The grid's point lies up to its diagonal behind the wall; flat walls cut a curved edge's
    // corner by a little.
    EXPECT_NEAR(distance, brute, 1.8 * kGrid) << p.transpose();
  }
  EXPECT_GT(near, 30);
}

}  // namespace
}  // namespace kantaro::sim
