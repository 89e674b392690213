#include "scenarios/landmark_calibration.hpp"

#include <gtest/gtest.h>

#include <string>

#include "perception/parameters.hpp"

namespace kantaro::scenarios {
namespace {

// Twice the same, with one thread and with two.
TEST(LandmarkCalibration, IsTheSameToTheByteEveryTime) {
  const std::string folder = std::string(KANTARO_SOURCE_DIR) + "/models/kantaro";
  const robot::Description robot = robot::ReadDescription(folder);
  const auto parameters = perception::ReadParameters(folder + "/perception.yaml").landmarks;
  const auto calibrate = [&](unsigned jobs) {
    CalibrationOptions options;
    options.views = 18;
    options.jobs = jobs;
    perception::LandmarkCalibration calibration;
    CalibrateThesis(robot, parameters, ViewSet::kField, ViewCameras::kFront, options, calibration);
    for (auto& learnt : calibration.classes) learnt.shorter = learnt.longer = {1.0, -0.001};
    return ToYaml(calibration, "learnt");
  };
  const std::string once = calibrate(1);
  EXPECT_EQ(once, calibrate(2));
}

}  // namespace
}  // namespace kantaro::scenarios
