#include "robot/sensor_parameters.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>

namespace kantaro::robot {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMicrotesla = 1e-6;

double Rate(const YamlNode& node) { return node["rate_Hz"].Number(0.1, 1000.0); }

double Degrees(const YamlNode& node, double most_deg) {
  return node.Number(0.0, most_deg) * kDegree;
}

std::map<double, double> ReadCurve(const YamlNode& list) {
  std::map<double, double> curve;
  for (const YamlNode& point : list.Elements()) {
    const std::vector<double> pair = point.Numbers(2);
    if (!(pair[0] >= 0.0 && pair[0] <= 1.0)) throw point.Error("a charge lies within 0 and 1");
    if (!curve.empty() && (pair[0] <= curve.rbegin()->first || pair[1] <= curve.rbegin()->second)) {
      throw point.Error("charge and voltage must rise from point to point");
    }
    if (!(pair[1] > 0.0 && pair[1] <= 100.0)) throw point.Error("a voltage is above 0, up to 100");
    curve.emplace(pair[0], pair[1]);
  }
  if (curve.empty() || curve.begin()->first != 0.0 || curve.rbegin()->first != 1.0) {
    throw list.Error("points [charge, volts] are wanted from charge 0 to charge 1");
  }
  return curve;
}

}  // namespace

double Battery::OpenVoltage(double charge) const {
  const double held = std::clamp(charge, 0.0, 1.0);
  const auto above = voltage_V.lower_bound(held);
  if (above == voltage_V.begin()) return above->second;
  const auto below = std::prev(above);
  const double share = (held - below->first) / (above->first - below->first);
  return below->second + share * (above->second - below->second);
}

InertialUnit ReadInertialUnit(const YamlNode& node) {
  node.AllowOnly({"rate_Hz", "gyro_noise_rad_s", "gyro_bias_rad_s", "gyro_walk_rad_s",
                  "gyro_range_rad_s", "accelerometer_noise_m_s2", "accelerometer_bias_m_s2",
                  "accelerometer_range_m_s2"});
  InertialUnit unit;
  unit.rate_Hz = Rate(node);
  unit.gyro_noise_rad_s = node["gyro_noise_rad_s"].Number(0.0, 1e3);
  unit.gyro_bias_rad_s = node["gyro_bias_rad_s"].Number(0.0, 1.0);
  unit.gyro_walk_rad_s = node["gyro_walk_rad_s"].Number(0.0, 1.0);
  unit.gyro_range_rad_s = node["gyro_range_rad_s"].Number(0.1, 1e3);
  unit.accelerometer_noise_m_s2 = node["accelerometer_noise_m_s2"].Number(0.0, 1e3);
  unit.accelerometer_bias_m_s2 = node["accelerometer_bias_m_s2"].Number(0.0, 10.0);
  unit.accelerometer_range_m_s2 = node["accelerometer_range_m_s2"].Number(9.9, 1e4);
  return unit;
}

Inclinometer ReadInclinometer(const YamlNode& node) {
  node.AllowOnly({"rate_Hz", "lag_s", "noise_deg", "resolution_deg", "range_deg"});
  Inclinometer inclinometer;
  inclinometer.rate_Hz = Rate(node);
  inclinometer.lag_s = node["lag_s"].Number(0.0, 10.0);
  inclinometer.noise_rad = Degrees(node["noise_deg"], 45.0);
  inclinometer.resolution_rad = node["resolution_deg"].Number(1e-6, 10.0) * kDegree;
  inclinometer.range_rad = node["range_deg"].Number(1.0, 89.0) * kDegree;
  return inclinometer;
}

Compass ReadCompass(const YamlNode& node) {
  node.AllowOnly({"rate_Hz", "noise_deg", "strength_tolerance", "earth_horizontal_uT",
                  "earth_down_uT", "motor_field_uT_per_A"});
  Compass compass;
  compass.rate_Hz = Rate(node);
  compass.noise_rad = Degrees(node["noise_deg"], 180.0);
  compass.strength_tolerance = node["strength_tolerance"].Number(0.001, 1.0);
  compass.earth_horizontal_T = node["earth_horizontal_uT"].Number(1.0, 100.0) * kMicrotesla;
  compass.earth_down_T = node["earth_down_uT"].Number(-100.0, 100.0) * kMicrotesla;
  compass.motor_field_T_per_A = node["motor_field_uT_per_A"].Number(0.0, 1000.0) * kMicrotesla;
  return compass;
}

Battery ReadBattery(const YamlNode& node) {
  node.AllowOnly({"rate_Hz", "capacity_Ah", "resistance_ohm", "voltage_V", "cutoff_V",
                  "electronics_W", "laser_W", "lights_W", "motor_efficiency",
                  "motor_copper_W_per_Nm2", "motor_idle_W"});
  Battery battery;
  battery.rate_Hz = Rate(node);
  battery.capacity_As = 3600.0 * node["capacity_Ah"].Number(0.001, 1000.0);
  battery.resistance_ohm = node["resistance_ohm"].Number(0.0, 10.0);
  battery.voltage_V = ReadCurve(node["voltage_V"]);
  battery.cutoff_V = node["cutoff_V"].Number(0.0, battery.voltage_V.rbegin()->second);
  battery.electronics_W = node["electronics_W"].Number(0.0, 1e4);
  battery.laser_W = node["laser_W"].Number(0.0, 1e4);
  battery.lights_W = node["lights_W"].Number(0.0, 1e4);
  battery.motor_efficiency = node["motor_efficiency"].Number(0.01, 1.0);
  battery.motor_copper_W_per_Nm2 = node["motor_copper_W_per_Nm2"].Number(0.0, 1e4);
  battery.motor_idle_W = node["motor_idle_W"].Number(0.0, 1e3);
  return battery;
}

}  // namespace kantaro::robot
