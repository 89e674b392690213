#pragma once

#include <Eigen/Core>
#include <optional>

#include "robot/readings.hpp"

namespace kantaro::perception {

/// The round wall that one laser revolution lies on: a circle in the scanner's plane, seen from the
/// scanner. Angles as in robot::LaserSample: 0 to the right, π/2 up.
struct PipeSlice {
  double right_m{};  ///< the circle's middle from the mirror, to the robot's right
  double up_m{};     ///< and upwards
  double radius_m{};
  double wall_share{};  ///< of the beams that can reach it, those that lie on it: 0 to 1
  /// Of (right_m, up_m).
  Eigen::Matrix2d covariance_m2{Eigen::Matrix2d::Zero()};

  /// What a beam in this direction travels to the circle.
  [[nodiscard]] double RangeAt(double angle_rad) const;
  /// How sure that is: a standard deviation [m].
  [[nodiscard]] double DeviationAt(double angle_rad) const;
};

/// Fits the circle to what is wall and leaves out what is not: an opening, a ridge, a shaft's
/// floor. The lower half is believed first, for whatever opens above it, a pipe has an invert and a
/// manhole its channel (thesis 5.2); then all that lies within kWallBand_m of the circle so far.
/// Least squares by Kåsa (1976), whose bias on arcs of half a turn is far below the scanner's 1 mm.
/// Independent of the samples' order.
/// @param far_limit_m  the scanner's: what lies beyond is out of reach
/// @returns nothing where less than a quarter of the beams agree, or on a circle of no pipe:
///          the scanner is not inside one.
[[nodiscard]] std::optional<PipeSlice> FitPipeSlice(const robot::LaserRevolution& revolution,
                                                    double far_limit_m = 0.190);

/// The wall from one revolution to the next. In a landmark a channel's flank or a branch's floor
/// bends a fit away, little by little. So a fit is taken over only where four fifths of the wall in
/// reach lie on it, and it agrees with the last one or such fits have agreed with each other for a
/// while: the pipe has become another. Elsewhere the circle keeps its size, and a Kalman filter of
/// its middle, a random walk as the robot sways, follows what is left of the wall below the axis:
/// where that is one side only, it knows that it loses the other.
class PipeSliceTracker {
 public:
  /// @param settled  revolutions in a row that make another pipe
  explicit PipeSliceTracker(int settled) : settled_(settled) {}

  /// @returns the circle to hold this revolution against; nothing before the first pipe.
  [[nodiscard]] const std::optional<PipeSlice>& Update(const robot::LaserRevolution& revolution,
                                                       double far_limit_m = 0.190);

 private:
  void Follow(const robot::LaserRevolution& revolution);

  int settled_;
  std::optional<PipeSlice> held_, other_;
  int seen_{};  ///< revolutions in a row that agree with `other_`
};

/// A joint's groove, an offset or a bead of deposit is wall still; scanner noise is far less.
inline constexpr double kWallBand_m = 0.012;

}  // namespace kantaro::perception
