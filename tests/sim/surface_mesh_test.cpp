#include "sim/surface_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "sim/ray_caster.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

// x along the axis, z as near to `up` as can be.
Eigen::Isometry3d Frame(const Vector3d& p_W, const Vector3d& along, const Vector3d& up) {
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  X_WS.linear().col(0) = along.normalized();
  X_WS.linear().col(1) = up.cross(along).normalized();
  X_WS.linear().col(2) = X_WS.linear().col(0).cross(X_WS.linear().col(1));
  X_WS.translation() = p_W;
  return X_WS;
}

VoidPrimitive Tube(const Vector3d& p_W, const Vector3d& along, double length, double radius,
                   double curvature = 0.0) {
  VoidPrimitive tube;
  tube.X_WS = Frame(p_W, along, Vector3d::UnitZ());
  tube.length_m = length;
  tube.radius_m = radius;
  tube.curvature = curvature;
  return tube;
}

VoidPrimitive Channel(const Vector3d& p_W, const Vector3d& along, double length, double radius,
                      double wall_height, double curvature = 0.0) {
  VoidPrimitive channel = Tube(p_W, along, length, radius, curvature);
  channel.profile = Profile::kU;
  channel.wall_height_m = wall_height;
  channel.feature = Feature::kChannel;
  return channel;
}

VoidPrimitive Shaft(const Vector3d& p_W, double height, double radius) {
  VoidPrimitive shaft = Tube(Vector3d::Zero(), Vector3d::UnitX(), height, radius);
  shaft.X_WS = Frame(p_W, Vector3d::UnitZ(), -Vector3d::UnitX());
  shaft.feature = Feature::kShaft;
  return shaft;
}

std::vector<VoidPrimitive> Tee() {
  return {Tube({-1.0, 0.0, 0.0}, Vector3d::UnitX(), 2.0, 0.15),
          Tube({0.0, 0.0, 0.0}, {0.3, 1.0, 0.2}, 1.0, 0.10)};
}

// A manhole over a channel that runs through and one that turns into it; three pipes lead away, one
// of them round a bend and over a joint, a house connection joins it. Axes lie at height 0.
std::vector<VoidPrimitive> Manhole() {
  const double r = 0.15;
  const double turn = 0.3;  // radius of the curved channel
  std::vector<VoidPrimitive> field{
      Shaft({0.0, 0.0, r}, 2.0, 0.4),
      Channel({-0.45, 0.0, 0.0}, Vector3d::UnitX(), 0.9, r, r + 0.01),
      Channel({-0.45, 0.0, 0.0}, Vector3d::UnitX(), 0.15, r, r + 0.01),
      Channel({-turn, 0.0, 0.0}, Vector3d::UnitX(), turn * pi / 2.0, r, r + 0.01, 1.0 / turn),
      Channel({0.0, turn, 0.0}, Vector3d::UnitY(), 0.15, r, r + 0.01),
      Tube({-3.0, 0.0, 0.0}, Vector3d::UnitX(), 2.65, r),
      Tube({0.35, 0.0, 0.0}, Vector3d::UnitX(), 2.0, r),
      Tube({2.35, 0.0, 0.0}, Vector3d::UnitX(), 0.45 * pi / 2.0, r, -1.0 / 0.45),
      Tube({2.80, -0.45, 0.0}, -Vector3d::UnitY(), 1.0, r),
      Tube({0.0, 0.35, 0.0}, Vector3d::UnitY(), 1.5, r),
      Tube({1.496, 0.0, 0.0}, Vector3d::UnitX(), 0.008, r + 0.006),
      Tube({-1.5, 0.0, 0.0}, Vector3d(0.0, -0.8, 0.6), 0.6, 0.06)};
  return field;
}

double Inside(const std::vector<VoidPrimitive>& field, const Vector3d& p_W) {
  double inside = -1e9;
  for (const VoidPrimitive& primitive : field) {
    inside = std::max(inside, InsideDistance(primitive, p_W));
  }
  return inside;
}

std::array<Vector3d, 3> Corners(const SurfaceMesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

double Area(const SurfaceMesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = Corners(mesh, i);
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

Vector3d PointInside(const std::vector<VoidPrimitive>& field, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  while (true) {
    const VoidPrimitive& primitive =
        field[static_cast<std::size_t>(share(random) * static_cast<double>(field.size()))];
    const double r = primitive.radius_m;
    const Vector3d p_W =
        FromSweep(primitive, {share(random) * primitive.length_m, (2.0 * share(random) - 1.0) * r,
                              (2.0 * share(random) - 1.0) * r});
    if (Inside(field, p_W) > 1e-3) return p_W;
  }
}

Vector3d RandomDirection(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

// From inside, every ray meets the wall, where the field says it is, with nothing before it.
void ExpectClosedAndTrue(const std::vector<VoidPrimitive>& field, int rays) {
  const RayCaster caster(Tessellate(field));
  std::mt19937_64 random(5);
  for (int i = 0; i < rays; ++i) {
    const Vector3d p_W = PointInside(field, random);
    const Vector3d direction = RandomDirection(random);
    const auto hit = caster.Cast(p_W, direction, 10.0);
    ASSERT_TRUE(hit) << "from " << p_W.transpose() << " along " << direction.transpose();
    ASSERT_NEAR(Inside(field, p_W + hit->range_m * direction), 0.0, 1e-3) << p_W.transpose();
    for (double range = 0.0; range < hit->range_m; range += 0.01) {
      ASSERT_GT(Inside(field, p_W + range * direction), -1e-3) << "the ray passed through a wall";
    }
  }
}

// Each edge within a primitive borders one triangle only where the surface ends (at another's), so
// the edges that border one triangle lie on another primitive's surface.
void ExpectConforming(const std::vector<VoidPrimitive>& field, const SurfaceMesh& mesh) {
  using Key = std::array<double, 3>;
  std::map<std::tuple<std::uint32_t, Key, Key>, int> uses;
  const auto key = [&](std::uint32_t v) {
    return Key{mesh.positions[v].x(), mesh.positions[v].y(), mesh.positions[v].z()};
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      Key a = key(mesh.triangles[i][k]);
      Key b = key(mesh.triangles[i][(k + 1) % 3]);
      if (b < a) std::swap(a, b);
      ++uses[{mesh.owner[i], a, b}];
    }
  }
  for (const auto& [edge, count] : uses) {
    const auto& [owner, a, b] = edge;
    EXPECT_LE(count, 2);
    if (count > 1) continue;
    const Vector3d middle(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]));
    double nearest = 1.0;
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (i != owner) nearest = std::min(nearest, std::abs(InsideDistance(field[i], middle)));
    }
    ASSERT_LT(nearest, 1e-3) << "owner " << owner << " at " << middle.transpose();
  }
}

TEST(SurfaceMeshTest, AStraightPipeHasTheAreaOfACylinderAndTwoDiscs) {
  const SurfaceMesh mesh = Tessellate(std::vector{Tube({1, 2, 3}, {1, 1, 0.1}, 2.0, 0.15)});
  EXPECT_NEAR(Area(mesh), 2.0 * pi * 0.15 * 2.0 + 2.0 * pi * 0.15 * 0.15, 0.003 * 2.0);
  // Two cells of a metre; the least multiple of 4 with facets true to 0.1 mm is 64.
  EXPECT_EQ(mesh.triangles.size(), 2U * 64U * 2U + 2U * 62U);
}

TEST(SurfaceMeshTest, ABendHasTheAreaPappusGives) {
  const double bend = 0.45;
  const SurfaceMesh mesh =
      Tessellate(std::vector{Tube({1, 2, 3}, {0, 1, 0}, bend * pi / 2.0, 0.15, 1.0 / bend)});
  const double side = 2.0 * pi * 0.15 * bend * pi / 2.0;
  EXPECT_NEAR(Area(mesh), side + 2.0 * pi * 0.15 * 0.15, 0.003 * side);
}

TEST(SurfaceMeshTest, AChannelHasSidesATopAndTwoCaps) {
  const SurfaceMesh mesh = Tessellate(std::vector{Channel({1, 2, 3}, {0, 1, 0}, 0.5, 0.1, 0.12)});
  const double around = pi * 0.1 + 2.0 * 0.12 + 0.2;
  const double cap = 0.5 * pi * 0.1 * 0.1 + 0.2 * 0.12;
  EXPECT_NEAR(Area(mesh), around * 0.5 + 2.0 * cap, 0.003 * around * 0.5);
}

TEST(SurfaceMeshTest, FacesTurnAndNormalsPointIntoTheVoid) {
  const auto field = Manhole();
  const SurfaceMesh mesh = Tessellate(field);
  int mistaken = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = Corners(mesh, i);
    const Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-7) continue;  // too thin to have a direction
    for (const std::uint32_t v : mesh.triangles[i]) {
      ASSERT_NEAR(mesh.normals[v].norm(), 1.0F, 1e-5F);
      if (normal.normalized().dot(mesh.normals[v].cast<double>()) < 0.98) ++mistaken;
    }
    const Vector3d above = (a + b + c) / 3.0 + 1e-3 * normal.normalized();
    EXPECT_GT(InsideDistance(field[mesh.owner[i]], above), 0.0);
  }
  EXPECT_EQ(mistaken, 0);
}

TEST(SurfaceMeshTest, EveryPointOfATeeLiesOnTheBoundaryOfTheUnion) {
  const auto field = Tee();
  const SurfaceMesh mesh = Tessellate(field);
  for (const auto& p : mesh.positions) {
    EXPECT_NEAR(Inside(field, p), 0.0, 0.25e-3);
  }
}

TEST(SurfaceMeshTest, RandomPointsOfTheWallAgreeWithTheField) {
  const auto field = Manhole();
  const SurfaceMesh mesh = Tessellate(field);
  std::vector<double> areas;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = Corners(mesh, i);
    areas.push_back((b - a).cross(c - a).norm());
  }
  std::mt19937_64 random(3);
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const auto [a, b, c] = Corners(mesh, pick(random));
    const double s = std::sqrt(share(random));
    const double t = share(random);
    const Vector3d p = (1.0 - s) * a + s * (1.0 - t) * b + s * t * c;
    EXPECT_NEAR(Inside(field, p), 0.0, 0.25e-3) << p.transpose();
  }
}

TEST(SurfaceMeshTest, ATeeIsClosed) { ExpectClosedAndTrue(Tee(), 20000); }

TEST(SurfaceMeshTest, AManholeWithItsPipesIsClosed) { ExpectClosedAndTrue(Manhole(), 20000); }

TEST(SurfaceMeshTest, NoVertexLiesInsideANeighboursEdge) {
  ExpectConforming(Tee(), Tessellate(Tee()));
  ExpectConforming(Manhole(), Tessellate(Manhole()));
}

TEST(SurfaceMeshTest, PipesThatMeetEndToEndLeaveNoMembraneAndNoSplinters) {
  const auto field = std::vector{Tube({0, 0, 0}, {1, 0.2, 0.02}, 0.8, 0.15),
                                 Tube({0, 0, 0}, {-1, -0.2, -0.02}, 0.8, 0.15)};
  const SurfaceMesh mesh = Tessellate(field);
  EXPECT_EQ(mesh.triangles.size(), 2U * (64U * 2U + 62U));
  const auto hit =
      RayCaster(mesh).Cast({-0.5, -0.1, -0.01}, Vector3d(1, 0.2, 0.02).normalized(), 5);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 0.8 + std::hypot(0.5, 0.1, 0.01), 1e-5);
}

TEST(SurfaceMeshTest, AWallOfMicrometresBetweenTwoCapsIsNoWall) {
  const auto field = std::vector{Tube({0, 0, 0}, {1, 0, 0}, 0.8, 0.15),
                                 Tube({-5e-6, 0, 0}, {-1, 0, 0}, 0.8, 0.15)};
  const auto hit = RayCaster(Tessellate(field)).Cast({-0.5, 0.01, 0.02}, Vector3d::UnitX(), 5);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 1.3, 1e-5);
}

TEST(SurfaceMeshTest, OfCoincidentSurfacesOneStays) {
  // The same channel three times, the last two only in part.
  const auto once = Tessellate(std::vector{Channel({0, 0, 0}, {1, 0, 0}, 1.0, 0.15, 0.2)});
  const auto thrice = Tessellate(std::vector{Channel({0, 0, 0}, {1, 0, 0}, 1.0, 0.15, 0.2),
                                             Channel({0, 0, 0}, {1, 0, 0}, 1.0, 0.15, 0.2),
                                             Channel({0.2, 0, 0}, {1, 0, 0}, 0.8, 0.15, 0.2)});
  EXPECT_NEAR(Area(once), Area(thrice), 1e-5);
  EXPECT_EQ(once.triangles, thrice.triangles);
}

TEST(SurfaceMeshTest, ATubeThatEndsInAChannelKeepsWhatStandsOutOfIt) {
  // They share the last 0.1 m of the tube; the channel's sides rise h above the axis.
  const double r = 0.15;
  const double h = 0.05;
  const auto field =
      std::vector{Tube({0, 0, 0}, {1, 0, 0}, 1.0, r), Channel({0.9, 0, 0}, {1, 0, 0}, 1.0, r, h)};
  const double chord = 2.0 * std::sqrt(r * r - h * h);  // of the circle at height h
  const double arc_above = (pi - 2.0 * std::asin(h / r)) * r;
  const double half_circle = 0.5 * pi * r * r;
  const double profile = half_circle + 2.0 * r * h;
  const double shared = half_circle + r * r * std::asin(h / r) + h * 0.5 * chord;

  const double tube_alone = 0.9 * 2.0 * pi * r + 2.0 * half_circle;
  const double both = 0.1 * (pi * r + arc_above + 2.0 * h + 2.0 * r - chord);
  const double channel_alone = 0.9 * (pi * r + 2.0 * h + 2.0 * r) + profile;
  const double steps = (2.0 * half_circle - shared) + (profile - shared);
  EXPECT_NEAR(Area(Tessellate(field)), tube_alone + both + channel_alone + steps, 2e-3);
}

TEST(SurfaceMeshTest, TextureCoordinatesMeasureChainageAndArcClockwiseFromTheCrown) {
  VoidPrimitive tube = Tube({0, 0, 0}, {1, 0, 0}, 0.5, 0.15);
  tube.start_chainage_m = 7.0;
  const SurfaceMesh mesh = Tessellate(std::vector{tube});
  bool seen = false;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    // Three o'clock, looking along x, is to the right: -y.
    if (std::abs(mesh.normals[i].x()) > 0.5F || mesh.positions[i].y() > -0.15) continue;
    seen = true;
    EXPECT_NEAR(mesh.surface_m[i].x(), 7.0 + mesh.positions[i].x(), 1e-5);
    EXPECT_NEAR(mesh.surface_m[i].y(), 0.15 * pi / 2.0, 1e-5);
  }
  EXPECT_TRUE(seen);
}

TEST(SurfaceMeshTest, TextureIsNeverStretched) {
  const auto field = Manhole();
  const SurfaceMesh mesh = Tessellate(field);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (field[mesh.owner[i]].curvature != 0.0) continue;  // the inside of a bend is shorter
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = mesh.triangles[i][k];
      const auto b = mesh.triangles[i][(k + 1) % 3];
      EXPECT_NEAR((mesh.positions[a] - mesh.positions[b]).norm(),
                  (mesh.surface_m[a] - mesh.surface_m[b]).norm(), 0.5e-3);
    }
  }
}

TEST(SurfaceMeshTest, AMapsCoordinatesCostNoPrecision) {
  auto field = Manhole();
  const Vector3d far(512345.25, 5712345.5, 87.125);
  for (VoidPrimitive& primitive : field) primitive.X_WS.translation() += far;
  const SurfaceMesh mesh = Tessellate(field);
  const SurfaceMesh near = Tessellate(Manhole());
  EXPECT_NEAR(Area(mesh), Area(near), 1e-5);
  ExpectClosedAndTrue(field, 2000);
}

TEST(SurfaceMeshTest, TwoCallsAreEqualToTheBit) {
  const SurfaceMesh a = Tessellate(Manhole());
  const SurfaceMesh b = Tessellate(Manhole());
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.surface_m, b.surface_m);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.owner, b.owner);
}

TEST(SurfaceMeshTest, ExtractsTheTrianglesOfARangeOfOwners) {
  const SurfaceMesh mesh = Tessellate(Tee());
  const SurfaceMesh branch = Extract(mesh, 1, 2);
  EXPECT_THAT(branch.owner, testing::Each(1U));
  EXPECT_EQ(branch.triangles.size(),
            static_cast<std::size_t>(std::count(mesh.owner.begin(), mesh.owner.end(), 1U)));
  EXPECT_LT(branch.positions.size(), mesh.positions.size());
  EXPECT_NEAR(Area(branch) + Area(Extract(mesh, 0, 1)), Area(mesh), 1e-9);
  EXPECT_TRUE(Extract(mesh, 2, 9).triangles.empty());
}

TEST(SurfaceMeshTest, RefusesSizesThatMakeNoSense) {
  EXPECT_THROW((void)Tessellate(std::vector{Tube({0, 0, 0}, {1, 0, 0}, 0.0, 0.15)}),
               std::invalid_argument);
  EXPECT_THROW((void)Tessellate(std::vector{Tube({0, 0, 0}, {1, 0, 0}, 1.0, 0.15, 7.0)}),
               std::invalid_argument);
  EXPECT_THROW((void)Tessellate(Tee(), {.tolerance_m = 0.0}), std::invalid_argument);
  EXPECT_THROW((void)Tessellate(Tee(), {.max_cell_m = std::nan("")}), std::invalid_argument);
  EXPECT_TRUE(Tessellate({}).triangles.empty());
}

}  // namespace
}  // namespace kantaro::sim
