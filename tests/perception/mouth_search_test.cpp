#include "perception/mouth_search.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "perception/ring_contrast.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

constexpr double kShaft_m = 0.8;

/// A picture as a camera that answers to the root of light has it.
cv::Mat Rooted(const PipeView& view) {
  cv::Mat grey, table(1, 256, CV_8U);
  cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
  for (int level = 0; level < 256; ++level)
    table.at<std::uint8_t>(level) = cv::saturate_cast<std::uint8_t>(std::sqrt(255.0 * level));
  cv::LUT(grey, table, grey);
  return LogBrightness(grey);
}

/// Pictures 8 cm apart, with the lamp at the camera as it is drawn, and the pose as believed.
RangedLandmark Find(PipeView view, const WallPose& pose = {}) {
  const MouthFit fit(FrontCamera(), {Eigen::Vector3d::Zero()}, view.radius_m, kShaft_m);
  std::vector<MouthSight> sights;
  for (const double behind_m : {0.16, 0.08, 0.0}) {
    view.camera_ahead_m = -behind_m;
    sights.push_back({Rooted(view), pose, 0.0, behind_m});
  }
  return FindMouth(fit, sights, 0.25, 1.7);
}

// The reference goes through the manhole in steps of 3 mm. A pixel of the ring's radius is 0.3 cm
// of distance at 0.5 m, and 2 cm at 1.35 m.
TEST(MouthSearch, PutsAMouthWhereItIs) {
  PipeView view;
  view.joints = {{0.4}};
  view.mouth_m = 0.5;
  EXPECT_NEAR(Find(view).distance_m, 0.5, 0.005);
  view.mouth_m = 1.35;
  EXPECT_NEAR(Find(view).distance_m, 1.35, 0.012);
}

// The axis believed to lean by 0.01 puts the mouth's middle 4 px off. Two pixels of its ring's
// radius are 2.6 cm.
TEST(MouthSearch, BearsAPoseThatIsALittleOff) {
  PipeView view;
  view.mouth_m = 1.1;
  EXPECT_NEAR(Find(view, {{0.0, -0.007}, {0.0, 0.01}}).distance_m, 1.1, 0.025);
}

TEST(MouthSearch, DoubtsAMouthThatIsNotThere) { EXPECT_GT(Find({}).deviation_m, 0.1); }

// Lamps 6 cm to the left of where the left camera has them.
TEST(MouthSearch, KnowsWhereTheLampsAreBeforeTheRightCamera) {
  PipeView view;
  view.mouth_m = 0.9;
  const MouthFit::Picture picture = MouthFit::Smooth(Rooted(view));
  const Eigen::Vector3d lamp(0.05, -0.08, 0.0);
  const MouthFit pair(FrontCamera(), {lamp}, view.radius_m, kShaft_m);
  const MouthFit alone(FrontCamera(), {lamp - 0.06 * Eigen::Vector3d::UnitX()}, view.radius_m,
                       kShaft_m);
  const MouthFit::Light right = pair.Measure(picture, {}, 0.06),
                        same = alone.Measure(picture, {}, 0.0);
  EXPECT_NEAR(right.line.y(), same.line.y(), 1e-9);
  EXPECT_NEAR(right.usual, same.usual, 1e-9);
  EXPECT_GT(std::abs(right.line.y() - pair.Measure(picture, {}, 0.0).line.y()), 1e-3);
}

// Points are moved from pose to pose in place.
TEST(MouthFit, ForgetsAPoseThatWasTried) {
  PipeView view;
  view.mouth_m = 0.9;
  const MouthFit::Picture picture = MouthFit::Smooth(Rooted(view));
  const MouthFit fit(FrontCamera(), {Eigen::Vector3d::Zero()}, view.radius_m, kShaft_m);
  const MouthFit::Mouth mouth{0.9, ChamberModel::Channel::kStraight, 0.0};
  auto points = fit.Take(picture, {}, 0.0, fit.Measure(picture, {}, 0.0), {0.5, 2.0, 0.03, 32});
  const double misfit = fit.Compare(points, mouth, false).Misfit();
  fit.Stand(points, {{0.01, 0.0}, {0.0, 0.02}});
  EXPECT_GT(fit.Compare(points, mouth, false).Misfit(), misfit);
  fit.Stand(points, {});
  EXPECT_EQ(fit.Compare(points, mouth, false).Misfit(), misfit);
}

}  // namespace
}  // namespace kantaro::perception
