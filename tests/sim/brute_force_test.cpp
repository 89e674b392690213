// Contact against sampled geometry, in random sewers with all that may be in them. KANTARO_POSES
// says how many poses; 100,000 take some minutes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/random.hpp"
#include "pose_errors.hpp"
#include "random_sewer.hpp"
#include "sampled_sewer.hpp"
#include "sim/void_field.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

void Print(const char* what, const std::vector<double>& errors) {
  fmt::print("{}: {} poses, error in mm: median {:.4f}, 99 % {:.4f}, 99.9 % {:.4f}, most {:.4f}\n",
             what, errors.size(), 1e3 * Quantile(errors, 0.5), 1e3 * Quantile(errors, 0.99),
             1e3 * Quantile(errors, 0.999), 1e3 * Quantile(errors, 1.0));
}

TEST(Contact, IsWhereTheGeometryIs) {
  const char* wanted = std::getenv("KANTARO_POSES");
  const int poses = wanted != nullptr ? std::atoi(wanted) : 1200;
  constexpr int kEach = 400;
  const PoseErrors errors = MeasurePoseErrors(1, std::max(1, poses / kEach), kEach);
  Print("spheres within 20 mm", errors.near);
  Print("spheres at 20 to 60 mm", errors.far);
  Print("wheels", errors.wheels);
  EXPECT_LT(Quantile(errors.near, 0.999), 1e-4);
  EXPECT_LT(Quantile(errors.near, 1.0), 1e-3) << errors.worst;
  EXPECT_LT(Quantile(errors.wheels, 0.999), 1e-3);
  EXPECT_LT(Quantile(errors.wheels, 1.0), 2e-3) << errors.worst;
  EXPECT_LT(Quantile(errors.far, 0.99), 2e-3);
}

// What lies in the ground has no positive distance, and what is free no negative one.
TEST(Contact, KnowsGroundFromVoid) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    const Sewer sewer = BuildSewer(RandomNetwork(seed, 4));
    const VoidField field(sewer.voids, sewer.solids);
    const SampledSewer sampled(sewer, 0.02);
    RandomStream random(seed, "ground");
    for (int i = 0; i < 5000; ++i) {
      const Vector3d p = sampled.Sample(random.Index(sampled.size())) +
                         Vector3d(random.Normal(0.02), random.Normal(0.02), random.Normal(0.02));
      const double distance = VoidField::NearestWall(field.Around(p, 0.1), p, 0.1).distance_m;
      EXPECT_EQ(distance > 0.0, sampled.IsFree(p)) << distance << " at " << p.transpose();
    }
  }
}

// Eight pipes in one manhole, with all of their channels.
TEST(Contact, TakesAsManyPipesAsMeet) {
  network::Network net;
  network::Manhole hub;
  hub.name = "hub";
  net.manholes.push_back(hub);
  for (int i = 0; i < 8; ++i) {
    network::Manhole end;
    end.name = fmt::format("M{}", i);
    end.p_WM = 4.0 * Vector3d(std::cos(i * 0.785), std::sin(i * 0.785), 0.0);
    net.manholes.push_back(end);
    network::Pipe pipe;
    pipe.name = fmt::format("P{}", i);
    pipe.upstream = "hub";
    pipe.downstream = end.name;
    pipe.diameter_m = 0.25;
    net.pipes.push_back(pipe);
  }
  const Sewer sewer = BuildSewer(net);
  const VoidField field(sewer.voids, sewer.solids);
  const SampledSewer sampled(sewer);
  RandomStream random(1, "hub");
  for (int i = 0; i < 300; ++i) {
    const Vector3d p(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), random.Uniform(0, 0.3));
    if (!sampled.IsFree(p)) continue;
    const double truth = sampled.Distance(p, 0.05);
    EXPECT_NEAR(VoidField::NearestWall(field.Around(p, 0.05), p, 0.05).distance_m, truth, 1e-3)
        << p.transpose();
  }
}

}  // namespace
}  // namespace kantaro::sim
