#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/random.hpp"
#include "robot/description.hpp"
#include "robot/readings.hpp"
#include "sim/ground.hpp"
#include "sim/ray_caster.hpp"

namespace kantaro::sim {

/// The mirror's scan, beam by beam as time goes on: the robot moves during a revolution
/// (thesis 5.2, Table 5.1). Beams come at a fixed rate, so a slower mirror has more to a turn. A
/// beam is a disc of light, and the range the mean over the part of it that returns: at an edge,
/// something between near and far (a mixed pixel); less than half of it is too faint to be
/// measured. The range is a single, and the angle the count that the mirror's encoder has reached.
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
  /// Of the mirror before this beam, since the beginning.
  [[nodiscard]] double Turns(std::int64_t beam) const;
  /// @param turn  where the mirror stands, 0 to 1
  [[nodiscard]] robot::LaserSample Measure(const Eigen::Isometry3d& X_WL, double turn);
  /// Mean range over the beam's disc; absent where too little of it returns.
  [[nodiscard]] std::optional<double> Footprint(const Eigen::Isometry3d& X_WL,
                                                double angle_rad) const;
  template <typename Range>
  [[nodiscard]] std::optional<double> EdgeFootprint(const Range& range) const;

  robot::Laser laser_;
  const RayCaster& rays_;
  RandomStream noise_;
  std::int64_t beams_{};  ///< measured so far
  robot::LaserRevolution current_;
};

/// Reading of an IR sensor whose beam, a cone, starts at a pose's origin along its x (thesis 4.3:
/// the value falls with distance).
/// @param ground  what the walls send back; empty: dry plastic everywhere.
[[nodiscard]] robot::IrReading MeasureInfrared(const robot::Infrared& sensor, const RayCaster& rays,
                                               const GroundAt& ground,
                                               const Eigen::Isometry3d& X_WS, RandomStream& noise);

}  // namespace kantaro::sim
