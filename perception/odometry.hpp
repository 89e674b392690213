#pragma once

#include <array>

#include "perception/observations.hpp"
#include "robot/description.hpp"
#include "robot/readings.hpp"

namespace kantaro::perception {

/// Encoder angles as travel of the tyres' surface: angle times nominal radius. Slip and the tilt of
/// cambered wheels against the wall are not in it; navigation corrects them at landmarks.
class Odometry {
 public:
  /// @throws std::invalid_argument unless the description lists four wheels, each with a tyre.
  explicit Odometry(const robot::Description& description);

  /// Front left, front right, rear left, rear right. @throws std::invalid_argument for an angle
  /// that is not finite.
  [[nodiscard]] OdometryObservation Travel(const robot::WheelEncoders& encoders,
                                           robot::RunTime captured_at) const;

 private:
  std::array<double, 4> radius_m_{};
};

}  // namespace kantaro::perception
