#include "scenarios/experiments/stereo_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/stereo/stereo.hpp"

namespace kantaro::scenarios {
namespace {

using perception::stereo::Method;

/// Half of the pixels on the wall within 0.1 m of the mouth are read further off than this [px].
double MedianError_px(const StereoView& view, const robot::StereoPair& pair, Method method) {
  perception::stereo::Parameters parameters;
  parameters.method = method;
  parameters.min_disparity_px = 16;
  parameters.disparities = 96;
  const cv::Mat found = perception::stereo::Match(pair.left, pair.right, parameters).disparity_px;
  std::vector<double> errors;
  for (int y = 0; y < found.rows; ++y) {
    for (int x = 0; x < found.cols; ++x) {
      const double depth_m = view.depth_m.at<float>(y, x), disparity_px = found.at<float>(y, x);
      if (std::isnan(disparity_px) || std::abs(depth_m - view.mouth_m) > 0.1) continue;
      errors.push_back(disparity_px - view.focal_px * view.baseline_m / depth_m);
    }
  }
  EXPECT_GT(errors.size(), 10000u);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return errors.empty() ? NAN : errors[errors.size() / 2];
}

// Left wall and right wall alike: what the right camera sees of either is further left in its
// picture, nearer to the axis than in the left picture on the one, further from it on the other,
// and the wall is brighter the nearer it is. Both mistakes make it nearer.
TEST(StereoViews, AreReadTooNearOnlyWhileTheLensesFalloffIsLeftIn) {
  StereoStage stage(robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro"), 0.300, 1);
  const StereoView view = stage.See(0.6, 1.0, 1, "stereo views test");
  for (const Method method : {Method::kSsd, Method::kFastCubic}) {
    EXPECT_GT(MedianError_px(view, view.rectified, method), 0.5) << ToString(method);
    EXPECT_NEAR(MedianError_px(view, view.flat, method), 0.0, 0.3) << ToString(method);
  }
  // A census does not care.
  EXPECT_NEAR(MedianError_px(view, view.rectified, Method::kOurs), 0.0, 0.2);
}

}  // namespace
}  // namespace kantaro::scenarios
