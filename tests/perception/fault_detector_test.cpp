#include "perception/fault_detector.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "perception/brightness.hpp"
#include "perception/parameters.hpp"
#include "perception/ring_finder.hpp"
#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

FaultParameters Shipped() {
  return ReadParameters(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/perception.yaml").faults;
}

std::vector<FaultCandidate> Find(const PipeView& view, const FaultParameters& parameters,
                                 const std::vector<RingSighting>& rings = {}) {
  const robot::Camera camera = FrontCamera();
  const Ring ring =
      FaultRing(camera, 2 * view.radius_m, {camera.center_x_px, camera.center_y_px}, parameters);
  return FindFaults(Brightness(Draw(view)), ring, camera.focal_px, 2 * view.radius_m, rings,
                    parameters);
}

// 609.682 px · 0.150 m / 0.554 m = 165.1 px: the thesis' 150 px at 554.26 px focal length.
TEST(FaultRing, LiesWhereThePipesWallIsAtTheGivenDistances) {
  robot::Camera camera = FrontCamera();
  const Ring ring = FaultRing(camera, 0.300, {351.5, 239.5}, {});
  EXPECT_NEAR(ring.outer_px, 165.07, 0.01);
  EXPECT_NEAR(ring.inner_px, 110.05, 0.01);
  camera.width_px = 640;
  camera.focal_px = 554.256;
  EXPECT_NEAR(FaultRing(camera, 0.300, {319.5, 239.5}, {}).outer_px, 150.0, 0.1);
}

TEST(EdgeImage, AnswersTheSlopeOfARampForSobelAndPrewitt) {
  cv::Mat ramp(50, 942, CV_8UC1);
  for (int row = 0; row < ramp.rows; ++row) ramp.row(row).setTo(20 + 4 * row);
  FaultParameters parameters;
  parameters.equalize_brightness = false;
  parameters.edge_gain = 10;
  for (const EdgeOperator edge_operator : {EdgeOperator::kSobel, EdgeOperator::kPrewitt}) {
    parameters.edge_operator = edge_operator;
    EXPECT_EQ(EdgeImage(ramp, parameters).at<std::uint8_t>(25, 400),
              40);  // 4 levels a pixel, ten-fold
  }
  parameters.edge_operator = EdgeOperator::kLaplacian;
  EXPECT_EQ(EdgeImage(ramp, parameters).at<std::uint8_t>(25, 400), 0);  // a ramp has no bend
}

TEST(EdgeImage, HasNoSeamAtTheCrown) {
  cv::Mat wave(50, 942, CV_8UC1);
  for (int column = 0; column < wave.cols; ++column) {
    wave.col(column).setTo(std::round(128 + 100 * std::sin(2 * CV_PI * column / 942)));
  }
  FaultParameters parameters;
  parameters.edge_gain = 10;
  const cv::Mat edges = EdgeImage(wave, parameters);
  // The slope of the sine at its zero crossing: 100 · 2π / 942 = 0.667 levels a pixel.
  EXPECT_NEAR(edges.at<std::uint8_t>(25, 0), 7, 1);
  EXPECT_NEAR(edges.at<std::uint8_t>(25, 941), 7, 1);
}

TEST(HorizontalSimilarity, IsOneWhereAllColumnsAreAlike) {
  cv::Mat edges(50, 942, CV_8UC1);
  for (int row = 0; row < edges.rows; ++row) edges.row(row).setTo(5 * row);
  const auto similarity = HorizontalSimilarity(edges, {});
  ASSERT_EQ(similarity.size(), 38U);  // x = 0, 25, …, 925
  for (const double value : similarity) EXPECT_NEAR(value, 1.0, 1e-6);
}

// One bright window of 50 columns: the average image reads 255·50/892 where the window lies inside
// its sum.
TEST(HorizontalSimilarity, FallsByTheWindowsDifferenceFromTheAverage) {
  cv::Mat edges = cv::Mat::zeros(50, 942, CV_8UC1);
  edges.colRange(400, 450).setTo(255);
  const double average = 255.0 * 50 / 892;
  const auto similarity = HorizontalSimilarity(edges, {});
  EXPECT_NEAR(similarity[400 / 25], average / 255, 1e-6);
  EXPECT_NEAR(similarity[100 / 25], 1 - average / 255, 1e-6);
  EXPECT_NEAR(similarity[375 / 25], 0.5, 1e-6);  // half of it bright, half dark
}

TEST(HorizontalSimilarity, LooksAtTheLastColumnsAcrossTheSeam) {
  cv::Mat edges = cv::Mat::zeros(50, 942, CV_8UC1);
  edges.colRange(930, 942).setTo(255);
  const auto similarity = HorizontalSimilarity(edges, {});
  EXPECT_LT(similarity[37], 0.85);  // x = 925 to 975, wrapping
}

TEST(HorizontalSimilarity, LeavesOutWhatTheMaskSays) {
  cv::Mat edges = cv::Mat::zeros(50, 942, CV_8UC1), used(50, 942, CV_8UC1, cv::Scalar(255));
  edges.colRange(400, 420).setTo(255);
  used.colRange(400, 420).setTo(0);
  for (const double value : HorizontalSimilarity(edges, used)) EXPECT_NEAR(value, 1.0, 1e-9);
  used.setTo(0);
  for (const double value : HorizontalSimilarity(edges, used)) EXPECT_EQ(value, 1.0);
}

// Rows 0 to 9 bright: the strip at 0 differs in full from the seven at 10 … 40 and by half from the
// one at 5, and not from itself: C(0) = 1 − 7.5 / 9. The strip at 20 differs from the one at 0 and
// half from that at 5.
TEST(VerticalSimilarity, ComparesNineStripsAndDividesByNine) {
  cv::Mat edges = cv::Mat::zeros(50, 942, CV_8UC1);
  edges.rowRange(0, 10).setTo(255);
  const auto similarity = VerticalSimilarity(edges, {}, 100);
  ASSERT_EQ(similarity.size(), 9U);
  EXPECT_NEAR(similarity[0], 1 - 7.5 / 9, 1e-9);
  EXPECT_NEAR(similarity[4], 1 - 1.5 / 9, 1e-9);
}

TEST(VerticalSimilarity, LooksOnlyAtTheCandidatesColumns) {
  cv::Mat edges = cv::Mat::zeros(50, 942, CV_8UC1);
  edges(cv::Rect(300, 0, 50, 10)).setTo(255);
  EXPECT_LT(VerticalSimilarity(edges, {}, 300)[0], 0.2);
  EXPECT_EQ(VerticalSimilarity(edges, {}, 350)[0], 1.0);
  EXPECT_THROW((void)VerticalSimilarity(edges, {}, 942), std::invalid_argument);
}

TEST(Similarity, NeedsThePanoramasSize) {
  EXPECT_THROW((void)HorizontalSimilarity(cv::Mat::zeros(50, 941, CV_8UC1), {}),
               std::invalid_argument);
  EXPECT_THROW(
      (void)VerticalSimilarity(cv::Mat::zeros(50, 942, CV_8UC1), cv::Mat::zeros(1, 1, CV_8UC1), 0),
      std::invalid_argument);
}

TEST(FaultDetector, FindsNothingOnACleanPipe) { EXPECT_TRUE(Find({}, Shipped()).empty()); }

TEST(FaultDetector, FindsNothingInTheDark) {
  const robot::Camera camera = FrontCamera();
  const Ring ring = FaultRing(camera, 0.3, {351.5, 239.5}, Shipped());
  EXPECT_TRUE(
      FindFaults(cv::Mat::zeros(480, 704, CV_8UC1), ring, camera.focal_px, 0.3, {}, Shipped())
          .empty());
}

class CrackAt : public testing::TestWithParam<double> {};

TEST_P(CrackAt, IsFoundAtItsClockPosition) {
  const auto candidates =
      Find({.cracks = {{.clock_h = GetParam(), .near_m = 0.60, .far_m = 0.70}}}, Shipped());
  ASSERT_EQ(candidates.size(), 1U);
  EXPECT_NEAR(std::remainder(candidates[0].clock_h - GetParam(), 12.0), 0.0, 0.5);
  EXPECT_GT(candidates[0].clock_h, 0.0);
  EXPECT_LE(candidates[0].clock_h, 12.0);
  EXPECT_NEAR(candidates[0].distance_m, 0.65, 0.08);
  EXPECT_LT(candidates[0].horizontal_similarity, 0.97);
  EXPECT_LT(candidates[0].vertical_similarity, 0.96);
}

INSTANTIATE_TEST_SUITE_P(Clock, CrackAt, testing::Values(12.0, 2.5, 4.0, 6.0, 9.0, 11.5));

// Seen from off the axis a joint crosses the panorama as a wave, and the average image no longer
// takes it out.
TEST(FaultDetector, LeavesJointsOutOnlyIfAskedTo) {
  const PipeView view{.camera_right_m = 0.015,
                      .camera_down_m = 0.010,
                      .joints = {{.distance_m = 0.66, .brightness = 0.1}}};
  FaultParameters parameters = Shipped();
  const auto rings =
      FindRings(Brightness(Draw(view)), FrontCamera(), view.radius_m, RingParameters{});
  ASSERT_EQ(rings.size(), 1U);
  parameters.ignore_joints = true;
  EXPECT_TRUE(Find(view, parameters, rings).empty());
  parameters.ignore_joints = false;
  EXPECT_FALSE(Find(view, parameters, rings).empty());
}

// A mouth in the panorama: the shaft's walls and edges beyond it are no fault of the pipe.
TEST(FaultDetector, LooksAtNothingBeyondAMouth) {
  const PipeView view{.mouth_m = 0.56};
  FaultParameters parameters = Shipped();
  RingSighting mouth{.kind = RingKind::kManholeMouth,
                     .distance_m = 0.56,
                     .radius_px = 609.682 * 0.150 / 0.56,
                     .support = 1.0,
                     .center_x_px = 351.5,
                     .center_y_px = 239.5};
  EXPECT_TRUE(Find(view, parameters, {mouth}).empty());
  EXPECT_FALSE(Find(view, parameters, {}).empty());
}

}  // namespace
}  // namespace kantaro::perception
