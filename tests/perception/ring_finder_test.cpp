#include "perception/ring_finder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "perception/brightness.hpp"
#include "perception/parameters.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

RingParameters Shipped() {
  return ReadParameters(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/perception.yaml").rings;
}

std::vector<RingSighting> Find(const PipeView& view) {
  return FindRings(Brightness(Draw(view)), FrontCamera(), view.radius_m, Shipped());
}

/// The sighting nearest to a distance; fails the test if there is none.
RingSighting Nearest(const std::vector<RingSighting>& rings, double distance_m) {
  EXPECT_FALSE(rings.empty());
  if (rings.empty()) return {};
  return *std::min_element(rings.begin(), rings.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.distance_m - distance_m) < std::abs(b.distance_m - distance_m);
  });
}

class RingAt : public testing::TestWithParam<double> {};

TEST_P(RingAt, IsAJointMeasuredWithinTwoCentimetres) {
  const auto rings = Find({.joints = {{.distance_m = GetParam()}}});
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_EQ(rings[0].kind, RingKind::kJoint);
  EXPECT_NEAR(rings[0].distance_m, GetParam(), 0.02);
  EXPECT_NEAR(rings[0].radius_px, 609.682 * 0.150 / GetParam(),
              0.02 / GetParam() * rings[0].radius_px);
  EXPECT_GT(rings[0].support, 0.8);
}

TEST_P(RingAt, IsMeasuredFromACameraOffTheAxisAndTurned) {
  const auto rings = Find({.camera_right_m = 0.008,
                           .camera_down_m = 0.012,
                           .yaw_rad = 0.02,
                           .pitch_rad = -0.01,
                           .joints = {{.distance_m = GetParam()}}});
  const RingSighting ring = Nearest(rings, GetParam());
  EXPECT_EQ(ring.kind, RingKind::kJoint);
  EXPECT_NEAR(ring.distance_m, GetParam(), 0.02);
}

TEST_P(RingAt, IsAMouthWhereTheCrownEnds) {
  const auto rings = Find({.mouth_m = GetParam()});
  const RingSighting ring = Nearest(rings, GetParam());
  EXPECT_EQ(ring.kind, RingKind::kManholeMouth);
  EXPECT_NEAR(ring.distance_m, GetParam(), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Distances, RingAt, testing::Values(0.40, 0.55, 0.70, 0.85, 1.00));

TEST(RingFinder, SeesABrightJointAsWell) {
  const auto rings = Find({.joints = {{.distance_m = 0.6, .brightness = 1.8}}});
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_EQ(rings[0].kind, RingKind::kJoint);
  EXPECT_NEAR(rings[0].distance_m, 0.6, 0.02);
}

TEST(RingFinder, ListsTheNearestOfTwoJointsFirst) {
  const auto rings = Find({.joints = {{.distance_m = 1.0}, {.distance_m = 0.5}}});
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_NEAR(rings[0].distance_m, 0.5, 0.02);
  EXPECT_NEAR(rings[1].distance_m, 1.0, 0.02);
}

TEST(RingFinder, ScalesDistanceWithThePipe) {
  const auto rings = Find({.radius_m = 0.125, .joints = {{.distance_m = 0.6}}});
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0].distance_m, 0.6, 0.02);
}

TEST(RingFinder, SeesNothingInAPlainPipe) { EXPECT_TRUE(Find({}).empty()); }

TEST(RingFinder, SeesNothingInTheDarkOrInGlare) {
  const robot::Camera camera = FrontCamera();
  const cv::Size size(camera.width_px, camera.height_px);
  EXPECT_TRUE(FindRings(cv::Mat::zeros(size, CV_8UC1), camera, 0.15, Shipped()).empty());
  EXPECT_TRUE(FindRings(cv::Mat(size, CV_8UC1, cv::Scalar(255)), camera, 0.15, Shipped()).empty());
}

TEST(RingFinder, SeesNothingInNoise) {
  cv::Mat noise(480, 704, CV_8UC1);
  cv::RNG random(7);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_TRUE(FindRings(noise, FrontCamera(), 0.15, Shipped()).empty());
}

TEST(RingFinder, RefusesWhatIsNotItsCamerasImage) {
  const robot::Camera camera = FrontCamera();
  EXPECT_THROW((void)FindRings(cv::Mat(), camera, 0.15, {}), std::invalid_argument);
  EXPECT_THROW((void)FindRings(cv::Mat(480, 704, CV_8UC3), camera, 0.15, {}),
               std::invalid_argument);
  EXPECT_THROW((void)FindRings(cv::Mat(480, 640, CV_8UC1), camera, 0.15, {}),
               std::invalid_argument);
  EXPECT_THROW((void)FindRings(cv::Mat::zeros(480, 704, CV_8UC1), camera, 0.0, {}),
               std::invalid_argument);
}

// A tiny camera in a wide pipe and a large one in a narrow: radii that leave no room or all of it.
TEST(RingFinder, SurvivesOddCameras) {
  for (const double focal_px : {1.0, 20.0, 5000.0}) {
    robot::Camera camera = FrontCamera();
    camera.focal_px = focal_px;
    EXPECT_TRUE(FindRings(cv::Mat::zeros(480, 704, CV_8UC1), camera, 0.15, Shipped()).empty());
  }
  robot::Camera tiny;
  tiny.width_px = tiny.height_px = 8;
  tiny.focal_px = 7;
  EXPECT_TRUE(FindRings(cv::Mat::zeros(8, 8, CV_8UC1), tiny, 0.15, Shipped()).empty());
}

}  // namespace
}  // namespace kantaro::perception
