#include "navigation/sensor_health.hpp"

#include <algorithm>
#include <utility>

namespace kantaro::navigation {

void SensorHealth::Hear(robot::Sensor sensor, robot::RunTime at) {
  if (!began_) began_ = at;
  State& state = Of(sensor);
  state.heard = std::max(at, state.heard.value_or(at));
  state.lost = false;
}

bool SensorHealth::Lose(robot::Sensor sensor, robot::RunTime at) {
  if (!began_) began_ = at;
  return !std::exchange(Of(sensor).lost, true);
}

bool SensorHealth::Silent(robot::Sensor sensor, robot::RunTime now, double patience_s) const {
  const State& state = Of(sensor);
  return state.lost ||
         robot::Seconds(now - state.heard.value_or(began_.value_or(now))) > patience_s;
}

bool SensorHealth::PowerLost() const {
  return Of(robot::Sensor::kBattery).lost && Of(robot::Sensor::kEncoders).lost;
}

}  // namespace kantaro::navigation
