#include "perception/parameters.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "base/files.hpp"
#include "base/input_error.hpp"

namespace kantaro::perception {
namespace {

std::string ShippedFile() {
  return std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/perception.yaml";
}

/// The shipped file with one text replaced, written beside the tests.
std::filesystem::path Altered(const std::string& from, const std::string& to) {
  std::string text = ReadInputFile(ShippedFile());
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto file = std::filesystem::path(testing::TempDir()) /
                    ("altered_perception_" + std::to_string(getpid()) + ".yaml");
  WriteFileAtomically(file, text);
  return file;
}

void ExpectRefused(const std::string& from, const std::string& to, const std::string& field) {
  try {
    (void)ReadParameters(Altered(from, to));
    FAIL() << to << " was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), field);
    EXPECT_TRUE(error.line().has_value());
  }
}

TEST(PerceptionParameters, HoldTheThesisThresholds) {
  const Parameters parameters = ReadParameters(ShippedFile());
  EXPECT_DOUBLE_EQ(parameters.laser.threshold_m, 0.175);           // Table 5.3
  EXPECT_NEAR(parameters.laser.window_rad, 0.26180, 1e-5);         // 15°
  EXPECT_DOUBLE_EQ(parameters.faults.horizontal_threshold, 0.97);  // fig 3.9
  EXPECT_DOUBLE_EQ(parameters.faults.vertical_threshold, 0.96);    // fig 3.10
  EXPECT_EQ(parameters.faults.edge_operator, EdgeOperator::kSobel);
  EXPECT_EQ(parameters.stereo.feature_threshold, 10);              // section 5.3.2
  EXPECT_DOUBLE_EQ(parameters.stereo.peak_ratio, 0.2);             // section 5.3.2
  EXPECT_DOUBLE_EQ(parameters.stereo.neighbour_threshold_px, 10);  // section 5.3.2
  EXPECT_EQ(parameters.stereo.window_px, 7);                       // sections 5.3.2, 5.4.2
  EXPECT_EQ(parameters.stereo.gaussian_window_px, 7);              // section 5.4.2
  EXPECT_DOUBLE_EQ(parameters.stereo.gaussian_px, 3);              // section 5.4.2
  EXPECT_DOUBLE_EQ(parameters.stereo.gradient_scale, 32);          // section 5.4.2
}

TEST(PerceptionParameters, RefuseUnknownAndMissingKeys) {
  ExpectRefused("revolutions:", "rotations:", "laser.rotations");
  ExpectRefused("laser:", "lidar:", "lidar");
  ExpectRefused("peak_ratio:", "peak_value:", "stereo.peak_value");
  ExpectRefused("  readings: 3", "", "infrared");
}

TEST(PerceptionParameters, RefuseWrongValues) {
  ExpectRefused("threshold_mm: 175", "threshold_mm: wide", "laser.threshold_mm");
  ExpectRefused("threshold_mm: 175", "threshold_mm: -175", "laser.threshold_mm");
  ExpectRefused("threshold_mm: 175", "threshold_mm: 200", "laser.far_limit_mm");
  ExpectRefused("revolutions: 3", "revolutions: 0", "laser.revolutions");
  ExpectRefused("method: thesis", "method: theirs", "laser.method");
  ExpectRefused("far_mm: 1600", "far_mm: 200", "rings.far_mm");
  ExpectRefused("sobel", "canny", "faults.edge_operator");
  ExpectRefused("horizontal_threshold: 0.97", "horizontal_threshold: 1.2",
                "faults.horizontal_threshold");
  ExpectRefused("method: fast-cubic", "method: census", "stereo.method");
  ExpectRefused("disparities: 64", "disparities: 0", "stereo.disparities");
  ExpectRefused("gaussian_window_px: 7", "gaussian_window_px: 8", "stereo.gaussian_window_px");
  ExpectRefused("constraint: as-written", "constraint: on", "stereo.function_value_constraint");
  ExpectRefused("corner_disparity: combined", "corner_disparity: 3", "stereo.corner_disparity");
  ExpectRefused("corner_support: 4", "corner_support: 9", "stereo.corner_support");
  ExpectRefused("steepest_wall: 0.6", "steepest_wall: -1", "stereo.steepest_wall");
  ExpectRefused("ignore_joints: true", "ignore_joints: maybe", "faults.ignore_joints");
}

TEST(PerceptionParameters, RefuseAMissingFile) {
  EXPECT_THROW((void)ReadParameters("no/such/perception.yaml"), InputError);
}

}  // namespace
}  // namespace kantaro::perception
