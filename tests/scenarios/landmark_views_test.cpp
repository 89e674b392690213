#include "scenarios/experiments/landmark_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <tuple>

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

TEST(LandmarkViews, AreOfTheThesisKindsInItsProportions) {
  const auto kinds = SpreadKinds(28, 28, 18);
  std::map<LandmarkKind, int> counts;
  for (const LandmarkKind kind : kinds) ++counts[kind];
  EXPECT_EQ(counts[LandmarkKind::kManhole], 28);
  EXPECT_EQ(counts[LandmarkKind::kJoint], 28);
  EXPECT_EQ(counts[LandmarkKind::kInletLeft], 9);
  EXPECT_EQ(counts[LandmarkKind::kInletRight], 9);
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
