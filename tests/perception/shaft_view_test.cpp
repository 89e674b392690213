#include "perception/shaft_view.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

constexpr double kRadius_m = 0.150, kShaft_m = 0.8;

/// With the lamp at the camera, as it is drawn.
class ShaftViewTest : public testing::Test {
 protected:
  static ShaftView::Sight Take(const PipeView& view) {
    cv::Mat grey;
    cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
    return View().Take(LogBrightness(grey), {});
  }
  static const ShaftView& View() {
    static const ShaftView view(FrontCamera(), {Eigen::Vector3d::Zero()}, kRadius_m, kShaft_m);
    return view;
  }
};

// Seen through the mouth, the far wall of the shaft is lit squarely between the upright sides of
// the channel, which the light grazes.
TEST_F(ShaftViewTest, SeesTheFarWallWhereTheMouthSaysItIs) {
  PipeView view;
  view.mouth_m = 0.7;
  const ShaftView::Sight sight = Take(view);
  const double there = View().EndWallAt(sight, 0.7).Sides();
  EXPECT_GT(there, 0.3);
  for (const double elsewhere_m : {0.4, 0.55, 0.85, 1.2})
    EXPECT_LT(View().EndWallAt(sight, elsewhere_m).Sides(), 0.3 * there) << elsewhere_m;
}

TEST_F(ShaftViewTest, SeesNoFarWallInAPipe) {
  const ShaftView::Sight sight = Take({});
  for (double d = 0.3; d < 1.5; d += 0.1) {
    EXPECT_LT(View().EndWallAt(sight, d).Sides(), 0.1) << d;
    const ShaftView::Turn turn = View().TurnAt(sight, d);
    EXPECT_LT(turn.outer + turn.inner, 0.2) << d;
  }
}

// Behind a joint the wall goes on as before. A disc of 80 grey levels fills a mouth at 0.8 m, where
// the wall has about 25.
TEST_F(ShaftViewTest, SeesAJumpAtAMouthAndNoneAtAJoint) {
  PipeView view;
  view.joints = {{0.45}};
  cv::Mat grey;
  cv::cvtColor(Draw(view), grey, cv::COLOR_BGR2GRAY);
  const robot::Camera camera = FrontCamera();
  cv::circle(grey, cv::Point(352, 240), static_cast<int>(camera.focal_px * kRadius_m / 0.8), 80,
             cv::FILLED);
  const ShaftView::Sight sight = View().Take(LogBrightness(grey), {});
  EXPECT_LT(std::abs(View().Jump(sight, 0.45)), 0.15);
  EXPECT_GT(View().Jump(sight, 0.8), 0.5);
}

}  // namespace
}  // namespace kantaro::perception
