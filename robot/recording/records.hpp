#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>

#include "robot/hardware.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// What was settled before a run began, as named texts: the robot's files and whatever the writer
/// adds. With them a recording is played back on any machine.
using MissionFiles = std::map<std::string, std::string>;
/// Always among them: what ParseDescription takes.
inline constexpr const char* kUrdfFile = "kantaro.urdf";
inline constexpr const char* kCompanionFile = "kantaro.yaml";
inline constexpr const char* kCamerasFile = "cameras.yaml";

/// A command, and what became of it.
struct RecordedCommand {
  RunTime at{};
  Command command;
  CommandOutcome outcome{};
};

/// Where the robot believed it was, in its own terms: a leg of its route, and the way along it.
struct RecordedEstimate {
  RunTime at{};
  std::string pipe;       ///< of the leg
  std::uint32_t leg{};    ///< of the route, from 0
  double distance_m{};    ///< from the wall of the manhole where it entered the pipe
  double deviation_m{};   ///< standard deviation of the distance
  double leg_length_m{};  ///< wall to wall, as believed
};

/// Something the robot had to tell.
struct RecordedEvent {
  RunTime at{};
  std::string kind;  ///< one word
  std::string text;
};

/// What a recording consists of.
using Record = std::variant<Reading, RecordedCommand, RecordedEstimate, RecordedEvent>;

}  // namespace kantaro::robot
