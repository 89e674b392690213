#include "perception/wall_texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "perception/ring_contrast.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

constexpr double kRadius_m = 0.150, kNear_m = 0.35, kFar_m = 0.6, kBehind_m = 0.3;

cv::Mat LogOf(const PipeView& view) {
  cv::Mat grey;
  cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
  return LogBrightness(grey);
}

WallGrid Grid() {
  return {FrontCamera().focal_px * kRadius_m, kBehind_m, kNear_m, kFar_m, {1, 1.0}};
}

WallSighting Sighting(const WallPose& pose, double roll_rad, double ahead_m, double shift_px) {
  return {PipeWall(FrontCamera(), kRadius_m, pose), Eigen::Rotation2Dd(roll_rad), ahead_m,
          shift_px};
}

TEST(WallTexture, ComesBackFromAPixelToItsPlace) {
  const WallSighting sighting = Sighting({{0.01, -0.02}, {0.05, -0.03}}, 0.1, 0.2, 3.0);
  for (const double angle_rad : {-3.0, -1.0, 0.5, 2.0}) {
    const WallPlace place{0.4, {std::cos(angle_rad), std::sin(angle_rad)}};
    const WallPlace back = sighting.PlaceAt(sighting.PixelOf(sighting.PointAt(place)));
    EXPECT_NEAR(back.distance_m, 0.4, 1e-9);
    EXPECT_NEAR((back.direction - place.direction).norm(), 0.0, 1e-9) << angle_rad;
  }
}

// From 0.3 m farther off a speck at 0.4 m is a third as large along the pipe. Were each picture
// smoothed by its own pixels, what is left of them would have nothing in common.
TEST(WallTexture, LooksAlikeFromNearAndFar) {
  PipeView near, far;
  near.texture = far.texture = 0.2;
  far.camera_ahead_m = -kBehind_m;
  far.noise_seed = 2;
  const WallGrid grid = Grid();
  const cv::Mat of_near = grid.Texture(LogOf(near), Sighting({}, 0.0, 0.0, 0.0)),
                of_far = grid.Texture(LogOf(far), Sighting({}, 0.0, kBehind_m, 0.0));
  double products = 0.0, near_squares = 0.0, far_squares = 0.0;
  std::size_t count = 0;
  for (const WallPlace& place : grid.Places(3)) {
    const cv::Point2d pixel =
        Sighting({}, 0.0, 0.0, 0.0)
            .PixelOf(
                PipeWall(FrontCamera(), kRadius_m, {}).PointAt(place.distance_m, place.direction));
    if (pixel.x < 20 || pixel.y < 20 || pixel.x > 683 || pixel.y > 459) continue;
    const auto a = grid.Take(of_near, place), b = grid.Take(of_far, place);
    ASSERT_TRUE(a && b);
    products += a->value * b->value;
    near_squares += a->value * a->value;
    far_squares += b->value * b->value;
    ++count;
  }
  EXPECT_GT(count, 1000U);
  EXPECT_GT(products / std::sqrt(near_squares * far_squares), 0.93);
}

TEST(WallTexture, TakesSlopesAlongAndAround) {
  PipeView view;
  view.texture = 0.2;
  const WallGrid grid = Grid();
  const cv::Mat texture = grid.Texture(LogOf(view), Sighting({}, 0.0, 0.0, 0.0));
  const auto at = [&](double distance_m, double angle_rad) {
    return grid.Take(texture, {distance_m, {std::cos(angle_rad), std::sin(angle_rad)}}).value();
  };
  constexpr double kSmall = 1e-7;
  for (const double angle_rad : {-2.9, -0.7, 0.4, 3.1}) {
    const WallGrid::Sample here = at(0.5, angle_rad);
    EXPECT_NEAR(here.along, (at(0.5 + kSmall, angle_rad).value - here.value) / kSmall, 0.02);
    EXPECT_NEAR(here.around, (at(0.5, angle_rad + kSmall).value - here.value) / kSmall, 0.02);
  }
}

// Light falls off smoothly, about as a quadratic does: nothing of it may be left.
TEST(WallTexture, LeavesNothingOfAQuadratic) {
  const WallGrid grid = Grid();
  const WallSighting sighting = Sighting({}, 0.0, 0.0, 0.0);
  const robot::Camera camera = FrontCamera();
  cv::Mat log_brightness(camera.height_px, camera.width_px, CV_32F);
  for (int v = 0; v < log_brightness.rows; ++v) {
    for (int u = 0; u < log_brightness.cols; ++u) {
      const double ring_px = std::hypot(u - camera.center_x_px, v - camera.center_y_px);
      const double column = 1.0 / (1.0 / ring_px + kBehind_m / (camera.focal_px * kRadius_m));
      log_brightness.at<float>(v, u) = static_cast<float>(1e-4 * column * column);
    }
  }
  const cv::Mat texture = grid.Texture(log_brightness, sighting);
  for (const double angle_rad : {-2.0, -0.7, 0.4, 3.1}) {
    const auto here = grid.Take(texture, {0.45, {std::cos(angle_rad), std::sin(angle_rad)}});
    ASSERT_TRUE(here);
    EXPECT_NEAR(here->value, 0.0, 0.01) << angle_rad;
  }
}

// A small camera: what means reach over goes on beyond the axis, where the wall is even. Nearer
// than 0.125 m it is brighter.
TEST(WallTexture, GoesOnEvenlyBeyondTheAxis) {
  robot::Camera camera = FrontCamera();
  camera.focal_px = 100.0;
  const WallGrid grid(camera.focal_px * 0.1, 0.0, 0.25, 1.1, {2, 1.4});
  const PipeWall wall(camera, 0.1, {});
  cv::Mat bright_rim(camera.height_px, camera.width_px, CV_32F, cv::Scalar(1.0));
  cv::circle(bright_rim, cv::Point2d(camera.center_x_px, camera.center_y_px), 80, 0.0, -1);
  const cv::Mat texture = grid.Texture(bright_rim, {wall, Eigen::Rotation2Dd(0.0)});
  const auto far = grid.Take(texture, {1.0, {1.0, 0.0}});
  ASSERT_TRUE(far);
  EXPECT_NEAR(far->value, 0.0, 1e-6);
}

TEST(WallTexture, EndsWhereNothingWasUnrolled) {
  const WallGrid grid = Grid();
  const cv::Mat texture =
      grid.Texture(cv::Mat::zeros(480, 704, CV_32F), Sighting({}, 0.0, 0.0, 0.0));
  EXPECT_TRUE(grid.Take(texture, {0.5, {1.0, 0.0}}));
  EXPECT_FALSE(grid.Take(texture, {0.05, {1.0, 0.0}}));
  EXPECT_FALSE(grid.Take(texture, {9.0, {1.0, 0.0}}));
  EXPECT_FALSE(grid.Take(texture, {std::nan(""), {1.0, 0.0}}));
}

}  // namespace
}  // namespace kantaro::perception
