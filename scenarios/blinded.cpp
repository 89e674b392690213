#include "scenarios/blinded.hpp"

namespace kantaro::scenarios {
namespace {

/// Absent for what is never taken from the robot: its wheels and its inertial unit.
std::optional<Sense> SenseOf(const robot::Reading& reading) {
  switch (robot::SensorOf(reading)) {
    case robot::Sensor::kLaser:
      return Sense::kLaser;
    case robot::Sensor::kInfrared:
      return Sense::kInfrared;
    case robot::Sensor::kFrontCamera:
    case robot::Sensor::kStereoCameras:
      return Sense::kCameras;
    default:
      return {};
  }
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
