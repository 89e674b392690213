#include "perception/our_landmarks.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "perception/parameters.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

const robot::Description& Robot() {
  static const robot::Description robot =
      robot::ReadDescription(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro");
  return robot;
}

constexpr double kInlet_m = 0.130;

/// A dark mouth to the right at the height of the axis: where a branch crosswise meets the wall.
void PaintInlet(cv::Mat& grey, double distance_m, double pipe_radius_m) {
  const PipeWall wall(Robot().front_camera, pipe_radius_m, {});
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = grey.cols / 2; x < grey.cols; ++x) {
      const Eigen::Vector3d point = wall.PointAt(cv::Point2d(x, y));
      if (std::hypot(point.z() - distance_m, point.y()) < kInlet_m / 2.0)
        grey.at<std::uint8_t>(y, x) /= 3;
    }
  }
}

/// Three pictures of an approach, the last one at the view's origin.
RangedLandmark Follow(PipeView view, LandmarkKind kind, std::optional<double> inlet_m = {}) {
  LandmarkTracker tracker(Robot(), Robot().front_camera, 0.0, {}, kind,
                          {2.0 * view.radius_m, kInlet_m});
  for (const double ahead_m : {-0.16, -0.08, 0.0}) {
    view.camera_ahead_m = ahead_m;
    cv::Mat grey;
    cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
    if (kind == LandmarkKind::kManhole) {  // its light is measured, to whose root cameras answer
      grey.convertTo(grey, CV_32F);
      cv::sqrt(255.0 * grey, grey);
      grey.convertTo(grey, CV_8U);
    }
    if (inlet_m) PaintInlet(grey, *inlet_m - ahead_m, view.radius_m);
    tracker.Add(grey, {}, ahead_m);
  }
  return tracker.Answer();
}

// A pixel of a ring's radius is 0.7 cm at 0.8 m.
TEST(LandmarkTracker, TellsAMouthFromTheJointBeforeIt) {
  PipeView view;
  view.joints = {{0.5}};
  view.mouth_m = 0.8;
  EXPECT_NEAR(Follow(view, LandmarkKind::kManhole).distance_m, 0.8, 0.02);
  const RangedLandmark joint = Follow(view, LandmarkKind::kJoint);
  EXPECT_NEAR(joint.distance_m, 0.5, 0.01);
  EXPECT_LT(joint.deviation_m, 0.02);
}

TEST(LandmarkTracker, MeasuresAnInlet) {
  EXPECT_NEAR(Follow({}, LandmarkKind::kInletRight, 0.55).distance_m, 0.55, 0.01);
}

// Where there is none, any distance is as good as another, but for what nobody could see so far
// away: an even spread over the last 0.5 m of 1.7 m has a deviation of 0.14 m. By chance noise
// speaks for one place more than for others.
TEST(LandmarkTracker, DoubtsAJointThatItCannotSee) {
  constexpr int kViews = 6;
  double mean_m = 0.0;
  for (int k = 1; k <= kViews; ++k) {
    PipeView view;
    view.noise_seed = 10 * k;
    mean_m += Follow(view, LandmarkKind::kJoint).deviation_m / kViews;
  }
  EXPECT_GT(mean_m, 0.12);
}

}  // namespace
}  // namespace kantaro::perception
