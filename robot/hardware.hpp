#pragma once

#include <optional>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// The one boundary between the robot's code and its body. Owns the clock: nothing above it reads
/// one or sleeps. One caller at a time; an instance is one run.
class Hardware {
 public:
  Hardware() = default;
  Hardware(const Hardware&) = delete;
  Hardware& operator=(const Hardware&) = delete;
  virtual ~Hardware() = default;

  /// Lets time pass until the next reading arrives and returns it. Arrival times never decrease,
  /// and no reading arrives before its capture. Absent when the run is over (out of time, or the
  /// recording has ended).
  [[nodiscard]] virtual std::optional<Reading> Read() = 0;

  /// Takes effect at Now(). @throws std::invalid_argument for NaN, or lights outside 0 … 1. Wheel
  /// speeds above the motors' limit are clamped.
  virtual void Apply(const Command& command) = 0;

  /// Time of the last reading handed over; zero before the first.
  [[nodiscard]] virtual RunTime Now() const = 0;
};

}  // namespace kantaro::robot
