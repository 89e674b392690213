#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "scenarios/experiments/landmark_views.hpp"
#include "scenarios/runner.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kApproach_m = 0.36;  // five pictures

/// How a robot's attitude changes on a metre.
struct Sway {
  double roll_rad_m{}, yaw_rad_m{};  ///< root of the mean square
};

Sway OfViews() {
  const LandmarkSewer sewer = DrawSewer(ViewPurpose::kTest, ViewSet::kStress, 1, 0);
  constexpr std::size_t kViews = 2000;
  Sway sum;
  for (std::size_t i = 0; i < kViews; ++i) {
    const Weave weave = DrawView(sewer, ViewPurpose::kTest, ViewSet::kStress, 1, 0, i,
                                 perception::LandmarkKind::kJoint)
                            .weave;
    const double wave_rad_m = 2.0 * std::numbers::pi / weave.length_m;
    sum.roll_rad_m += std::pow(weave.roll_rad * wave_rad_m * std::cos(weave.roll_phase_rad), 2.0);
    sum.yaw_rad_m += std::pow(weave.yaw_rad * wave_rad_m * std::cos(weave.yaw_phase_rad), 2.0);
  }
  return {std::sqrt(sum.roll_rad_m / kViews), std::sqrt(sum.yaw_rad_m / kViews)};
}

/// Of a mission in a straight pipe along +Wx, from samples one approach apart.
Sway OfMission(const MissionTrace& trace, const std::string& pipe) {
  std::vector<const TruthSample*> there;
  for (const TruthSample& sample : trace.truth)
    if (sample.place.pipe == pipe) there.push_back(&sample);
  Sway sum;
  std::size_t count = 0, last = 0;
  for (std::size_t first = 0; first < there.size(); ++first) {
    const auto x = [&](std::size_t i) { return there[i]->X_WB.translation().x(); };
    while (last < there.size() && x(last) - x(first) < kApproach_m) ++last;
    if (last == there.size()) break;
    const Eigen::Matrix3d from = there[first]->X_WB.linear(), to = there[last]->X_WB.linear();
    const auto roll_rad = [](const Eigen::Matrix3d& R) { return std::atan2(R(2, 1), R(2, 2)); };
    const auto yaw_rad = [](const Eigen::Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); };
    const double travel_m = x(last) - x(first);
    sum.roll_rad_m += std::pow((roll_rad(to) - roll_rad(from)) / travel_m, 2.0);
    sum.yaw_rad_m += std::pow((yaw_rad(to) - yaw_rad(from)) / travel_m, 2.0);
    ++count;
  }
  return {std::sqrt(sum.roll_rad_m / static_cast<double>(count)),
          std::sqrt(sum.yaw_rad_m / static_cast<double>(count))};
}

// What views take for granted of the robot is what physics makes of it on the two straight pipes of
// route 1, steering and all.
TEST(LandmarkViews, SwayAsTheTwinDoesInMissions) {
  const Sway views = OfViews();
  Scenario scenario = ReadScenario(std::string(KANTARO_SOURCE_DIR) + "/scenarios/route_1.yaml");
  for (const robot::Sensor sensor : {robot::Sensor::kFrontCamera, robot::Sensor::kStereoCameras})
    scenario.faults.push_back(Blind(sensor));  // which saves the drawing
  scenario.time_limit_s = 110.0;
  double roll = 0.0, yaw = 0.0;
  constexpr int kSeeds = 3;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const MissionTrace trace = RunMission(scenario, static_cast<std::uint64_t>(seed), {}).trace;
    for (const char* pipe : {"P1", "P2"}) {
      const Sway mission = OfMission(trace, pipe);
      roll += mission.roll_rad_m * mission.roll_rad_m / (2 * kSeeds);
      yaw += mission.yaw_rad_m * mission.yaw_rad_m / (2 * kSeeds);
    }
  }
  EXPECT_GT(views.roll_rad_m, 0.8 * std::sqrt(roll));
  EXPECT_LT(views.roll_rad_m, 2.0 * std::sqrt(roll));
  EXPECT_GT(views.yaw_rad_m, 0.8 * std::sqrt(yaw));
  EXPECT_LT(views.yaw_rad_m, 2.0 * std::sqrt(yaw));
}

}  // namespace
}  // namespace kantaro::scenarios
