#include "perception/wall_motion.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "perception/ring_contrast.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

cv::Mat LogOf(const PipeView& view) {
  cv::Mat grey;
  cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
  return LogBrightness(grey);
}

// A camera 8 mm to the right of the axis and 5 mm below it, turned 0.03 to the right, sees the axis
// 1 m ahead 38 mm to the left and 5 mm above; it begins 6 mm off. 10 cm were driven twice, odometry
// counted 1 % less. Where the axis is near the camera, and where it leans to, texture tells less
// well apart.
TEST(WallMotion, FindsThePoseInWhichTheWallStandsStill) {
  PipeView view;
  view.camera_right_m = 0.008;
  view.camera_down_m = 0.005;
  view.yaw_rad = 0.03;
  view.texture = 0.2;
  std::vector<WallSight> sights;
  for (const double ahead_m : {0.0, 0.1, 0.2}) {
    view.camera_ahead_m = ahead_m;
    sights.push_back({LogOf(view), 0.99 * ahead_m, 0.0});
  }
  const WallPose start{{-0.0065, -0.004}, {-0.0255, 0.002}};
  const WallMotion motion = FollowWall(FrontCamera(), view.radius_m, sights, start);
  const Eigen::Vector2d ahead_m = motion.pose.off_m + 1.0 * motion.pose.lean;
  EXPECT_NEAR(ahead_m.x(), -0.038, 0.002);
  EXPECT_NEAR(ahead_m.y(), -0.005, 0.002);
  EXPECT_NEAR(motion.travel_scale, 1.0 / 0.99, 0.004);
}

// A camera turned by 1 mrad to the right moves its picture 0.61 px to the left.
TEST(WallMotion, FindsByHowMuchTheRightCameraIsTurned) {
  constexpr double kBaseline_m = 0.060;
  PipeView view;
  view.texture = 0.2;
  PipeView right = view;
  right.camera_right_m = kBaseline_m;
  right.yaw_rad = 0.001;
  const WallMotion motion =
      FollowWall(FrontCamera(), view.radius_m,
                 {{LogOf(right), 0.0, kBaseline_m}, {LogOf(view), 0.0, 0.0}}, {});
  EXPECT_NEAR(motion.turned_px, -0.61, 0.25);
  EXPECT_NEAR(motion.pose.off_m.x(), 0.0, 0.002);
}

// The noise of a dimmed lamp: a step must not be short because noise's slopes pass for texture's.
// The start is as far off as the fall of light of a stained wall puts it: 24 mm to the left and 24
// mm down at 0.7 m.
TEST(WallMotion, FindsThePoseFromFarInNoisyPictures) {
  PipeView view;
  view.camera_right_m = 0.008;
  view.yaw_rad = 0.03;
  view.texture = 0.15;
  view.noise = 5.0;
  std::vector<WallSight> sights;
  for (const double ahead_m : {0.0, 0.08, 0.16, 0.24, 0.32}) {
    view.camera_ahead_m = ahead_m;
    ++view.noise_seed;
    sights.push_back({LogOf(view), ahead_m, 0.0});
  }
  const WallPose start{{-0.011, 0.003}, {-0.060, 0.030}};
  const WallPose pose = FollowWall(FrontCamera(), view.radius_m, sights, start).pose;
  for (const double ahead_m : {0.0, 0.7}) {
    const Eigen::Vector2d axis_m = pose.off_m + ahead_m * pose.lean;
    EXPECT_NEAR(axis_m.x(), -0.008 - 0.03 * ahead_m, 0.003) << ahead_m;
    EXPECT_NEAR(axis_m.y(), 0.0, 0.003) << ahead_m;
  }
}

// Far and bright, the manhole beyond the mouth hardly moves; its edges are the strongest in the
// picture.
TEST(WallMotion, IsNotHeldByAManholesEdges) {
  constexpr double kBaseline_m = 0.060;
  PipeView view;
  view.radius_m = 0.100;
  view.camera_down_m = -0.010;
  view.texture = 0.15;
  view.mouth_m = 0.9;
  std::vector<WallSight> sights;
  for (const double ahead_m : {0.0, 0.1, 0.2}) {
    view.camera_ahead_m = ahead_m;
    PipeView right = view;
    right.camera_right_m = kBaseline_m;
    sights.push_back({LogOf(right), ahead_m, kBaseline_m});
    sights.push_back({LogOf(view), ahead_m, 0.0});
  }
  const WallPose start{{0.008, 0.002}, {-0.03, 0.02}};
  const WallMotion motion = FollowWall(FrontCamera(), view.radius_m, sights, start);
  for (const double ahead_m : {0.0, 0.7}) {
    const Eigen::Vector2d axis_m = motion.pose.off_m + ahead_m * motion.pose.lean;
    EXPECT_NEAR(axis_m.x(), 0.0, 0.003) << ahead_m;
    EXPECT_NEAR(axis_m.y(), 0.010, 0.003) << ahead_m;
  }
  EXPECT_NEAR(motion.turned_px, 0.0, 0.3);
}

TEST(WallMotion, StaysWhereItIsWithoutASecondPicture) {
  const WallPose start{{0.01, 0.0}, {0.0, 0.02}};
  const WallMotion motion =
      FollowWall(FrontCamera(), 0.150, {{cv::Mat::ones(480, 704, CV_32F), 0.0, 0.0}}, start);
  EXPECT_EQ(motion.pose.off_m, start.off_m);
  EXPECT_EQ(motion.pose.lean, start.lean);
  EXPECT_EQ(motion.travel_scale, 1.0);
}

}  // namespace
}  // namespace kantaro::perception
