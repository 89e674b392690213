#include "perception/joint_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.hpp"

namespace kantaro::perception {
namespace {

constexpr double kPipeRadius_m = 0.125, kNear_m = 0.25, kFar_m = 1.6;

robot::Camera Camera() {
  robot::Camera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.focal_px = 600.0;
  camera.center_x_px = 319.5;
  camera.center_y_px = 239.5;
  return camera;
}

/// A ring of the wall.
struct Line {
  double distance_m, contrast;  ///< natural logarithm of brightness
  double share{1.0};            ///< of the round
  double width_px{1.0};         ///< standard deviation
};

/// What a camera on the axis, turned a little, sees so far behind the place that distances count
/// from: so many pixels to the right of where it takes the axis to be.
JointSight See(const std::vector<Line>& lines, double ahead_m, double noise, int number,
               double right_px = 0.0) {
  robot::Camera camera = Camera();
  camera.center_x_px += right_px;
  RandomStream random(7, "joint search " + std::to_string(number));
  cv::Mat log_brightness(camera.height_px, camera.width_px, CV_32F);
  for (int y = 0; y < log_brightness.rows; ++y) {
    for (int x = 0; x < log_brightness.cols; ++x) {
      const double radius_px = std::hypot(x - camera.center_x_px, y - camera.center_y_px);
      const double turn =
          std::atan2(y - camera.center_y_px, x - camera.center_x_px) / (2.0 * std::numbers::pi) +
          0.5;
      double value = random.Normal(noise);
      for (const Line& line : lines) {
        if (turn > line.share) continue;
        const double ring_px = camera.focal_px * kPipeRadius_m / (line.distance_m + ahead_m);
        value +=
            line.contrast * std::exp(-0.5 * std::pow((radius_px - ring_px) / line.width_px, 2.0));
      }
      log_brightness.at<float>(y, x) = static_cast<float>(value);
    }
  }
  const RingScan scan(Camera(), kPipeRadius_m, kNear_m, kFar_m + 0.3);
  return {scan.Scan(log_brightness, {}), ahead_m};
}

std::vector<JointSight> Approach(const std::vector<Line>& lines, double noise, int pictures) {
  std::vector<JointSight> sights;
  for (int i = 0; i < pictures; ++i)
    sights.push_back(See(lines, 0.03 * (pictures - 1 - i), noise, i));
  return sights;
}

/// That of a lean, and of nothing else.
PoseDoubt Leaning(double deviation) {
  PoseDoubt doubt{Eigen::Matrix4d::Zero()};
  doubt.covariance.bottomRightCorner<2, 2>().diagonal().setConstant(deviation * deviation);
  return doubt;
}

RangedLandmark Find(const std::vector<JointSight>& sights,
                    const PoseDoubt& doubt = Leaning(0.001)) {
  return FindJoint(sights, doubt, kNear_m, kFar_m);
}

// In a sector of the ring at 1 m, 20 px long, noise of 0.25 leaves 0.06 of contrast: as much as
// the line has. Nine pictures leave a third of it.
TEST(JointSearch, SeesInAllPicturesALineThatNoneShows) {
  const std::vector<Line> faint{{1.0, 0.07, 1.0, 0.7}};
  const RangedLandmark one = Find(Approach(faint, 0.25, 1));
  const RangedLandmark nine = Find(Approach(faint, 0.25, 9));
  EXPECT_GT(one.deviation_m, 0.15);
  EXPECT_NEAR(nine.distance_m, 1.0, 0.02);
  EXPECT_LT(nine.deviation_m, 0.5 * one.deviation_m);
}

TEST(JointSearch, TakesNoArcForAJoint) {
  const RangedLandmark found = Find(Approach({{0.4, 0.3, 0.25}, {1.3, 0.05}}, 0.02, 3));
  EXPECT_NEAR(found.distance_m, 1.3, 0.03);
}

TEST(JointSearch, TakesTheNearerOfTwoPlainRings) {
  const RangedLandmark found = Find(Approach({{0.6, 0.3}, {1.2, 0.4}}, 0.02, 3));
  EXPECT_NEAR(found.distance_m, 0.6, 0.01);
  EXPECT_LT(found.deviation_m, 0.02);
}

TEST(JointSearch, TakesAFaintJointBeforeAPlainMouth) {
  const RangedLandmark found = Find(Approach({{0.6, 0.07, 1.0, 0.7}, {1.3, 0.3}}, 0.05, 5));
  EXPECT_NEAR(found.distance_m, 0.6, 0.01);
}

// The band is what lies dark behind a manhole's joint, nine pixels inside the line.
TEST(JointSearch, TellsADarkJointFromTheBandBehindIt) {
  const RangedLandmark found =
      Find(Approach({{0.90, -0.12, 1.0, 0.7}, {1.01, -0.15, 1.0, 3.0}}, 0.02, 3));
  EXPECT_NEAR(found.distance_m, 0.9, 0.01);
}

TEST(JointSearch, FindsALineDarkerThanTheWall) {
  const RangedLandmark found = Find(Approach({{0.8, -0.1}}, 0.02, 3));
  EXPECT_NEAR(found.distance_m, 0.8, 0.01);
}

// Seven pixels are 12 mrad: a line 1.5 px wide, unrolled about the wrong place, is none.
TEST(JointSearch, LooksAsFarAsideAsThePoseIsInDoubt) {
  const std::vector<JointSight> sights{See({{1.0, 0.07, 1.0, 0.7}}, 0.0, 0.02, 0, 7.0)};
  const RangedLandmark astray = Find(sights, Leaning(0.0005)),
                       found = Find(sights, Leaning(0.007));
  EXPECT_GT(std::abs(astray.distance_m - 1.0), 0.05);
  EXPECT_NEAR(found.distance_m, 1.0, 0.02);
  EXPECT_LT(found.deviation_m, 0.02);
}

}  // namespace
}  // namespace kantaro::perception
