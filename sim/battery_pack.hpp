#pragma once

#include "robot/readings.hpp"
#include "robot/sensor_parameters.hpp"

namespace kantaro::sim {

/// A pack that everything draws from: an open-circuit voltage by charge behind a resistance. It
/// switches itself off for good when it is empty or its voltage falls below the cut-off.
class BatteryPack {
 public:
  /// @param charge  0 to 1. @throws std::invalid_argument outside
  BatteryPack(const robot::Battery& battery, double charge);

  /// Power is drawn for a time.
  void Draw(double power_W, double step_s);

  [[nodiscard]] bool off() const { return off_; }
  /// As it was during the last draw.
  [[nodiscard]] const robot::BatteryState& state() const { return state_; }

 private:
  robot::Battery battery_;
  robot::BatteryState state_;
  bool off_{};
};

/// What a motor takes for a torque at its wheel and the wheel's speed: the work, through gear and
/// bridge, and the heat of its winding. Braking gives nothing back.
[[nodiscard]] double MotorPower_W(const robot::Battery& battery, double torque_Nm,
                                  double speed_rad_s);

}  // namespace kantaro::sim
