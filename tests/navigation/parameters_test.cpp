#include "navigation/parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>

#include "base/files.hpp"
#include "base/input_error.hpp"

namespace kantaro::navigation {
namespace {

const std::filesystem::path kShipped = KANTARO_SOURCE_DIR "/models/kantaro/navigation.yaml";

/// The shipped file with the first occurrence of a text replaced.
std::filesystem::path Altered(const std::string& from, const std::string& to) {
  std::string text = ReadInputFile(kShipped);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto file = std::filesystem::path(testing::TempDir()) /
                    ("altered_navigation_" + std::to_string(getpid()) + ".yaml");
  WriteFileAtomically(file, text);
  return file;
}

/// 1-based line of the first occurrence in the shipped file.
int LineOf(const std::string& text) {
  const std::string file = ReadInputFile(kShipped);
  return 1 + static_cast<int>(
                 std::count(file.begin(), file.begin() + static_cast<long>(file.find(text)), '\n'));
}

void ExpectRefused(const std::string& from, const std::string& to, const std::string& field,
                   std::optional<int> line) {
  try {
    (void)ReadParameters(Altered(from, to));
    ADD_FAILURE() << to << " was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), field) << error.what();
    EXPECT_EQ(error.line(), line) << error.what();
  }
}

TEST(NavigationParameters, ShippedFileKeepsTheThesisSpeedLimit) {
  const Parameters p = ReadParameters(kShipped);
  for (const double speed : {p.cruise_m_s, p.approach_m_s, p.reverse_m_s, p.turn_m_s}) {
    EXPECT_GT(speed, 0.0);
    EXPECT_LE(speed, 0.15);
  }
}

TEST(NavigationParameters, ReadsDegreesAsRadians) {
  const Parameters p = ReadParameters(Altered("tolerance_deg: 12", "tolerance_deg: 18"));
  EXPECT_NEAR(p.turn_tolerance_rad, std::numbers::pi / 10.0, 1e-12);
}

TEST(NavigationParameters, RefusesASpeedAboveTheLimit) {
  ExpectRefused("cruise_m_s: 0.13", "cruise_m_s: 0.2", "speeds.cruise_m_s", LineOf("cruise_m_s"));
  ExpectRefused("turn_m_s: 0.07", "turn_m_s: -0.07", "speeds.turn_m_s", LineOf("turn_m_s"));
}

TEST(NavigationParameters, RefusesUnknownAndMissingKeys) {
  ExpectRefused("wall_m:", "shaft_m:", "errors.shaft_m", LineOf("wall_m"));
  ExpectRefused("silence_s: 2.0", "quiet_s: 2.0", "quiet_s", LineOf("silence_s"));
  // A map begins where yaml-cpp sees its first key.
  ExpectRefused("  lead_m: 0.06", "# lead_m: 0.06", "turn", LineOf("  ratio: 0.8"));
}

TEST(NavigationParameters, RefusesWrongValues) {
  ExpectRefused("travel: 0.004", "travel: little", "errors.travel", LineOf("travel: 0.004"));
  ExpectRefused("map: 0.03", "map: 0", "errors.map", LineOf("map: 0.03"));
  ExpectRefused("silence_s: 2.0", "silence_s: .nan", "silence_s", LineOf("silence_s"));
}

TEST(NavigationParameters, RefusesAMissingFile) {
  EXPECT_THROW((void)ReadParameters("no/such/navigation.yaml"), InputError);
}

// The URDF: laser 170 mm behind the base, IR 110 mm and camera 148 mm before it, front wheels at 90
// mm; tyres of 45 mm.
TEST(RobotGeometry, ComesFromTheDescription) {
  const RobotGeometry geometry =
      RobotGeometry::Of(robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro"));
  EXPECT_NEAR(geometry.laser_x_m, -0.17, 1e-9);
  EXPECT_NEAR(geometry.infrared_x_m, 0.11, 1e-9);
  EXPECT_NEAR(geometry.camera_x_m, 0.148, 1e-9);
  EXPECT_NEAR(geometry.front_axle_x_m, 0.09, 1e-9);
  EXPECT_NEAR(geometry.tyre_radius_m, 0.045, 1e-9);
}

}  // namespace
}  // namespace kantaro::navigation
