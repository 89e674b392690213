#include "scenarios/experiments/pipe_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "base/input_error.hpp"
#include "base/random.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Vector3d;

/// Points of a cylinder that leans by 0.1 and passes 10 mm beside the camera, and as many that lie
/// anywhere.
std::vector<Vector3d> Scan(double radius_m, double noise_m) {
  RandomStream random(5, "scan");
  const Vector3d along = Vector3d(0.1, -0.05, -1.0).normalized();
  const Vector3d left = Vector3d::UnitY().cross(along).normalized(), up = along.cross(left);
  std::vector<Vector3d> points;
  for (int i = 0; i < 6000; ++i) {
    const double angle = random.Uniform(0.0, 2.0 * std::numbers::pi);
    points.emplace_back(Vector3d(0.01, 0.0, 0.0) + random.Uniform(0.15, 0.5) * along +
                        (radius_m + random.Normal(noise_m)) *
                            (std::cos(angle) * left + std::sin(angle) * up));
    points.emplace_back(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4),
                        random.Uniform(-0.6, -0.1));
  }
  return points;
}

TEST(FitPipe, FindsTheCylinderAmongHalfOutliers) {
  const PipeScan scan = FitPipe(Scan(0.1, 0.001), 1);
  EXPECT_NEAR(scan.radius_m, 0.1, 0.0004);
  EXPECT_NEAR(scan.residual_m, 0.001, 0.0003);
  EXPECT_GT(scan.X_DP.linear().col(0).dot(Vector3d(0.1, -0.05, -1.0).normalized()),
            std::cos(0.005));
}

TEST(RobustDeviation, IsTheStandardOneOfNormalValuesWhateverTheFewDo) {
  RandomStream random(1, "values");
  std::vector<double> values(5000);
  for (double& value : values) value = 3.0 + random.Normal(2.0);
  for (int i = 0; i < 250; ++i) values[static_cast<std::size_t>(i)] = 1e6;
  EXPECT_NEAR(RobustDeviation(values), 2.0, 0.2);
}

TEST(ReadPly, ReadsVerticesAndRefusesTheRest) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "scan.ply";
  const auto write = [&](const std::string& count) {
    std::ofstream out(file, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << count
        << "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    const double p[] = {1.0, 2.0, -3.0};
    out.write(reinterpret_cast<const char*>(p), sizeof p);
  };
  write("1");
  ASSERT_EQ(ReadPly(file).size(), 1u);
  EXPECT_EQ(ReadPly(file)[0], Vector3d(1.0, 2.0, -3.0));
  write("2");
  EXPECT_THROW(static_cast<void>(ReadPly(file)), InputError);
  std::ofstream(file) << "nothing";
  EXPECT_THROW(static_cast<void>(ReadPly(file)), InputError);
}

}  // namespace
}  // namespace kantaro::scenarios
