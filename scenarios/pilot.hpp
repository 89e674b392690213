#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "navigation/executive.hpp"
#include "navigation/parameters.hpp"
#include "perception/parameters.hpp"
#include "perception/perception.hpp"
#include "robot/description.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// The files of a robot: its body, and the parameters of what runs on it.
struct RobotFiles {
  robot::Description description;
  perception::Parameters perception;
  navigation::Parameters navigation;
};

/// @throws InputError
[[nodiscard]] RobotFiles ReadRobotFiles(const std::filesystem::path& folder);

/// The robot's own program on its mission: from a reading to a command. It knows the map and where
/// it was to be set down, and nothing else of the world.
class Pilot {
 public:
  /// @param conditions  of which it gets the map alone.
  Pilot(const Scenario& scenario, const Conditions& conditions, const RobotFiles& robot);

  /// Told each observation before the executive takes it.
  using Watch = std::function<void(const perception::Observation&, const navigation::Executive&)>;

  /// Takes one reading, in order of arrival.
  /// @returns the command that it leads to; absent if the one before stands.
  [[nodiscard]] std::optional<robot::Command> Step(const robot::Reading& reading,
                                                   const Watch& watch);

  [[nodiscard]] navigation::Executive& executive() { return executive_; }

 private:
  perception::Perception perception_;
  navigation::Executive executive_;
};

}  // namespace kantaro::scenarios
