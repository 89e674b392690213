#include "scenarios/blinded.hpp"

#include <variant>

namespace kantaro::scenarios {
namespace {

/// Absent for what is never taken from the robot: its wheels and its inertial unit.
std::optional<Sense> SenseOf(const robot::Reading& reading) {
  if (std::holds_alternative<robot::LaserRevolution>(reading.value)) return Sense::kLaser;
  if (std::holds_alternative<robot::IrRanges>(reading.value)) return Sense::kInfrared;
  if (std::holds_alternative<robot::FrontImage>(reading.value) ||
      std::holds_alternative<robot::StereoPair>(reading.value)) {
    return Sense::kCameras;
  }
  return {};
}

}  // namespace

std::optional<robot::Reading> Blinded::Read() {
  std::optional<robot::Reading> reading = hardware_.Read();
  while (reading) {
    const std::optional<Sense> sense = SenseOf(*reading);
    if (!sense || dead_.count(*sense) == 0) break;
    reading = hardware_.Read();
  }
  return reading;
}

}  // namespace kantaro::scenarios
