#include "sim/ray_caster.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "base/random.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

std::vector<VoidPrimitive> Pipe() {
  VoidPrimitive pipe;
  pipe.length_m = 4.0;
  pipe.radius_m = 0.15;
  return {pipe};
}

TEST(RayCasterTest, FindsTheRadiusAllAroundTheAxis) {
  const RayCaster caster(Tessellate(Pipe()));
  for (int i = 0; i < 360; ++i) {
    const double angle = i * std::numbers::pi / 180.0;
    const Vector3d direction(0.0, std::cos(angle), std::sin(angle));
    const auto hit = caster.Cast({1.3, 0.0, 0.0}, direction, 1.0);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->range_m, 0.15, 0.1e-3);
    EXPECT_NEAR(hit->normal_W.dot(direction), -1.0, 1e-3);
    EXPECT_EQ(hit->owner, 0U);
  }
}

TEST(RayCasterTest, ASlantingRayGoesAsFarAsGeometrySays) {
  const RayCaster caster(Tessellate(Pipe()));
  const auto hit = caster.Cast({0.5, 0.0, 0.0}, Vector3d(3.0, 0.0, -0.15).normalized(), 9.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, std::hypot(3.0, 0.15), 2e-3);  // 0.1 mm of radius is 2 mm along
}

TEST(RayCasterTest, SeesNothingBeyondItsRange) {
  const RayCaster caster(Tessellate(Pipe()));
  EXPECT_FALSE(caster.Cast({1.0, 0.0, 0.0}, Vector3d::UnitX(), 2.99));
  EXPECT_TRUE(caster.Cast({1.0, 0.0, 0.0}, Vector3d::UnitX(), 3.01));
}

TEST(RayCasterTest, NoRaySlipsBetweenTrianglesThatShareAnEdge) {
  const SurfaceMesh mesh = Tessellate(Pipe());
  const RayCaster caster(mesh);
  const Vector3d p_W(1.234, 0.012, -0.034);
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& a = mesh.positions[triangle[i]];
      const Vector3d& b = mesh.positions[triangle[(i + 1) % 3]];
      for (const double share : {0.0, 0.1, 0.37, 0.5, 0.82}) {
        const Vector3d aim = a + share * (b - a) - p_W;
        const auto hit = caster.Cast(p_W, aim.normalized(), 9.0);
        ASSERT_TRUE(hit);
        ASSERT_NEAR(hit->range_m, aim.norm(), 1e-4);
      }
    }
  }
}

TEST(RayCasterTest, HitsTheWallFromTheGroundToo) {
  const RayCaster caster(Tessellate(Pipe()));
  const auto hit = caster.Cast({1.0, 0.0, 1.0}, -Vector3d::UnitZ(), 9.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 0.85, 0.1e-3);
  EXPECT_NEAR(hit->normal_W.z(), -1.0, 1e-3);
}

TEST(RayCasterTest, ABatchAnswersAsSingleRaysDo) {
  const RayCaster caster(Tessellate(Pipe()));
  std::vector<Ray> rays;
  for (int i = 0; i < 100; ++i) {
    rays.push_back({{0.04 * i, 0.01, 0.02}, Vector3d(std::cos(i), std::sin(i), 0.3).normalized()});
  }
  std::vector<std::optional<RayHit>> hits(rays.size());
  caster.Cast(rays, 0.4, hits);
  int misses = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto alone = caster.Cast(rays[i].p_WR, rays[i].direction_W, 0.4);
    ASSERT_EQ(hits[i].has_value(), alone.has_value());
    if (!alone) {
      ++misses;
      continue;
    }
    EXPECT_EQ(hits[i]->range_m, alone->range_m);
    EXPECT_EQ(hits[i]->normal_W, alone->normal_W);
  }
  EXPECT_GT(misses, 0);
  EXPECT_THROW(caster.Cast(rays, 0.4, std::span(hits).first(3)), std::invalid_argument);
}

// Embree takes 4, 8 or 16 numbers at once, fused or not, as the processor can.
TEST(RayCasterTest, HitsAreTheSameWhicheverInstructionsEmbreeUses) {
  const SurfaceMesh mesh = Tessellate(Pipe());
  const RayCaster usual(mesh);
  const RayCaster narrow(mesh, "sse2");
  RandomStream random(1, "rays");
  for (int i = 0; i < 20000; ++i) {
    const Vector3d p_W(random.Uniform(0.5, 3.5), random.Uniform(-0.1, 0.1),
                       random.Uniform(-0.1, 0.1));
    const Vector3d direction =
        Vector3d(random.Normal(1.0), random.Normal(1.0), random.Normal(1.0)).normalized();
    const auto one = usual.Cast(p_W, direction, 0.5);
    const auto other = narrow.Cast(p_W, direction, 0.5);
    ASSERT_EQ(one.has_value(), other.has_value());
    if (!one) continue;
    ASSERT_EQ(one->range_m, other->range_m);
    ASSERT_EQ(one->normal_W, other->normal_W);
  }
}

TEST(RayCasterTest, AnEmptyMeshHasNoWalls) {
  EXPECT_FALSE(RayCaster(SurfaceMesh{}).Cast(Vector3d::Zero(), Vector3d::UnitX(), 9.0));
}

}  // namespace
}  // namespace kantaro::sim
