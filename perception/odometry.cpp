#include "perception/odometry.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace kantaro::perception {

Odometry::Odometry(const robot::Description& description) {
  if (description.wheels.size() != radius_m_.size()) {
    throw std::invalid_argument(
        fmt::format("odometry needs four wheels, the robot has {}", description.wheels.size()));
  }
  for (std::size_t i = 0; i < radius_m_.size(); ++i) {
    const auto tyre = description.tyres.find(description.wheels[i]);
    if (tyre == description.tyres.end()) {
      throw std::invalid_argument(
          fmt::format("odometry: wheel \"{}\" has no tyre", description.wheels[i]));
    }
    radius_m_[i] = tyre->second.radius_m;
  }
}

OdometryObservation Odometry::Travel(const robot::WheelEncoders& encoders,
                                     robot::RunTime captured_at) const {
  std::array<double, 4> travel_m{};
  for (std::size_t i = 0; i < travel_m.size(); ++i) {
    if (!std::isfinite(encoders.angle_rad[i])) {
      throw std::invalid_argument("an encoder angle is not a finite number");
    }
    travel_m[i] = encoders.angle_rad[i] * radius_m_[i];
  }
  OdometryObservation observation;
  observation.captured_at = captured_at;
  observation.left_m = (travel_m[0] + travel_m[2]) / 2;
  observation.right_m = (travel_m[1] + travel_m[3]) / 2;
  observation.travel_m = (observation.left_m + observation.right_m) / 2;
  return observation;
}

}  // namespace kantaro::perception
