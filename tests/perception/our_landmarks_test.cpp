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

/// Three pictures of an approach, the last one at the view's origin.
std::optional<RangedLandmark> Follow(PipeView view, LandmarkKind kind) {
  LandmarkTracker tracker(Robot(), Robot().front_camera, 0.0, {}, kind, {2.0 * view.radius_m});
  std::optional<RangedLandmark> found;
  for (const double ahead_m : {-0.16, -0.08, 0.0}) {
    view.camera_ahead_m = ahead_m;
    cv::Mat grey;
    cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
    found = tracker.Update(grey, {}, ahead_m);
  }
  return found;
}

// A pixel of a ring's radius is 0.7 cm at 0.8 m.
TEST(LandmarkTracker, TellsAMouthFromTheJointBeforeIt) {
  PipeView view;
  view.joints = {{0.5}};
  view.mouth_m = 0.8;
  const auto mouth = Follow(view, LandmarkKind::kManhole);
  ASSERT_TRUE(mouth);
  EXPECT_NEAR(mouth->distance_m, 0.8, 0.02);
  const auto joint = Follow(view, LandmarkKind::kJoint);
  ASSERT_TRUE(joint);
  EXPECT_NEAR(joint->distance_m, 0.5, 0.01);
  EXPECT_LT(joint->deviation_m, 0.02);
}

// Where there is none, any distance is as good as another: an even spread over 0.25 to 1.7 m has a
// deviation of 0.42 m.
TEST(LandmarkTracker, DoubtsAJointThatItCannotSee) {
  const auto joint = Follow({}, LandmarkKind::kJoint);
  ASSERT_TRUE(joint);
  EXPECT_GT(joint->deviation_m, 0.2);
}

}  // namespace
}  // namespace kantaro::perception
