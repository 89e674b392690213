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

// The robot swings along a wave of 3 m: half a degree of heading, 2 mm aside, a degree of roll. One
// pose for all pictures would be off by 6 mm at 1 m.
TEST(WallMotion, FollowsARobotThatSways) {
  const robot::Camera camera = FrontCamera();
  const auto swing = [](double travel_m) { return std::sin(0.6 + 2.0 * CV_PI * travel_m / 3.0); };
  const auto yaw_rad = [&](double travel_m) { return 0.009 * swing(travel_m); };
  const auto right_m = [&](double travel_m) { return -0.002 * swing(travel_m); };
  const auto roll_rad = [&](double travel_m) { return 0.0175 * (swing(travel_m) - swing(0.0)); };
  PipeView view;
  view.texture = 0.2;
  std::vector<WallSight> sights;
  for (const double travel_m : {-0.32, -0.24, -0.16, -0.08, 0.0}) {
    view.camera_ahead_m = travel_m;
    view.yaw_rad = yaw_rad(travel_m);
    view.camera_right_m = right_m(travel_m);
    // A robot that rolls clockwise sees the wall turn the other way, as OpenCV's angles count.
    const cv::Mat turn =
        cv::getRotationMatrix2D(cv::Point2d(camera.center_x_px, camera.center_y_px),
                                roll_rad(travel_m) * 180.0 / CV_PI, 1.0);
    cv::Mat rolled;
    cv::warpAffine(LogOf(view), rolled, turn, {camera.width_px, camera.height_px}, cv::INTER_LINEAR,
                   cv::BORDER_REFLECT);
    sights.push_back({rolled, travel_m, 0.0});
  }
  const WallMotion motion = FollowWall(camera, view.radius_m, sights, {});
  for (const double travel_m : {-0.32, -0.16, 0.0}) {
    const WallPose pose = motion.PoseAt(travel_m);
    const Eigen::Vector2d ahead_m = pose.off_m + 1.0 * pose.lean;
    EXPECT_NEAR(ahead_m.x(), -right_m(travel_m) - yaw_rad(travel_m), 0.0015) << travel_m;
    EXPECT_NEAR(ahead_m.y(), 0.0, 0.0015) << travel_m;
    EXPECT_NEAR(motion.SwayAt(travel_m).roll_rad, -roll_rad(travel_m), 0.002) << travel_m;
  }
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
  const auto [pose, scale, turned, sway, doubt] =
      FollowWall(FrontCamera(), view.radius_m, sights, start);
  const Eigen::Vector2d seen = pose.off_m / 0.7 + pose.lean;
  const Eigen::Matrix2d doubted = doubt.OfAxisAt(0.7);
  EXPECT_LT(std::abs(seen.x() + 0.008 / 0.7 + 0.03), 3.0 * std::sqrt(doubted(0, 0)));
  EXPECT_LT(std::abs(seen.y()), 3.0 * std::sqrt(doubted(1, 1)));
  EXPECT_LT(std::sqrt(doubted.trace()), 0.004);
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
  EXPECT_EQ(motion.doubt.covariance, DoubtOfLight().covariance);
}

TEST(WallMotion, StaysWhereItIsBeforeAnEvenWall) {
  const WallPose start{{0.01, 0.0}, {0.0, 0.02}};
  const cv::Mat even = cv::Mat::ones(480, 704, CV_32F);
  const WallMotion motion =
      FollowWall(FrontCamera(), 0.150, {{even, 0.0, 0.0}, {even, 0.1, 0.0}}, start);
  EXPECT_EQ(motion.pose.lean, start.lean);
  EXPECT_EQ(motion.doubt.covariance, DoubtOfLight().covariance);
}

}  // namespace
}  // namespace kantaro::perception
