#include "navigation/parameters.hpp"

#include <numbers>

#include "base/files.hpp"
#include "base/yaml.hpp"

namespace kantaro::navigation {

RobotGeometry RobotGeometry::Of(const robot::Description& description) {
  const auto x = [&](const std::string& link) {
    return description.PoseInBase(link).translation().x();
  };
  RobotGeometry geometry;
  geometry.laser_x_m = x(description.laser.link);
  geometry.infrared_x_m = x(description.ir_up.link);
  geometry.camera_x_m = x(description.front_camera.link);
  for (const robot::Joint& joint : description.joints) {
    if (joint.name == description.wheels.front()) geometry.front_axle_x_m = x(joint.child);
  }
  geometry.tyre_radius_m = description.tyres.at(description.wheels.front()).radius_m;
  return geometry;
}

Parameters ReadParameters(const std::filesystem::path& file) {
  return ParseParameters(ReadInputFile(file), file);
}

Parameters ParseParameters(const std::string& text, const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"speeds", "approach_distance_m", "gate_deviations", "turn", "steering", "errors",
                  "silence_s", "health"});
  const YamlNode speeds = root["speeds"];
  speeds.AllowOnly({"cruise_m_s", "approach_m_s", "reverse_m_s", "turn_m_s"});
  const YamlNode turn = root["turn"];
  turn.AllowOnly({"ratio", "lead_m", "tolerance_deg", "easing_deg"});
  const YamlNode steering = root["steering"];
  steering.AllowOnly({"upright_gain", "upright_damping_s", "heading_gain"});
  const YamlNode errors = root["errors"];
  errors.AllowOnly({"map", "travel", "scale", "start_m", "wall_m", "inlet_m", "ring_m"});

  constexpr double kSpeedLimit_m_s = 0.15;  // thesis 5.6
  constexpr double kSlowest_m_s = 0.01;
  Parameters p;
  p.cruise_m_s = speeds["cruise_m_s"].Number(kSlowest_m_s, kSpeedLimit_m_s);
  p.approach_m_s = speeds["approach_m_s"].Number(kSlowest_m_s, kSpeedLimit_m_s);
  p.reverse_m_s = speeds["reverse_m_s"].Number(kSlowest_m_s, kSpeedLimit_m_s);
  p.turn_m_s = speeds["turn_m_s"].Number(kSlowest_m_s, kSpeedLimit_m_s);
  p.approach_distance_m = root["approach_distance_m"].Number(0.0, 5.0);
  p.gate_deviations = root["gate_deviations"].Number(1.0, 10.0);
  p.turn_ratio = turn["ratio"].Number(0.0, 1.0);
  p.turn_lead_m = turn["lead_m"].Number(-0.2, 0.2);
  p.turn_tolerance_rad = turn["tolerance_deg"].Number(0.0, 45.0) * std::numbers::pi / 180.0;
  p.turn_easing_rad = turn["easing_deg"].Number(1.0, 90.0) * std::numbers::pi / 180.0;
  p.upright_gain = steering["upright_gain"].Number(0.0, 20.0);
  p.upright_damping_s = steering["upright_damping_s"].Number(0.0, 20.0);
  p.heading_gain = steering["heading_gain"].Number(0.0, 20.0);
  p.map_error = errors["map"].Number(0.001, 0.5);
  p.travel_error = errors["travel"].Number(0.0001, 0.5);
  p.scale_error = errors["scale"].Number(0.001, 0.5);
  p.start_error_m = errors["start_m"].Number(0.001, 5.0);
  p.wall_error_m = errors["wall_m"].Number(0.001, 1.0);
  p.inlet_error_m = errors["inlet_m"].Number(0.001, 1.0);
  p.ring_error_m = errors["ring_m"].Number(0.001, 1.0);
  p.silence_s = root["silence_s"].Number(0.1, 60.0);
  const YamlNode health = root["health"];
  health.AllowOnly({"wheel_silence_s", "gyro_silence_s", "stale_s", "wheel_window_s",
                    "least_wheel_share", "gyro_bias_deg_s", "longest_inlet_m", "longest_opening_m",
                    "reverse_slip", "spinning_m", "battery_reserve"});
  p.wheel_silence_s = health["wheel_silence_s"].Number(0.05, 10.0);
  p.gyro_silence_s = health["gyro_silence_s"].Number(0.05, 10.0);
  p.stale_s = health["stale_s"].Number(0.05, kTravelMemory_s);
  p.wheel_window_s = health["wheel_window_s"].Number(0.5, 60.0);
  p.least_wheel_share = health["least_wheel_share"].Number(0.0, 0.9);
  p.gyro_bias_rad_s = health["gyro_bias_deg_s"].Number(0.0, 90.0) * std::numbers::pi / 180.0;
  p.longest_inlet_m = health["longest_inlet_m"].Number(0.0, 1.0);
  p.longest_opening_m = health["longest_opening_m"].Number(0.5, 100.0);
  p.reverse_slip = health["reverse_slip"].Number(0.0, 1.0);
  p.spinning_m = health["spinning_m"].Number(0.0, 5.0);
  p.battery_reserve = health["battery_reserve"].Number(0.0, 1.0);
  return p;
}

}  // namespace kantaro::navigation
