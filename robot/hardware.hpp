#pragma once

#include <optional>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// What became of a command.
enum class CommandOutcome {
  kHonoured,
  kLimited,  ///< a wheel speed was beyond the motors' limit and was cut to it
  kRefused   ///< the robot does not do it: the line is down, or this is a recording of a robot that
             ///< was told something else
};

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

  /// Takes effect at Now(). @throws std::invalid_argument for NaN, or lights outside 0 … 1.
  virtual CommandOutcome Apply(const Command& command) = 0;

  /// The wheels are told to stand still, whatever state the hardware is in, and no later command
  /// moves them: the run is over but for what the sensors still say. A robot whose line is down
  /// stops by its own watchdog.
  virtual void Stop() = 0;

  /// Time of the last reading handed over; zero before the first.
  [[nodiscard]] virtual RunTime Now() const = 0;
};

}  // namespace kantaro::robot
