#pragma once

#include <filesystem>
#include <memory>

#include "robot/description.hpp"
#include "robot/hardware.hpp"

namespace kantaro::robot {

/// A real robot, or the firmware emulator: two serial lines that speak docs/wire_protocol.md, and
/// cameras through VideoCapture.
///
/// Readings are handed over as they arrive, on the host's monotonic clock; with an emulator in
/// lockstep, on the controller's. The last command is repeated while Read() waits, and only then: a
/// program that hangs lets the robot's watchdog stop it. A line that goes down stays down; the run
/// ends when the controller's is. Destruction stops the robot.
///
/// @param config  a file as in docs/device.md. @param robot  must be the robot that answers.
/// @throws InputError if the file is wrong, or what it names cannot be opened or is not that robot.
[[nodiscard]] std::unique_ptr<Hardware> OpenDevice(const std::filesystem::path& config,
                                                   const Description& robot);

}  // namespace kantaro::robot
