#pragma once

#include <cstdint>
#include <string>

#include "robot/recording/recording.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/pilot.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// A mission as a recording keeps it: all that decides what the robot's program makes of the
/// readings.
struct RecordedMission {
  std::string program;  ///< name and version of what recorded it
  Scenario scenario;
  Conditions conditions;
  RobotFiles robot;
};

/// The files to record with a run: the scenario's text, the network as YAML, the robot's five
/// files, the seed and this program's version.
/// @param scenario  as it is driven, cut to the surroundings of its route.
/// @throws InputError if one of the files is gone.
[[nodiscard]] robot::MissionFiles MissionFilesOf(const Scenario& scenario, std::uint64_t seed);

/// The mission of a recording. @throws InputError naming the recording and the file in it.
[[nodiscard]] RecordedMission MissionOf(const robot::Recording& recording);

}  // namespace kantaro::scenarios
