#pragma once

#include <deque>

#include "robot/readings.hpp"

namespace kantaro::navigation {

/// The gyro's bias about one axis, learned where the robot cannot turn for long: along a pipe. It
/// is the median over the last seconds, so a short bend of the pipe counts for nothing.
class RateBias {
 public:
  /// The rate while the robot drives along a pipe, in order.
  void Learn(robot::RunTime at, double rate_rad_s);
  /// Zero until there was enough to learn from.
  [[nodiscard]] double rad_s() const { return bias_rad_s_; }

 private:
  static constexpr double kMean_s = 0.1;  ///< rates are averaged over so much
  static constexpr std::size_t kLeast = 20, kMost = 80;

  robot::RunTime began_{};
  double sum_rad_s_{};
  int count_{};
  std::deque<double> means_rad_s_;
  double bias_rad_s_{};
};

}  // namespace kantaro::navigation
