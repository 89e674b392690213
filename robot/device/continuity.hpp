#pragma once

#include <cstdint>
#include <optional>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// Watches that one sensor's readings keep coming, and tells of those that do not, each once.
class Continuity {
 public:
  /// @param period    between two readings, > 0.
  /// @param patience  silence that is no loss yet.
  Continuity(Sensor sensor, RunTime period, RunTime patience, RunTime began)
      : sensor_(sensor), period_(period), patience_(patience), last_(began) {}

  /// A reading came, and `lost_before` between it and the one before did not, by their numbers.
  [[nodiscard]] std::optional<Reading> Came(RunTime captured_at, std::uint32_t lost_before,
                                            RunTime now);
  /// Nothing more is to be waited for: the readings that are due by now, if too long overdue.
  [[nodiscard]] std::optional<Reading> Wait(RunTime now);
  /// The line is down: all that is due, and no more after it.
  [[nodiscard]] Reading GoDown(RunTime now);
  [[nodiscard]] bool down() const { return down_; }

 private:
  [[nodiscard]] std::uint32_t Due(RunTime now) const;
  [[nodiscard]] Reading Report(std::uint32_t more, RunTime now);

  Sensor sensor_;
  RunTime period_, patience_;
  RunTime last_;              ///< capture of the last reading
  std::uint32_t reported_{};  ///< lost since then and told
  std::optional<RunTime> told_at_;
  bool down_{};
};

}  // namespace kantaro::robot
