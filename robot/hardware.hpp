#pragma once

#include <optional>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// What became of a command.
enum class CommandOutcome {
  kHonoured,
  kLimited,  ///< a wheel speed was beyond the motors' limit and was cut to it
  kRefused   ///< the robot does not do it: it was stopped, the line is down, or this is a recording
             ///< of a robot that was told something else
};

/// The one boundary between the robot's code and its body: the twin, a recording or a device. What
/// follows is a contract; every back end passes tests/robot/hardware_contract.hpp.
///
/// Time. Hardware owns the clock: nothing above it reads one or sleeps. An instance is one run,
/// which begins at zero when it is made. One caller at a time.
///
/// Readings. They come in the order of arrival, none before its capture. All numbers in them are
/// finite and within the ranges that readings.hpp states. An image belongs to its receiver: its
/// pixels are never written again.
///
/// Loss. A reading that was due and did not come is told as a Loss of its sensor, among the
/// readings and in their order. A sensor that falls silent is told, too: nobody above needs a clock
/// to notice. Readings that the sensor itself got wrong are handed over as they are.
///
/// Commands. Each holds until the next. Apply() says what became of it at once; the last one that
/// was not refused is in force. Before the first the wheels stand still.
///
/// Stop. Always obeyed, and final; to destroy the instance does the same.
class Hardware {
 public:
  Hardware() = default;
  Hardware(const Hardware&) = delete;
  Hardware& operator=(const Hardware&) = delete;
  virtual ~Hardware() = default;

  /// Lets time pass until the next reading arrives and returns it. Absent when the run is over (out
  /// of time, nothing connected any more, the recording has ended), and absent ever after.
  [[nodiscard]] virtual std::optional<Reading> Read() = 0;

  /// Takes effect at Now(). Refused after Stop().
  /// @throws std::invalid_argument for a speed that is not finite, or lights outside 0 … 1; the
  /// command before stays in force.
  virtual CommandOutcome Apply(const Command& command) = 0;

  /// The wheels are told to stand still, whatever state the hardware is in, and no later command
  /// moves them: the run is over but for what the sensors still say. May be called at any time and
  /// again. A robot whose line is down stops by its own watchdog.
  virtual void Stop() = 0;

  /// Arrival time of the last reading handed over; zero before the first.
  [[nodiscard]] virtual RunTime Now() const = 0;
};

}  // namespace kantaro::robot
