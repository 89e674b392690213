#include "scenarios/experiments/landmark_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <tuple>

#include "scenarios/experiments/fine_drawing.hpp"
#include "scenarios/landmark_calibration.hpp"
#include "sim/sewer.hpp"

namespace kantaro::scenarios {
namespace {

using perception::LandmarkKind;

constexpr std::array kSets{ViewSet::kReproduction, ViewSet::kStress};
constexpr std::size_t kSewers = 30;

/// Everything that is drawn for a sewer, as numbers.
std::vector<double> DrawnOf(const LandmarkSewer& sewer) {
  std::vector<double> drawn;
  for (const network::Joint& joint : sewer.pipe().joints) {
    drawn.push_back(joint.chainage_m);
    drawn.push_back(joint.gap_m);
  }
  for (const network::Inlet& inlet : sewer.pipe().inlets) {
    drawn.push_back(inlet.chainage_m);
    drawn.push_back(inlet.clock_h);
  }
  return drawn;
}

// Not a place of a joint, not an angle of an inlet and no texture is in both.
TEST(LandmarkViews, ShareNoSewerBetweenTrainingAndTest) {
  std::set<double> trained;
  std::set<std::uint64_t> textures;
  std::set<std::string> streams;
  for (const ViewSet set : kSets) {
    for (std::size_t i = 0; i < kSewers; ++i) {
      const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTraining, set, 1, i);
      for (const double drawn : DrawnOf(sewer)) trained.insert(drawn);
      textures.insert(sewer.texture_seed);
      streams.insert(StreamOf(ViewPurpose::kTraining, set, i));
    }
  }
  ASSERT_EQ(textures.size(), 2 * kSewers);
  for (const ViewSet set : kSets) {
    for (std::size_t i = 0; i < kSewers; ++i) {
      const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTest, set, 1, i);
      for (const double drawn : DrawnOf(sewer)) EXPECT_FALSE(trained.contains(drawn)) << drawn;
      EXPECT_FALSE(textures.contains(sewer.texture_seed));
      EXPECT_FALSE(streams.contains(StreamOf(ViewPurpose::kTest, set, i)));
    }
  }
}

// The field alone is calibrated where it is tested, as the thesis' was.
TEST(LandmarkViews, ShareTheirThreeSewersInTheField) {
  std::set<std::uint64_t> textures;
  for (std::size_t i = 0; i < 9; ++i) {
    const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTest, ViewSet::kField, 1, i);
    EXPECT_EQ(sewer.texture_seed,
              DrawSewer(ViewPurpose::kTraining, ViewSet::kField, 1, i).texture_seed);
    textures.insert(sewer.texture_seed);
    const auto plan = [&](ViewPurpose purpose) {
      return DrawView(sewer, purpose, ViewSet::kField, 1, i, 0, LandmarkKind::kJoint);
    };
    EXPECT_NE(plan(ViewPurpose::kTest).distance_m, plan(ViewPurpose::kTraining).distance_m);
    EXPECT_LE(plan(ViewPurpose::kTest).distance_m, 0.8);
    EXPECT_EQ(plan(ViewPurpose::kTest).pitch_rad, 0.0);
  }
  EXPECT_EQ(textures.size(), 3U);
}

TEST(LandmarkViews, KnowWhetherAJointStandsBeforeThem) {
  LandmarkSewer sewer;
  sewer.network.pipes.resize(1);
  sewer.network.pipes[0].joints.resize(1);
  ViewPlan plan;
  plan.kind = LandmarkKind::kManhole;  // 8 m down the pipe
  plan.distance_m = 1.0;
  sewer.network.pipes[0].joints[0].chainage_m = 7.2;
  EXPECT_FALSE(SeesOnlyItsRing(sewer, plan));
  sewer.network.pipes[0].joints[0].chainage_m = 6.9;
  EXPECT_TRUE(SeesOnlyItsRing(sewer, plan));
  plan.kind = LandmarkKind::kJoint;
  EXPECT_TRUE(SeesOnlyItsRing(sewer, plan));
}

TEST(LandmarkViews, ShareNoPoseBetweenTrainingAndTest) {
  std::set<double> trained;
  for (const ViewPurpose purpose : {ViewPurpose::kTraining, ViewPurpose::kTest}) {
    const LandmarkSewer sewer = DrawSewer(purpose, ViewSet::kStress, 1, 0);
    for (std::size_t view = 0; view < 100; ++view) {
      const ViewPlan plan =
          DrawView(sewer, purpose, ViewSet::kStress, 1, 0, view, LandmarkKind::kManhole);
      for (const double drawn : {plan.distance_m, plan.pitch_rad, plan.off_y_m}) {
        if (purpose == ViewPurpose::kTraining) {
          trained.insert(drawn);
        } else {
          EXPECT_FALSE(trained.contains(drawn));
        }
      }
    }
  }
}

TEST(LandmarkViews, StandInSewersThatCanBeBuilt) {
  for (const ViewSet set : kSets) {
    for (std::size_t i = 0; i < kSewers; ++i)
      EXPECT_NO_THROW(sim::BuildSewer(DrawSewer(ViewPurpose::kTest, set, 3, i).network));
  }
}

// The nearest of its kind ahead is the one that is asked for.
TEST(LandmarkViews, ShowTheirLandmarkFirst) {
  for (std::size_t i = 0; i < kSewers; ++i) {
    const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTest, ViewSet::kStress, 1, i);
    const auto& joints = sewer.pipe().joints;
    ASSERT_GE(joints.size(), 3U);
    for (std::size_t j = 1; j < joints.size(); ++j)
      EXPECT_GT(joints[j].chainage_m - joints[j - 1].chainage_m, 1.5);
    EXPECT_GE(joints.front().chainage_m, 1.5 + 0.24);  // and room behind the robot
  }
}

TEST(LandmarkViews, KeepTheirDistancesAndPosesInBounds) {
  const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTest, ViewSet::kStress, 1, 0);
  double nearest_m = 9.0, farthest_m = 0.0;
  for (std::size_t view = 0; view < 500; ++view) {
    const bool inlet = view % 2 == 0;
    const ViewPlan plan = DrawView(sewer, ViewPurpose::kTest, ViewSet::kStress, 1, 0, view,
                                   inlet ? LandmarkKind::kInletLeft : LandmarkKind::kJoint);
    EXPECT_GE(plan.distance_m, 0.3);
    EXPECT_LE(plan.distance_m, inlet ? 0.8 : 1.5);
    EXPECT_LE(std::hypot(plan.off_y_m, plan.off_z_m), 0.020);
    EXPECT_LE(std::hypot(plan.pitch_rad, plan.yaw_rad), 4.0 * std::numbers::pi / 180.0);
    EXPECT_LE(std::abs(plan.yaw_error_rad), 0.05 * std::numbers::pi / 180.0);
    if (inlet) {
      EXPECT_GT(sewer.pipe().inlets.at(plan.landmark).clock_h, 6.0);
      continue;
    }
    nearest_m = std::min(nearest_m, plan.distance_m);
    farthest_m = std::max(farthest_m, plan.distance_m);
  }
  EXPECT_LT(nearest_m, 0.35);
  EXPECT_GT(farthest_m, 1.45);
}

// Tables 4.1 and 5.4.
TEST(LandmarkViews, AreOfTheThesisKindsInItsProportions) {
  const auto counts_of = [](const std::vector<LandmarkKind>& kinds) {
    std::map<LandmarkKind, int> counts;
    for (const LandmarkKind kind : kinds) ++counts[kind];
    return std::array{counts[LandmarkKind::kManhole], counts[LandmarkKind::kJoint],
                      counts[LandmarkKind::kInletLeft], counts[LandmarkKind::kInletRight]};
  };
  EXPECT_EQ(counts_of(SpreadKinds(28, 28, 18)), (std::array{28, 28, 9, 9}));
  EXPECT_EQ(counts_of(SpreadKinds(32, 26, 12)), (std::array{32, 26, 6, 6}));
}

TEST(LandmarkViews, AreAllWetAndDimmedUnderStress) {
  std::set<network::Material> materials;
  std::set<double> diameters_m;
  for (std::size_t i = 0; i < kSewers; ++i) {
    const LandmarkSewer stress = DrawSewer(ViewPurpose::kTest, ViewSet::kStress, 1, i);
    materials.insert(stress.pipe().material);
    diameters_m.insert(stress.pipe().diameter_m);
    EXPECT_EQ(stress.pipe().condition, network::WallCondition::kWet);
    EXPECT_EQ(stress.light, 0.125);
    const LandmarkSewer plain = DrawSewer(ViewPurpose::kTest, ViewSet::kReproduction, 1, i);
    EXPECT_EQ(plain.pipe().material, network::Material::kPvc);
    EXPECT_EQ(plain.pipe().condition, network::WallCondition::kDry);
    EXPECT_EQ(plain.light, 1.0);
  }
  EXPECT_EQ(materials.size(), 4U);
  EXPECT_EQ(diameters_m, (std::set{0.200, 0.250, 0.300, 0.350}));
}

// An eighth of the light: 1/60 s instead of 5 ms makes up for 3.337, gain for the rest.
TEST(LandmarkViews, AreExposedAsAVideoCameraDoes) {
  robot::ImageSensor sensor;
  sensor.exposure_s = 0.005;
  sensor.gain = 2.0;
  const robot::ImageSensor dimmed = AutomaticExposure(sensor, 0.125);
  EXPECT_NEAR(dimmed.exposure_s, 0.0166833, 1e-7);
  EXPECT_NEAR(dimmed.exposure_s * dimmed.gain * 0.125, 0.005 * 2.0, 1e-12);
  const robot::ImageSensor bright = AutomaticExposure(sensor, 1.0);
  EXPECT_EQ(bright.exposure_s, 0.005);
  EXPECT_EQ(bright.gain, 2.0);
  const robot::ImageSensor half = AutomaticExposure(sensor, 0.5);
  EXPECT_NEAR(half.exposure_s, 0.010, 1e-12);
  EXPECT_NEAR(half.gain, 2.0, 1e-12);
}

// Nine points, one of them white: a ninth of white's exposure, of whose root the level speaks:
// 0.03 + 0.97 sqrt(1 / 9) of 255 is 90. The mean of levels, 35, would hide a thin bright ring.
TEST(FineDrawing, AveragesLightAndNotLevels) {
  cv::Mat image(3, 6, CV_8UC3, cv::Scalar::all(std::lround(255 * 0.03)));
  image.at<cv::Vec3b>(1, 1) = {255, 255, 255};
  const cv::Mat mean = MeanLight(image, 3);
  ASSERT_EQ(mean.size(), cv::Size(2, 1));
  EXPECT_NEAR(mean.at<cv::Vec3b>(0, 0)[0], 90, 1);
  EXPECT_NEAR(mean.at<cv::Vec3b>(0, 1)[2], 8, 1);
  for (const int level : {8, 9, 20, 60, 128, 254, 255}) {
    const cv::Mat even(3, 3, CV_8UC3, cv::Scalar::all(level));
    EXPECT_EQ(MeanLight(even, 3).at<cv::Vec3b>(0, 0)[1], level);
  }
  EXPECT_THROW((void)MeanLight(image, 4), std::invalid_argument);
}

// d = 2 − 0.01 n, exactly.
TEST(LandmarkCalibration, FitsALineToItsPoints) {
  const auto fit = FitEdges({{1.5, 50}, {1.0, 100}, {0.5, 150}});
  EXPECT_NEAR(fit.at_none_m, 2.0, 1e-12);
  EXPECT_NEAR(fit.per_edge_m, -0.01, 1e-12);
  EXPECT_THROW((void)FitEdges({{1.0, 7}, {2.0, 7}}), std::invalid_argument);
}

// r = 90 / d: three samples in each of two stretches; an outlier moves no median.
TEST(LandmarkCalibration, TakesMediansOfStretches) {
  const auto table =
      FitRadiusTable({{0.52, 900}, {0.55, 160}, {0.58, 150}, {1.02, 89}, {1.05, 86}, {1.08, 5}});
  ASSERT_EQ(table.distance_radius.size(), 2U);
  EXPECT_NEAR(table.distance_radius[0].first, 0.55, 1e-12);
  EXPECT_NEAR(table.distance_radius[0].second, 160, 1e-12);
  EXPECT_NEAR(table.distance_radius[1].second, 86, 1e-12);
  EXPECT_THROW((void)FitRadiusTable({{0.5, 100}}), std::invalid_argument);
}

// Medians of 100, 140 and 60 px at 0.45, 0.55 and 0.95 m: the first two cannot both be, and are two
// views each.
TEST(LandmarkCalibration, PoolsStretchesWhoseRadiiDoNotFall) {
  const auto table =
      FitRadiusTable({{0.45, 100}, {0.45, 100}, {0.55, 140}, {0.55, 140}, {0.95, 60}, {0.95, 60}});
  ASSERT_EQ(table.distance_radius.size(), 2U);
  EXPECT_NEAR(table.distance_radius[0].first, 0.50, 1e-12);
  EXPECT_NEAR(table.distance_radius[0].second, 120, 1e-12);
  EXPECT_NEAR(table.distance_radius[1].second, 60, 1e-12);
}

// r = 90 / d at 0.55 and 1.05 m, so 0.8 m is 112.5 px; of radii half as large the table says twice
// the distance.
TEST(LandmarkCalibration, LearnsATableThatTellsDistances) {
  std::vector<Sample> samples;
  for (const double distance_m : {0.54, 0.55, 0.56, 1.04, 1.05, 1.06})
    samples.push_back({distance_m, 90.0 / distance_m});
  EXPECT_NEAR(FitRadiusTable(samples).DistanceAt(112.5), 0.8, 1e-3);
  for (Sample& sample : samples) sample.x /= 2.0;
  EXPECT_NEAR(FitRadiusTable(samples).DistanceAt(112.5), 0.4, 1e-3);
}

// Errors of 2 % of what is answered, and stated deviations half as large as they ought to be.
TEST(LandmarkCalibration, FindsBiasAndScaleOfErrors) {
  std::vector<StatedError> errors;
  for (int i = -50; i <= 50; ++i) {
    const double answer_m = 1.0, error_m = 0.02 + 0.001 * i;
    errors.push_back({answer_m - error_m, error_m, 0.01});
  }
  const auto fit = FitErrors(errors);
  EXPECT_NEAR(fit.bias, 0.02, 1e-9);
  // 95 % of |i| / 10 lie within 4.8 deviations.
  EXPECT_NEAR(fit.factor, 4.8 / 1.96, 0.1);
}

}  // namespace
}  // namespace kantaro::scenarios
