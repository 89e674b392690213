#include "sim/battery_pack.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::sim {

BatteryPack::BatteryPack(const robot::Battery& battery, double charge) : battery_(battery) {
  if (!(charge >= 0.0 && charge <= 1.0)) throw std::invalid_argument("a charge is 0 to 1");
  state_ = {battery.OpenVoltage(charge), 0.0, charge};
}

void BatteryPack::Draw(double power_W, double step_s) {
  if (off_) return;
  // V I = P with V = V0 − R I; the smaller of both currents. Beyond V0² / 4 R there is none.
  const double open_V = battery_.OpenVoltage(state_.charge);
  const double root = open_V * open_V - 4.0 * battery_.resistance_ohm * power_W;
  const double current_A =
      root < 0.0 ? 0.0 : 2.0 * power_W / (open_V + std::sqrt(root));  // also right for R = 0
  state_.current_A = current_A;
  state_.voltage_V = open_V - battery_.resistance_ohm * current_A;
  state_.charge = std::max(0.0, state_.charge - current_A * step_s / battery_.capacity_As);
  off_ = root < 0.0 || state_.charge == 0.0 || state_.voltage_V < battery_.cutoff_V;
}

double MotorPower_W(const robot::Battery& battery, double torque_Nm, double speed_rad_s) {
  const double work_W = std::max(0.0, torque_Nm * speed_rad_s);
  return work_W / battery.motor_efficiency +
         battery.motor_copper_W_per_Nm2 * torque_Nm * torque_Nm + battery.motor_idle_W;
}

}  // namespace kantaro::sim
