#include "robot/readings.hpp"

#include <cmath>
#include <stdexcept>

namespace kantaro::robot {
namespace {

struct WhichSensor {
  Sensor operator()(const FrontImage&) const { return Sensor::kFrontCamera; }
  Sensor operator()(const StereoPair&) const { return Sensor::kStereoCameras; }
  Sensor operator()(const LaserRevolution&) const { return Sensor::kLaser; }
  Sensor operator()(const IrRanges&) const { return Sensor::kInfrared; }
  Sensor operator()(const WheelEncoders&) const { return Sensor::kEncoders; }
  Sensor operator()(const InertialReading&) const { return Sensor::kInertial; }
  Sensor operator()(const Inclination&) const { return Sensor::kInclinometer; }
  Sensor operator()(const CompassHeading&) const { return Sensor::kCompass; }
  Sensor operator()(const BatteryState&) const { return Sensor::kBattery; }
  Sensor operator()(const Loss& loss) const { return loss.sensor; }
};

}  // namespace

Sensor SensorOf(const Reading& reading) { return std::visit(WhichSensor{}, reading.value); }

const char* ToString(Sensor sensor) {
  switch (sensor) {
    case Sensor::kFrontCamera:
      return "front_camera";
    case Sensor::kStereoCameras:
      return "stereo_cameras";
    case Sensor::kLaser:
      return "laser";
    case Sensor::kInfrared:
      return "infrared";
    case Sensor::kEncoders:
      return "encoders";
    case Sensor::kInertial:
      return "inertial";
    case Sensor::kInclinometer:
      return "inclinometer";
    case Sensor::kCompass:
      return "compass";
    case Sensor::kBattery:
      return "battery";
  }
  throw std::invalid_argument("no such sensor");
}

void CheckCommand(const Command& command) {
  if (!std::isfinite(command.left_rad_s) || !std::isfinite(command.right_rad_s))
    throw std::invalid_argument("a wheel speed is no number");
  if (!(command.lights >= 0.0 && command.lights <= 1.0))
    throw std::invalid_argument("lights must be 0 to 1");
}

}  // namespace kantaro::robot
