#pragma once

#include <array>
#include <optional>

#include "robot/readings.hpp"

namespace kantaro::navigation {

/// Which sensors speak. A sensor is silent if it was reported lost and has not spoken since, or has
/// said nothing for longer than the caller would wait. Counts from the first word of any sensor.
class SensorHealth {
 public:
  /// It said something that was measured then.
  void Hear(robot::Sensor sensor, robot::RunTime at);
  /// It is lost, until it speaks again. @returns whether that is news.
  bool Lose(robot::Sensor sensor, robot::RunTime at);

  [[nodiscard]] bool Silent(robot::Sensor sensor, robot::RunTime now, double patience_s) const;
  /// The battery is lost, and with it the encoders.
  [[nodiscard]] bool PowerLost() const;

 private:
  struct State {
    std::optional<robot::RunTime> heard;
    bool lost{};
  };
  [[nodiscard]] const State& Of(robot::Sensor sensor) const {
    return sensors_[static_cast<std::size_t>(sensor)];
  }
  State& Of(robot::Sensor sensor) { return sensors_[static_cast<std::size_t>(sensor)]; }

  std::array<State, robot::kSensorCount> sensors_;
  std::optional<robot::RunTime> began_;
};

}  // namespace kantaro::navigation
