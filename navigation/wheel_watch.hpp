#pragma once

#include <deque>
#include <optional>
#include <string>

#include "robot/readings.hpp"

namespace kantaro::navigation {

/// Holds what the encoders say against what the wheels were told. Encoders that stand still, run
/// the other way or jump would let the robot drive on without knowing where.
class WheelWatch {
 public:
  /// @param window_s  over which both are compared. @param least_share  of the way told that the
  /// wheels must at least have turned.
  WheelWatch(double window_s, double least_share)
      : window_s_(window_s), least_share_(least_share) {}

  /// The mean speed of the wheels from now on [m/s].
  void Tell(double speed_m_s) { told_m_s_ = speed_m_s; }
  /// The encoders' travel at a time, in order. @returns what is wrong, if anything is.
  [[nodiscard]] std::optional<std::string> Feel(robot::RunTime at, double travel_m);

 private:
  struct Entry {
    robot::RunTime at{};
    double told_m{};
    double felt_m{};
  };

  double window_s_, least_share_;
  double told_m_s_{};
  std::deque<Entry> entries_;
};

}  // namespace kantaro::navigation
