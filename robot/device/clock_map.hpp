#pragma once

#include <algorithm>
#include <optional>

#include "robot/device/frame.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// From a processor's clock to the run's. Every frame arrives some time after it was sent; the one
/// that took least tells best how the clocks lie, and no frame is ever older than it can be.
class ClockMap {
 public:
  /// In lockstep the processor's clock is the run's, from this instant on.
  void Fix(wire::WireTime zero) {
    offset_ = -RunTime(zero);
    fixed_ = true;
  }
  void Observe(wire::WireTime sent, RunTime received) {
    if (fixed_) return;
    const RunTime latest = received - sent;
    if (offset_) {
      const auto drift = std::max(RunTime(0), received - observed_at_) / kDriftShare;
      offset_ = std::min(*offset_ + drift, latest);
    } else {
      offset_ = latest;
    }
    observed_at_ = received;
  }
  /// @pre something was observed, or the map is fixed.
  [[nodiscard]] RunTime operator()(wire::WireTime time) const { return time + offset_.value(); }
  [[nodiscard]] bool known() const { return offset_.has_value(); }

 private:
  /// Two crystals part by 200 µs a second at the very worst.
  static constexpr int kDriftShare = 5000;
  std::optional<RunTime> offset_;
  RunTime observed_at_{};
  bool fixed_{};
};

}  // namespace kantaro::robot
