#include "perception/ir_landmarks.hpp"

#include <stdexcept>

namespace kantaro::perception {

IrLandmarks::IrLandmarks(const IrParameters& parameters) : parameters_(parameters) {
  if (parameters.readings < 1)
    throw std::invalid_argument("IR landmarks need at least one reading");
}

IrObservation IrLandmarks::Update(const robot::IrRanges& ranges, robot::RunTime captured_at) {
  IrObservation observation;
  observation.captured_at = captured_at;
  observation.manhole = Settle(up_, ranges.up.value < parameters_.manhole_threshold);
  observation.junction_left = Settle(left_, ranges.left.value < parameters_.junction_threshold);
  observation.junction_right = Settle(right_, ranges.right.value < parameters_.junction_threshold);
  return observation;
}

bool IrLandmarks::Settle(Sensor& sensor, bool open) const {
  sensor.run = open == sensor.open ? 0 : sensor.run + 1;
  if (sensor.run >= parameters_.readings) {
    sensor.open = open;
    sensor.run = 0;
  }
  return sensor.open;
}

}  // namespace kantaro::perception
