#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "scenarios/experiments/ir_landmarks.hpp"
#include "scenarios/experiments/laser_landmarks.hpp"

namespace kantaro::scenarios {
namespace {

const std::string kRobot = KANTARO_SOURCE_DIR "/models/kantaro";

// 0.4 m of shaft radius plus run-up: the course lies about its landmark, whichever way it is
// driven.
TEST(LandmarkCourse, PutsTheLandmarkAtTheOrigin) {
  for (const bool downstream : {true, false}) {
    const LandmarkCourse inlet =
        MakeLandmarkCourse(PassedKind::kInletLeft, 0.300, downstream, 0.150);
    const network::Pipe& pipe = inlet.network.PipeNamed("in");
    const sim::Sewer sewer = sim::BuildSewer(inlet.network);
    EXPECT_NEAR(sewer.axes.at(0).PoseAt(pipe.inlets.at(0).chainage_m).translation().x(), 0.0, 1e-9);
    EXPECT_EQ(pipe.inlets.at(0).clock_h, downstream ? 9.0 : 3.0);  // looking downstream
    EXPECT_EQ(inlet.status, perception::LaserStatus::kInletLeft);
  }
  const LandmarkCourse manhole = MakeLandmarkCourse(PassedKind::kManhole, 0.300, true);
  EXPECT_EQ(manhole.network.ManholeNamed("M").p_WM, Eigen::Vector3d::Zero());
  EXPECT_NEAR(manhole.end_x_m, 0.150 + 0.250 + 0.250, 1e-9);
}

// One drive past each kind; 300 mm, upright: both methods must know them all (thesis fig 5.26).
TEST(LaserLandmarks, AreKnownInTheThesisOwnPipe) {
  ExperimentOptions options;
  options.robot_folder = kRobot;
  options.count = 7;
  options.jobs = 2;
  const Experiment experiment = LaserLandmarksExperiment();
  const auto result = experiment.run(options);
  for (const auto& row : result.at("rows")) {
    if (row.at("set") != "reproduction") continue;
    EXPECT_EQ(row.at("recognised"), 1.0) << row.dump(1);
    // The thesis' edges are dated to whole revolutions, 5 mm each, and slip adds to neither.
    if (row.contains("largest_error_m")) {
      EXPECT_LT(row.at("largest_error_m"), row.at("method") == "ours" ? 0.010 : 0.020)
          << row.dump(1);
    }
  }
  EXPECT_THAT(experiment.chapter(result),
              testing::HasSubstr("| reproduction | ours | all | all | 7 |"));
}

// The wall of a 300 mm pipe reads about a half, a shaft's far wall nearly nothing (1 / (1 + r²)).
TEST(InfraredLandmarks, ShowALargeVariation) {
  ExperimentOptions options;
  options.robot_folder = kRobot;
  options.count = 4;
  options.jobs = 2;
  const Experiment experiment = IrLandmarksExperiment();
  const auto result = experiment.run(options);
  for (const auto& row : result.at("rows")) {
    if (row.at("set") != "reproduction") continue;
    EXPECT_EQ(row.at("recognised"), 1.0) << row.dump(1);
    EXPECT_GT(row.at("value_in_pipe"), 0.40) << row.dump(1);
    if (row.at("landmark") != "none (joints)") {
      EXPECT_LT(row.at("value_at_landmark"), 0.15) << row.dump(1);
    }
  }
  EXPECT_THAT(experiment.chapter(result), testing::HasSubstr("junction (IR-3), x in mm"));
}

}  // namespace
}  // namespace kantaro::scenarios
