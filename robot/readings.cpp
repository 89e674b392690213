#include "robot/readings.hpp"

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

}  // namespace kantaro::robot
