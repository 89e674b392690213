#include "scenarios/experiments/laser_accuracy.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace kantaro::scenarios {
namespace {

robot::Laser Shipped() {
  return robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro").laser;
}

// The bound of ±1 mm is three standard deviations of the error; cutting them at three takes little
// off: 0.333 mm times 0.9867 (a normal cut, its tails heaped at the cut: variance 0.9733 + …).
TEST(MeasureLaser, FindsTheErrorsOfTable51) {
  const LaserErrors errors = MeasureLaser(Shipped(), 0.130, 30, 1);
  EXPECT_EQ(errors.beams, 30u * 336u);
  EXPECT_EQ(errors.too_near + errors.too_far, 0u);
  EXPECT_NEAR(errors.mean_m, 0.0, 4.0 * 0.333e-3 / std::sqrt(30.0 * 336.0));
  EXPECT_NEAR(errors.deviation_m, 0.333e-3, 0.01e-3);
  EXPECT_LE(errors.largest_m, 1.002e-3);  // facets of the target, depth of the disc: 1 µm each
}

// Outside 70 to 190 mm nothing is measured; at the very end, half of the errors lead out.
TEST(MeasureLaser, FindsTheEndsOfTheRange) {
  const LaserErrors near = MeasureLaser(Shipped(), 0.060, 3, 1);
  EXPECT_EQ(near.too_near, near.beams);
  const LaserErrors far = MeasureLaser(Shipped(), 0.200, 3, 1);
  EXPECT_EQ(far.too_far, far.beams);
  const LaserErrors end = MeasureLaser(Shipped(), 0.190, 30, 1);
  EXPECT_NEAR(static_cast<double>(end.too_far) / static_cast<double>(end.beams), 0.5, 0.03);
}

TEST(LaserAccuracy, PassesAndSaysSoForPeopleToo) {
  const Experiment experiment = LaserAccuracyExperiment();
  ExperimentOptions options;
  options.robot_folder = KANTARO_SOURCE_DIR "/models/kantaro";
  options.count = 2;
  const auto result = experiment.run(options);
  EXPECT_TRUE(result.at("passed").get<bool>()) << result.dump(1);
  EXPECT_EQ(result.at("rows").size(), 15u);
  EXPECT_THAT(experiment.table(result), testing::HasSubstr("1800 rpm    60 revolutions in 2 s"));
  EXPECT_THAT(experiment.chapter(result), testing::HasSubstr("| 60 | – | – | – | 100 % | 0 % |"));
}

}  // namespace
}  // namespace kantaro::scenarios
