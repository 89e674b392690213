#pragma once

#include <optional>

#include "perception/observations.hpp"
#include "robot/readings.hpp"

namespace kantaro::perception {

/// How the robot lies, from its inertial unit: the gyro's roll rate, summed, and drawn towards the
/// direction of gravity in the accelerometer with a time constant (a complementary filter). Jolts
/// pass too fast to matter, the gyro's drift too slowly. Roll is about the base's x; a pitch of a
/// few degrees changes it by its square.
class AttitudeFilter {
 public:
  /// Long against the jolts at a joint, short against a roll along the pipe.
  static constexpr double kTimeConstant_s = 0.5;

  /// In order of capture. The first reading starts at what the accelerometer says.
  /// @throws std::invalid_argument for a number that is not finite.
  [[nodiscard]] AttitudeObservation Update(const robot::InertialReading& reading,
                                           robot::RunTime captured_at);

 private:
  std::optional<AttitudeObservation> last_;
};

}  // namespace kantaro::perception
