#include "sim/materials.hpp"

#include <gtest/gtest.h>

namespace kantaro::sim {
namespace {

double MeanAlbedo(const cv::Mat& pattern, int first_row, int last_row) {
  return cv::mean(pattern.rowRange(first_row, last_row))[0];
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference)[0];
}

TEST(MakePattern, RepeatsWithItsSeedAndNotWithAnother) {
  const cv::Mat pattern = MakePattern(Pattern::kRough, 7, 1.0);
  EXPECT_EQ(cv::norm(pattern, MakePattern(Pattern::kRough, 7, 1.0), cv::NORM_INF), 0.0);
  EXPECT_GT(MeanDifference(pattern, MakePattern(Pattern::kRough, 8, 1.0)), 5.0);
}

// Across the seam, neighbours differ as neighbours do anywhere.
TEST(MakePattern, HasNoSeam) {
  const cv::Mat pattern = MakePattern(Pattern::kConcrete, 1, 1.0);
  const int last_col = pattern.cols - 1, last_row = pattern.rows - 1;
  EXPECT_NEAR(MeanDifference(pattern.col(0), pattern.col(last_col)),
              MeanDifference(pattern.col(700), pattern.col(701)), 1.5);
  EXPECT_NEAR(MeanDifference(pattern.row(0), pattern.row(last_row)),
              MeanDifference(pattern.row(700), pattern.row(701)), 1.5);
}

TEST(MakePattern, DarkensThePipesInvertOnly) {
  const cv::Mat pattern = MakePattern(Pattern::kPipeWall, 1, 1.0);
  const int invert = pattern.rows / 2;
  EXPECT_LT(MeanAlbedo(pattern, invert - 50, invert + 50), 0.6 * MeanAlbedo(pattern, 0, 100));
  EXPECT_NEAR(MeanAlbedo(pattern, 0, 100), MeanAlbedo(pattern, pattern.rows - 100, pattern.rows),
              10.0);
}

// Soil, the third channel, hides a pipe's colour at the invert and not at the crown.
TEST(MakePattern, SoilsThePipesInvertMost) {
  for (const Pattern kind : {Pattern::kPipeWall, Pattern::kRoughPipe}) {
    const cv::Mat pattern = MakePattern(kind, 1, 1.0);
    const int invert = pattern.rows / 2;
    EXPECT_GT(cv::mean(pattern.rowRange(invert - 50, invert + 50))[2], 200.0);
    EXPECT_LT(cv::mean(pattern.rowRange(0, 100))[2], 40.0);
  }
}

TEST(JointLook, IsMostlyPalerThanTheWallAndElseMuchDarker) {
  for (const network::Material material :
       {network::Material::kConcrete, network::Material::kClay}) {
    const auto wall = PipeWallLook(material, network::WallCondition::kDry).colour;
    const auto joint = [&](double draw) {
      return JointLook(material, network::WallCondition::kDry, draw).colour;
    };
    EXPECT_GT(joint(0.1).sum(), 1.1f * wall.sum());
    EXPECT_GT(joint(0.65).sum(), joint(0.1).sum());
    EXPECT_LT(joint(0.8).sum(), 0.5f * wall.sum());
  }
}

TEST(MakePattern, IsSmoothWithoutContrast) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(MakePattern(Pattern::kConcrete, 1, 0.0), mean, deviation);
  EXPECT_EQ(deviation, cv::Scalar::all(0.0));
}

}  // namespace
}  // namespace kantaro::sim
