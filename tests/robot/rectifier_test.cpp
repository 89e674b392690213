#include "robot/rectifier.hpp"

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "robot_files.hpp"

namespace kantaro::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBaseline_m = 0.060;

/// A picture of soft round spots, by OpenCV's camera model.
cv::Mat Spots(const Camera& camera, const std::vector<Vector3d>& points_C) {
  constexpr double kWidth_px = 2.0;
  const Lens lens = LensOf(camera);
  const cv::Matx33d K(lens.focal_x_px, 0, lens.center_x_px, 0, lens.focal_y_px, lens.center_y_px, 0,
                      0, 1);
  const cv::Vec<double, 5> D(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
  cv::Mat image = cv::Mat::zeros(camera.height_px, camera.width_px, CV_8UC1);
  for (const Vector3d& p : points_C) {
    std::vector<cv::Point2d> seen;
    cv::projectPoints(std::vector{cv::Point3d(p.x(), p.y(), p.z())}, cv::Vec3d::all(0.0),
                      cv::Vec3d::all(0.0), K, D, seen);
    for (int row = 0; row < image.rows; ++row) {
      for (int col = 0; col < image.cols; ++col) {
        const double far2 = std::pow(col - seen[0].x, 2.0) + std::pow(row - seen[0].y, 2.0);
        if (far2 < 100.0)
          image.at<std::uint8_t>(row, col) = static_cast<std::uint8_t>(
              std::lround(200.0 * std::exp(-far2 / (2.0 * kWidth_px * kWidth_px))));
      }
    }
  }
  return image;
}

/// Middle of the spot near a place.
Vector2d SpotNear(const cv::Mat& image, const Vector2d& p_px) {
  constexpr int kReach = 12;
  Vector2d sum = Vector2d::Zero();
  double weight = 0.0;
  const int x = static_cast<int>(std::lround(p_px.x())),
            y = static_cast<int>(std::lround(p_px.y()));
  for (int row = std::max(0, y - kReach); row <= std::min(image.rows - 1, y + kReach); ++row) {
    for (int col = std::max(0, x - kReach); col <= std::min(image.cols - 1, x + kReach); ++col) {
      const double light = image.at<std::uint8_t>(row, col);
      sum += light * Vector2d(col, row);
      weight += light;
    }
  }
  return sum / weight;
}

/// Points of the rectified left frame, with room between them in both pictures.
std::vector<Vector3d> Points() {
  std::vector<Vector3d> points;
  for (const double x : {-0.40, -0.20, 0.0, 0.20, 0.42}) {
    for (const double y : {-0.36, -0.18, 0.0, 0.19, 0.35}) {
      const double z = 0.9 + 0.3 * x - 0.4 * y;
      points.emplace_back(x * z, y * z, z);
    }
  }
  return points;
}

struct Pair {
  std::vector<Vector2d> left, right;
};

/// The spots' places in the rectified pair, of cameras that are truly so.
Pair SpotsInPair(const Description& robot, const Matrix3d& R_RightTrueRight) {
  std::vector<Vector3d> left_C, right_C;
  const Matrix3d R_RC = robot.stereo_right.R_LC * R_RightTrueRight;
  for (const Vector3d& p : Points()) {
    left_C.push_back(p);
    right_C.emplace_back(R_RC.transpose() * (p - Vector3d(kBaseline_m, 0.0, 0.0)));
  }
  const StereoPair pair = StereoRectifier(robot).Rectify(
      {Spots(robot.stereo_left, left_C), Spots(robot.stereo_right, right_C)});
  Pair spots;
  const Camera& camera = robot.stereo_left;
  for (const Vector3d& p : Points()) {
    const Vector2d at(camera.center_x_px + camera.focal_px * p.x() / p.z(),
                      camera.center_y_px + camera.focal_px * p.y() / p.z());
    const Vector2d right = at - Vector2d(camera.focal_px * kBaseline_m / p.z(), 0.0);
    if (right.x() < 15.0) continue;
    spots.left.push_back(SpotNear(pair.left, at));
    spots.right.push_back(SpotNear(pair.right, right));
  }
  return spots;
}

TEST(Rectifier, LeavesTheImageOfAnIdealPinholeAlone) {
  Camera camera;
  camera.width_px = 64;
  camera.height_px = 48;
  camera.focal_px = 50.0;
  camera.center_x_px = 31.5;
  camera.center_y_px = 23.5;
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(7));
  EXPECT_EQ(Rectifier(camera).Rectify(image).data, image.data);
  EXPECT_THROW((void)Rectifier(camera).Rectify(cv::Mat(48, 63, CV_8UC1)), std::invalid_argument);
}

TEST(Rectifier, ShowsTheFrontImageAsThePinholeWould) {
  const Description robot = Files().Parse();
  const Camera& camera = robot.front_camera;
  const std::vector<Vector3d> points = Points();
  const cv::Mat rectified =
      Rectifier(camera, FrontRectification(robot)).Rectify(Spots(camera, points));
  for (const Vector3d& p : points) {
    const Vector2d expected(camera.center_x_px + camera.focal_px * p.x() / p.z(),
                            camera.center_y_px + camera.focal_px * p.y() / p.z());
    EXPECT_LT((SpotNear(rectified, expected) - expected).norm(), 0.05);
  }
}

TEST(StereoRectifier, PutsEveryPointIntoOneRowAtItsDisparity) {
  const Description robot = Files().Parse();
  const Pair spots = SpotsInPair(robot, Matrix3d::Identity());
  ASSERT_GT(spots.left.size(), 20U);
  std::size_t i = 0;
  for (const Vector3d& p : Points()) {
    const double disparity_px = robot.stereo_left.focal_px * kBaseline_m / p.z();
    const double right_px =
        robot.stereo_left.center_x_px + robot.stereo_left.focal_px * p.x() / p.z() - disparity_px;
    if (right_px < 15.0) continue;
    EXPECT_NEAR(spots.left[i].y(), spots.right[i].y(), 0.1);
    EXPECT_NEAR(spots.left[i].x() - spots.right[i].x(), disparity_px, 0.1);
    ++i;
  }
}

// A right camera that is truly turned to the right by ψ sees a point f ψ (1 + x²) further left, x
// the tangent of the angle at which it sees it, and f ψ x y higher or lower; 0.05° is 0.48 px in
// the middle of the image.
TEST(StereoRectifier, ReadsHalfAPixelTooMuchIfTheYawIsOffByATwentiethOfADegree) {
  const Description robot = Files().Parse();
  const double yaw_rad = 0.05 * std::numbers::pi / 180.0;
  const Pair ideal = SpotsInPair(robot, Matrix3d::Identity());
  const Pair off =
      SpotsInPair(robot, Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()).toRotationMatrix());
  const Camera& camera = robot.stereo_right;
  for (std::size_t i = 0; i < off.left.size(); ++i) {
    const double x = (ideal.right[i].x() - camera.center_x_px) / camera.focal_px;
    const double y = (ideal.right[i].y() - camera.center_y_px) / camera.focal_px;
    const double error_px = ideal.right[i].x() - off.right[i].x();
    EXPECT_NEAR(error_px, camera.focal_px * yaw_rad * (1.0 + x * x), 0.06);
    EXPECT_NEAR(off.right[i].y() - off.left[i].y(), -camera.focal_px * yaw_rad * x * y, 0.1);
    EXPECT_EQ(off.left[i], ideal.left[i]);
  }
}

}  // namespace
}  // namespace kantaro::robot
