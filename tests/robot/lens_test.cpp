#include "robot/lens.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "robot_files.hpp"

namespace kantaro::robot {
namespace {

using Eigen::Vector2d;

std::vector<Lens> Lenses() {
  const Description shipped = Files().Parse();
  return {*shipped.front_camera.lens,
          *shipped.stereo_left.lens,
          *shipped.stereo_right.lens,
          {400.0, 390.0, 310.0, 250.0, -0.28, 0.11, 0.002, -0.003, -0.02},
          {400.0, 390.0, 310.0, 250.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
}

Vector2d ByOpenCv(const Lens& lens, const Vector2d& direction) {
  const cv::Matx33d K(lens.focal_x_px, 0, lens.center_x_px, 0, lens.focal_y_px, lens.center_y_px, 0,
                      0, 1);
  const cv::Vec<double, 5> D(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
  std::vector<cv::Point2d> seen;
  cv::projectPoints(std::vector{cv::Point3d(direction.x(), direction.y(), 1.0)},
                    cv::Vec3d::all(0.0), cv::Vec3d::all(0.0), K, D, seen);
  return {seen[0].x, seen[0].y};
}

TEST(Lens, ProjectsAsOpenCvDoes) {
  for (const Lens& lens : Lenses()) {
    for (double x = -0.6; x <= 0.6; x += 0.1) {
      for (double y = -0.45; y <= 0.45; y += 0.09) {
        EXPECT_LT((Project(lens, {x, y}) - ByOpenCv(lens, {x, y})).norm(), 1e-9);
      }
    }
  }
}

TEST(Lens, UnprojectsWhatItProjects) {
  for (const Lens& lens : Lenses()) {
    for (double x = -0.65; x <= 0.65; x += 0.13) {
      for (double y = -0.48; y <= 0.48; y += 0.12) {
        EXPECT_LT((Unproject(lens, Project(lens, {x, y})) - Vector2d(x, y)).norm(), 1e-12);
      }
    }
  }
}

// r(1 − r²) turns back at r = 1/√3 = 0.577.
TEST(Lens, FoldsWhereItsRadiusTurnsBack) {
  Lens lens{500.0, 500.0, 320.0, 240.0};
  EXPECT_FALSE(Folds(lens, 5.0));
  lens.k1 = -1.0;
  EXPECT_FALSE(Folds(lens, 0.570));
  EXPECT_TRUE(Folds(lens, 0.585));
}

}  // namespace
}  // namespace kantaro::robot
