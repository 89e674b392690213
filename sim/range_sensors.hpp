#pragma once

#include <vector>

#include "base/random.hpp"
#include "robot/description.hpp"
#include "robot/readings.hpp"
#include "sim/ray_caster.hpp"

namespace kantaro::sim {

/// The mirror's scan, beam by beam as time goes on: the robot moves during a revolution
/// (thesis 5.2, Table 5.1).
class LaserScanner {
 public:
  LaserScanner(const robot::Laser& laser, const RayCaster& rays, RandomStream noise);

  /// Measures every beam due in (from, to] while the scanner moves from one pose to the other.
  /// @returns the revolutions completed in that time, each with the time of its last beam.
  struct Completed {
    double time_s{};
    robot::LaserRevolution revolution;
  };
  [[nodiscard]] std::vector<Completed> Scan(double from_s, double to_s,
                                            const Eigen::Isometry3d& X_WL_from,
                                            const Eigen::Isometry3d& X_WL_to);

 private:
  [[nodiscard]] robot::LaserSample Measure(const Eigen::Isometry3d& X_WL, double angle_rad);

  robot::Laser laser_;
  const RayCaster& rays_;
  RandomStream noise_;
  std::int64_t beams_{};  ///< measured so far
  std::int64_t beams_per_revolution_{};
  robot::LaserRevolution current_;
};

/// Reading of an IR sensor whose beam starts at a pose's origin along its x (thesis 4.3: the value
/// falls with distance).
[[nodiscard]] robot::IrReading MeasureInfrared(const robot::Infrared& sensor, const RayCaster& rays,
                                               const Eigen::Isometry3d& X_WS, RandomStream& noise);

}  // namespace kantaro::sim
