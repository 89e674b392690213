#include "perception/inlet_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "perception/ring_contrast.hpp"
#include "perception/wall_motion.hpp"

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPipe_m = 0.15, kBranch_m = 0.065;  // radii
constexpr double kDegree = std::numbers::pi / 180.0;

const robot::Description& Robot() {
  static const robot::Description robot =
      robot::ReadDescription(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro");
  return robot;
}

/// A pipe along z about the camera, with a branch to the right, upwards by an angle.
struct Scene {
  double inlet_m{0.6};
  double up_rad{10.0 * kDegree};
  double paint{0.2};              ///< of the branch, against the wall's 1
  std::optional<double> patch_m;  ///< of a dark stain's middle on the wall, as big as a mouth

  [[nodiscard]] Vector3d Out() const { return {std::cos(up_rad), -std::sin(up_rad), 0.0}; }
};

/// Smooth blotches, a quarter of the light deep, some 2 cm wide.
double Texture(const Vector3d& p) {
  const double around = std::atan2(p.y(), p.x()) * kPipe_m;
  double sum = 0.0;
  for (int i = 1; i <= 6; ++i)
    sum += std::sin(170.0 * p.z() * std::cos(i) + 250.0 * around * std::sin(i) + 1.7 * i * i);
  return std::exp(0.1 * sum);
}

/// Light of the robot's lamps that comes back: Lambert's law, the inverse square, and lamps that
/// send as much as the cosine to where they shine.
double Light(const Vector3d& p, const Vector3d& normal) {
  double light = 0.0;
  for (const Vector3d& lamp : LampsBefore(Robot(), Robot().front_camera)) {
    const Vector3d to = (lamp - p).normalized();
    light += std::max(0.0, normal.dot(to)) * std::max(0.0, -to.z()) / (lamp - p).squaredNorm();
  }
  return light;
}

/// What a ray brings: followed in steps of half a millimetre, out of the pipe and into the branch.
double Follow(const Scene& scene, const Vector3d& ray) {
  const double enters = kPipe_m / ray.head<2>().norm();
  const Vector3d wall = enters * ray;
  const Vector3d out = scene.Out(), middle(0.0, 0.0, scene.inlet_m);
  const auto from_branch = [&](const Vector3d& p) {
    return Vector3d(p - middle - (p - middle).dot(out) * out);
  };
  if (wall.dot(out) > 0.0 && from_branch(wall).norm() < kBranch_m) {
    Vector3d p = wall;
    while (from_branch(p).norm() < kBranch_m) p += 0.0005 * ray.normalized();
    return scene.paint * Light(p, -from_branch(p).normalized());
  }
  const Vector3d inward(-wall.x() / kPipe_m, -wall.y() / kPipe_m, 0.0);
  double albedo = Texture(wall);
  if (scene.patch_m) {
    const Vector3d off = wall - Vector3d(0.0, 0.0, *scene.patch_m) - kPipe_m * out;
    albedo *= std::exp(-0.7 * std::exp(-off.squaredNorm() / (kBranch_m * kBranch_m)));
  }
  return albedo * Light(wall, inward);
}

/// @param camera_m  how far the camera has come; everything else stays
cv::Mat Draw(Scene scene, double camera_m) {
  const robot::Camera& camera = Robot().front_camera;
  scene.inlet_m -= camera_m;
  if (scene.patch_m) *scene.patch_m -= camera_m;
  cv::Mat grey(camera.height_px, camera.width_px, CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const Vector3d ray((x - camera.center_x_px) / camera.focal_px,
                         (y - camera.center_y_px) / camera.focal_px, 1.0);
      const double far_m = kPipe_m / std::max(1e-6, ray.head<2>().norm());
      const double signal = far_m > 3.0 ? 0.0 : 0.02 * Follow(scene, ray);
      const double root = std::sqrt(1.0 - std::exp(-signal));  // docs/cameras.md
      grey.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::lround(255.0 * (0.03 + 0.97 * root)));
    }
  }
  return grey;
}

RangedLandmark FindIn(const Scene& scene, double far_m = 1.0) {
  std::vector<InletSight> sights;
  for (const double camera_m : {-0.16, -0.08, 0.0})
    sights.push_back({LogBrightness(Draw(scene, camera_m)), {}, 0.0, -camera_m});
  const robot::Camera& camera = Robot().front_camera;
  return InletSearch(camera, LampsBefore(Robot(), camera), {2.0 * kPipe_m, 2.0 * kBranch_m}, false,
                     0.25, far_m)
      .Find(sights);
}

/// Brightness at a place of the mouth, and beside it along the pipe.
std::pair<int, int> InsideAndBeside(const Scene& scene) {
  const cv::Mat grey = Draw(scene, 0.0);
  const PipeWall wall(Robot().front_camera, kPipe_m, {});
  const auto at = [&](double distance_m) {
    const cv::Point2d p = wall.Project(distance_m, scene.Out().head<2>());
    return static_cast<int>(grey.at<std::uint8_t>(cv::Point(p)));
  };
  return {at(scene.inlet_m), at(scene.inlet_m - 1.3 * kBranch_m)};
}

// A pixel of the mouth's place is 4 to 6 mm of distance at 0.6 m.
TEST(InletSearch, FindsAMouthDarkerThanTheWall) {
  const Scene scene;
  const auto [inside, beside] = InsideAndBeside(scene);
  ASSERT_LT(inside, beside - 5);
  const RangedLandmark found = FindIn(scene);
  EXPECT_NEAR(found.distance_m, 0.6, 0.01);
  EXPECT_LT(found.deviation_m, 0.02);
}

TEST(InletSearch, FindsAMouthWhoseFarWallIsBrighterThanThePipes) {
  Scene scene;
  scene.paint = 0.8;
  const auto [inside, beside] = InsideAndBeside(scene);
  ASSERT_GT(inside, beside + 5);
  const RangedLandmark found = FindIn(scene);
  EXPECT_NEAR(found.distance_m, 0.6, 0.01);
  EXPECT_LT(found.deviation_m, 0.02);
}

TEST(InletSearch, TakesNoDarkStainForAMouth) {
  for (const double paint : {0.25, 0.4}) {
    Scene scene;
    scene.paint = paint;
    scene.patch_m = 0.38;  // half of the light
    EXPECT_NEAR(FindIn(scene).distance_m, 0.6, 0.02) << paint;
  }
}

TEST(InletSearch, LooksNoFartherThanItIsTold) { EXPECT_LT(FindIn(Scene{}, 0.5).distance_m, 0.55); }

// By hand: the camera on the axis sees the mouth's middle, at 45 degrees, along a ray that meets
// the far wall of the branch one branch radius behind the mouth's middle and as much farther out.
TEST(BranchMouth, SeesTheFarWallOfTheBranchThroughItsMiddle) {
  const BranchedPipe pipe{kPipe_m, kBranch_m, {Vector3d::Zero()}};
  const BranchMouth mouth(Robot().front_camera, pipe, {}, 0.0, kPipe_m, 0.0);
  const auto spot = mouth.At(0.0, 0.0);
  ASSERT_TRUE(spot);
  EXPECT_NEAR(spot->pixel.x, Robot().front_camera.center_x_px + Robot().front_camera.focal_px,
              1e-6);
  // Both are met at 45 degrees, the lamp too; only how far they are differs.
  EXPECT_NEAR(spot->branch - spot->wall, -2.0 * std::log((kPipe_m + kBranch_m) / kPipe_m), 1e-4);
}

TEST(BranchMouth, LightsAPlaceAlikeForBothCamerasOfAPair) {
  const BranchedPipe pipe{kPipe_m, kBranch_m, LampsBefore(Robot(), Robot().stereo_left)};
  const WallPose pose{{0.01, 0.02}, {0.0, 0.0}};
  const BranchMouth left(Robot().stereo_left, pipe, pose, 0.0, 0.5, 0.0),
      right(Robot().stereo_left, pipe, SeenFrom(pose, 0.06), 0.06, 0.5, 0.0);
  EXPECT_NEAR(left.At(1.2, 0.4)->wall, right.At(1.2, 0.4)->wall, 1e-9);
}

}  // namespace
}  // namespace kantaro::perception
