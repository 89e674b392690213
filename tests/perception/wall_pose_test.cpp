#include "perception/wall_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kantaro::perception {
namespace {

robot::Camera Pinhole() {
  robot::Camera camera;
  camera.width_px = 704;
  camera.height_px = 480;
  camera.focal_px = 610.0;
  camera.center_x_px = 351.5;
  camera.center_y_px = 239.5;
  return camera;
}

// On the axis a ring at distance d has the radius f R / d.
TEST(PipeWall, ProjectsRingsAsCircles) {
  const PipeWall wall(Pinhole(), 0.150, {});
  const cv::Point2d right = wall.Project(1.0, {1.0, 0.0});
  EXPECT_NEAR(right.x, 351.5 + 610.0 * 0.150, 1e-9);
  EXPECT_NEAR(right.y, 239.5, 1e-9);
  EXPECT_NEAR(wall.Project(0.5, {0.0, -1.0}).y, 239.5 - 610.0 * 0.300, 1e-9);
}

// An axis 10 mm to the right that leans 0.05 to the right is 60 mm to the right at 1 m.
TEST(PipeWall, FollowsALeaningAxis) {
  const PipeWall wall(Pinhole(), 0.150, {{0.010, 0.0}, {0.05, 0.0}});
  const cv::Point2d left = wall.Project(1.0, {-1.0, 0.0}), right = wall.Project(1.0, {1.0, 0.0});
  EXPECT_NEAR((left.x + right.x) / 2.0 - 351.5, 610.0 * 0.060, 1.0);
}

TEST(PipeWall, FindsThePointThatAPixelSees) {
  const PipeWall wall(Pinhole(), 0.125, {{0.012, -0.02}, {-0.03, 0.04}});
  for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const cv::Point2d pixel = wall.Project(0.6, direction);
    const Eigen::Vector3d point = wall.PointAt(pixel);
    EXPECT_NEAR(351.5 + 610.0 * point.x() / point.z(), pixel.x, 1e-6);
    // Its inward normal leads to the axis in one radius.
    const Eigen::Vector3d axis = point + 0.125 * wall.Inward(point);
    const Eigen::Vector3d along = Eigen::Vector3d(-0.03, 0.04, 1.0).normalized();
    EXPECT_NEAR((axis - Eigen::Vector3d(0.012, -0.02, 0.0)).cross(along).norm(), 0.0, 1e-9);
  }
}

/// Light of one lamp at the camera on an even wall.
cv::Mat LitWall(const robot::Camera& camera, const PipeWall& wall) {
  cv::Mat image(camera.height_px, camera.width_px, CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector3d point = wall.PointAt(cv::Point2d(x, y));
      const double range = point.norm();
      const double light =
          std::max(0.0, -wall.Inward(point).dot(point)) * point.z() / std::pow(range, 4.0);
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(255.0 * (1.0 - std::exp(-0.15 * light)));
    }
  }
  return image;
}

// A millimetre and a third of a degree: what the eight bits of a smooth picture leave.
TEST(WallPose, IsFoundFromTheFallOfLight) {
  robot::Camera camera = Pinhole();
  camera.sensor.vignetting = std::array{0.0, 0.0, 0.0};
  for (const WallPose& truth :
       {WallPose{{0.0, 0.0}, {0.0, 0.0}}, WallPose{{0.010, 0.0}, {0.03, 0.0}},
        WallPose{{-0.008, 0.006}, {0.01, -0.03}}}) {
    const cv::Mat image = LitWall(camera, PipeWall(camera, 0.150, truth));
    const WallPose found = FindWallPose(image, camera, {Eigen::Vector3d::Zero()}, 0.150, 0.0);
    constexpr double kAt_m = 0.5;  // where rings are looked for
    const Eigen::Vector2d there = found.off_m + kAt_m * found.lean;
    EXPECT_NEAR((there - truth.off_m - kAt_m * truth.lean).norm(), 0.0, 0.004);
  }
}

// 4 mm and 6 mrad, correlated by -0.85. At d the tangent's variance is (4 / d)² + 6² -
// 2 · 0.85 · 4 · 6 / d [mrad²]: 11.2 at 1 m, and least at 4 / (0.85 · 6) = 0.78 m.
TEST(PoseDoubt, IsLeastSomeWayAhead) {
  const PoseDoubt doubt = DoubtOfLight();
  EXPECT_NEAR(doubt.OfAxisAt(1.0)(0, 0), 11.2e-6, 1e-9);
  EXPECT_NEAR(doubt.OfAxisAt(1.0)(1, 1), 11.2e-6, 1e-9);
  EXPECT_NEAR(doubt.OfAxisAt(1.0)(0, 1), 0.0, 1e-12);
  EXPECT_LT(doubt.OfAxisAt(0.78)(0, 0), doubt.OfAxisAt(0.70)(0, 0));
  EXPECT_LT(doubt.OfAxisAt(0.78)(0, 0), doubt.OfAxisAt(0.86)(0, 0));
}

}  // namespace
}  // namespace kantaro::perception
