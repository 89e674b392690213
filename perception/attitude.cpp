#include "perception/attitude.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::perception {

AttitudeObservation AttitudeFilter::Update(const robot::InertialReading& reading,
                                           robot::RunTime captured_at) {
  if (!reading.angular_velocity_rad_s.allFinite() || !reading.specific_force_m_s2.allFinite()) {
    throw std::invalid_argument("an inertial reading is not a finite number");
  }
  // At rest the specific force points up: a high left side (+y) shows as a positive y.
  const double tilt_rad =
      std::atan2(reading.specific_force_m_s2.y(), reading.specific_force_m_s2.z());
  AttitudeObservation attitude{captured_at, tilt_rad, reading.angular_velocity_rad_s.x(),
                               reading.angular_velocity_rad_s.z()};
  if (last_) {
    const double step_s = robot::Seconds(captured_at - last_->captured_at);
    const double summed_rad = last_->roll_rad + attitude.roll_rate_rad_s * step_s;
    const double share = std::clamp(step_s / kTimeConstant_s, 0.0, 1.0);
    attitude.roll_rad = summed_rad + share * (tilt_rad - summed_rad);
  }
  last_ = attitude;
  return attitude;
}

}  // namespace kantaro::perception
