#include "sim/solid_primitive.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/contact.hpp"
#include "sim/sewer.hpp"
#include "sim/surface_mesh.hpp"
#include "sim/void_field.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// A level pipe of 300 mm along x between two shafts of 800 mm: chainage 0 lies at x = 0, the axis
/// at z = 0.
network::Network Straight() {
  network::Network net;
  network::Manhole a;
  a.name = "A";
  a.p_WM = {-0.4, 0.0, -0.15};
  network::Manhole b = a;
  b.name = "B";
  b.p_WM.x() = 4.4;
  net.manholes = {a, b};
  network::Pipe pipe;
  pipe.name = "P";
  pipe.upstream = "A";
  pipe.downstream = "B";
  pipe.diameter_m = 0.3;
  net.pipes = {pipe};
  return net;
}

network::Obstacle Something(network::ObstacleKind kind) {
  network::Obstacle obstacle;
  obstacle.kind = kind;
  obstacle.chainage_m = 2.0;
  return obstacle;
}

VoidField With(const network::Obstacle& obstacle) {
  network::Network net = Straight();
  net.pipes[0].obstacles = {obstacle};
  const Sewer sewer = BuildSewer(net);
  return VoidField(sewer.voids, sewer.solids);
}

Wall Nearest(const VoidField& field, const Vector3d& p_W) {
  return VoidField::NearestWall(field.Around(p_W, 0.2), p_W, 0.2);
}

TEST(Stone, IsABallAsHighAndWideAsItSays) {
  network::Obstacle stone = Something(network::ObstacleKind::kStone);
  stone.height_m = 0.020;
  stone.width_m = 0.080;
  // Radius: (40² + 20²) / (2 * 20) = 50 mm, so its middle lies 30 mm below the invert.
  const VoidField field = With(stone);
  EXPECT_NEAR(Nearest(field, {2.0, 0.0, -0.12}).distance_m, 0.010, 1e-9);
  EXPECT_NEAR(Nearest(field, {2.04, 0.0, -0.15}).distance_m, 0.0, 1e-9);
  // Seen along 3-4-5 from its middle: 60 - 50 mm.
  const Wall side = Nearest(field, {2.036, 0.0, -0.132});
  EXPECT_NEAR(side.distance_m, 0.010, 1e-9);
  EXPECT_TRUE(side.normal_W.isApprox(Vector3d(0.6, 0.0, 0.8), 1e-9));
}

TEST(Stone, LiesAtItsClockPosition) {
  network::Obstacle stone = Something(network::ObstacleKind::kStone);
  stone.height_m = 0.020;
  stone.width_m = 0.080;
  stone.clock_h = 3.0;  // right: -y
  EXPECT_NEAR(Nearest(With(stone), {2.0, -0.12, 0.0}).distance_m, 0.010, 1e-9);
}

TEST(Brick, HasFacesEdgesAndCorners) {
  network::Obstacle brick = Something(network::ObstacleKind::kBrick);
  brick.height_m = 0.060;
  brick.length_m = 0.200;
  brick.width_m = 0.100;
  const VoidField field = With(brick);  // x 1.9 to 2.1, y ±0.05, top at z = -0.09
  EXPECT_NEAR(Nearest(field, {2.0, 0.0, -0.08}).distance_m, 0.010, 1e-9);
  EXPECT_NEAR(Nearest(field, {2.103, 0.0, -0.086}).distance_m, 0.005, 1e-9);
  const Wall corner = Nearest(field, {2.102, 0.053, -0.084});
  EXPECT_NEAR(corner.distance_m, 0.007, 1e-9);  // 2² + 3² + 6² = 7²
  EXPECT_TRUE(corner.normal_W.isApprox(Vector3d(2.0, 3.0, 6.0) / 7.0, 1e-9));
}

TEST(MortarRidge, AsARingNarrowsThePipeWithSquareFaces) {
  network::Obstacle ring = Something(network::ObstacleKind::kMortarRidge);
  ring.height_m = 0.010;
  ring.length_m = 0.040;
  const VoidField field = With(ring);
  for (double angle = 0.0; angle < 6.0; angle += 0.5) {
    const Vector3d out(0.0, std::cos(angle), std::sin(angle));
    EXPECT_NEAR(Nearest(field, Vector3d(2.0, 0.0, 0.0) + 0.13 * out).distance_m, 0.010, 1e-9);
    // Past its edge at (2.02, 0.14): 3-4-5.
    EXPECT_NEAR(Nearest(field, Vector3d(2.023, 0.0, 0.0) + 0.136 * out).distance_m, 0.005, 1e-9);
  }
}

TEST(MortarRidge, AsAnArcEndsInRadialFaces) {
  network::Obstacle ridge = Something(network::ObstacleKind::kMortarRidge);
  ridge.height_m = 0.030;
  ridge.length_m = 0.040;
  ridge.width_m = 0.15 * pi / 3.0;  // 60° of arc: its ends lie at 5 and 7 o'clock
  const VoidField field = With(ridge);
  EXPECT_NEAR(Nearest(field, {2.0, 0.0, -0.11}).distance_m, 0.010, 1e-9);
  // 5 mm beside the end at 5 o'clock (-y side), half way up the ridge.
  const Vector3d end(0.0, -std::sin(pi / 6.0), -std::cos(pi / 6.0));
  const Vector3d beside(0.0, -std::cos(pi / 6.0), std::sin(pi / 6.0));
  const Wall wall = Nearest(field, Vector3d(2.0, 0.0, 0.0) + 0.135 * end + 0.005 * beside);
  EXPECT_NEAR(wall.distance_m, 0.005, 1e-9);
  EXPECT_TRUE(wall.normal_W.isApprox(beside, 1e-9));
  EXPECT_NEAR(Nearest(field, {2.0, 0.0, 0.13}).distance_m, 0.020, 1e-9);  // none at the crown
}

// Level across, 30 mm deep, with ends that rise 0.62487 in 1.
TEST(Sediment, IsLevelAcrossAndSlopesAtItsEnds) {
  network::Obstacle bed = Something(network::ObstacleKind::kSediment);
  bed.height_m = 0.030;
  bed.length_m = 1.0;
  const VoidField field = With(bed);  // feet at 1.5 and 2.5
  for (const double y : {-0.06, 0.0, 0.06}) {
    EXPECT_NEAR(Nearest(field, {2.0, y, -0.110}).distance_m, 0.010, 1e-9) << y;
  }
  const double slope = std::atan(kReposeSlope);
  EXPECT_NEAR(slope, 32.0 * pi / 180.0, 1e-4);
  const Vector3d normal(-std::sin(slope), 0.0, std::cos(slope));
  const Vector3d on_slope(1.5 + 0.015 / kReposeSlope, 0.0, -0.135);
  const Wall wall = Nearest(field, on_slope + 0.004 * normal);
  EXPECT_NEAR(wall.distance_m, 0.004, 1e-9);
  EXPECT_TRUE(wall.normal_W.isApprox(normal, 1e-9));
}

// On a fall of 5 % it is as deep at its upper end as at its lower, and level across.
TEST(Sediment, FollowsTheInvertOfASlopingPipe) {
  network::Network net = Straight();
  net.manholes[0].p_WM.z() += 0.05 * 4.8;
  network::Obstacle bed = Something(network::ObstacleKind::kSediment);
  bed.height_m = 0.030;
  bed.length_m = 1.0;
  net.pipes[0].obstacles = {bed};
  const Sewer sewer = BuildSewer(net);
  const VoidField field(sewer.voids, sewer.solids);
  for (const double chainage_m : {1.7, 2.3}) {
    const Eigen::Isometry3d X_WP = sewer.axes[0].PoseAt(chainage_m);
    for (const double left_m : {-0.06, 0.06}) {
      const Wall wall = Nearest(field, X_WP * Vector3d(0.0, left_m, -0.110));
      EXPECT_NEAR(wall.distance_m, 0.010, 1e-9) << chainage_m << " " << left_m;
      EXPECT_NEAR(wall.normal_W.y(), 0.0, 1e-9);
    }
  }
}

TEST(Stub, StandsIntoThePipeAndIsOpenInside) {
  network::Network net = Straight();
  network::Inlet inlet;
  inlet.chainage_m = 2.0;
  inlet.diameter_m = 0.128;  // its wall is 4 mm
  inlet.clock_h = 9.0;       // left: +y
  inlet.protrusion_m = 0.050;
  net.pipes[0].inlets = {inlet};
  const Sewer sewer = BuildSewer(net);
  const VoidField field(sewer.voids, sewer.solids);
  // Outside of it, 8 mm from a wall of 68 mm radius; in front of its rim at y = 0.1.
  EXPECT_NEAR(Nearest(field, {2.076, 0.11, 0.0}).distance_m, 0.008, 1e-9);
  EXPECT_NEAR(Nearest(field, {2.066, 0.09, 0.0}).distance_m, 0.010, 1e-9);
  // Inside of it, 14 mm from its bore, in the pipe and beyond the pipe's wall.
  EXPECT_NEAR(Nearest(field, {2.050, 0.12, 0.0}).distance_m, 0.014, 1e-9);
  EXPECT_NEAR(Nearest(field, {2.050, 0.30, 0.0}).distance_m, 0.014, 1e-9);
  EXPECT_NEAR(Nearest(field, {2.066, 0.12, 0.0}).distance_m, -0.002, 1e-9);
}

// Cameras see faces from the front alone.
TEST(Solids, TurnTheirFacesOutwards) {
  network::Network net = Straight();
  double at = 0.5;
  for (const auto kind : {network::ObstacleKind::kSediment, network::ObstacleKind::kStone,
                          network::ObstacleKind::kMortarRidge, network::ObstacleKind::kBrick}) {
    network::Obstacle obstacle = Something(kind);
    obstacle.chainage_m = at += 0.5;
    obstacle.height_m = 0.03;
    obstacle.length_m = 0.1;
    obstacle.width_m = kind == network::ObstacleKind::kSediment ? 0.0 : 0.1;
    net.pipes[0].obstacles.push_back(obstacle);
  }
  network::Inlet inlet;
  inlet.chainage_m = 3.5;
  inlet.diameter_m = 0.1;
  inlet.angle_rad = 1.0;
  inlet.protrusion_m = 0.05;
  net.pipes[0].inlets = {inlet};
  const Sewer sewer = BuildSewer(net);
  ASSERT_EQ(sewer.solids.size(), 5u);
  const SurfaceMesh mesh = Tessellate(sewer.voids, sewer.solids);
  std::vector<double> area(5, 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.owner[t] < sewer.voids.size()) continue;
    const std::size_t solid = mesh.owner[t] - sewer.voids.size();
    const auto& [a, b, c] = mesh.triangles[t];
    const Vector3d twice =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
    const Vector3d middle = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3.0;
    area[solid] += 0.5 * twice.norm();
    if (twice.norm() < 1e-7) continue;
    EXPECT_GT(SurfaceOf(sewer.solids[solid], middle + 1e-3 * twice.normalized()).distance_m, 0.0);
    EXPECT_GT(twice.normalized().dot(mesh.normals[a].cast<double>()), 0.98);
  }
  for (const double some : area) EXPECT_GT(some, 0.002);
}

// A wheel that rolls towards a brick meets the floor and the brick's edge.
TEST(Brick, IsMetByAWheelAtItsEdge) {
  network::Obstacle brick = Something(network::ObstacleKind::kBrick);
  brick.height_m = 0.010;
  brick.length_m = 0.200;
  brick.width_m = 0.100;
  const VoidField field = With(brick);
  const double ahead = std::sqrt(0.045 * 0.045 - 0.035 * 0.035);
  const Torus wheel{Vector3d(1.9 - ahead, 0.0, -0.105), Vector3d::UnitY(), 0.033, 0.012};
  const auto contacts = TorusContacts(field, wheel, 0.0005);
  ASSERT_EQ(contacts.size(), 2u);
  for (const WallContact& contact : contacts) EXPECT_NEAR(contact.distance_m, 0.0, 0.0003);
  const auto& edge = contacts[0].normal_W.x() < -0.1 ? contacts[0] : contacts[1];
  EXPECT_NEAR(edge.normal_W.z(), 35.0 / 45.0, 0.02);
}

}  // namespace
}  // namespace kantaro::sim
