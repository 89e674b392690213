#pragma once

#include <cstdint>

#include "robot/description.hpp"
#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// What the scanner makes of a wall all round it at one distance.
struct LaserErrors {
  std::size_t beams{};                          ///< measured
  std::size_t too_near{}, too_far{};            ///< of them
  double mean_m{}, deviation_m{}, largest_m{};  ///< error of the valid ones; largest: absolute
};
/// Scans so many revolutions at full speed on the axis of a round pipe.
[[nodiscard]] LaserErrors MeasureLaser(const robot::Laser& laser, double distance_m,
                                       std::size_t revolutions, std::uint64_t seed);

/// Thesis fig 5.2 and Table 5.1: the laser scanner's errors over its range, and its speeds.
[[nodiscard]] Experiment LaserAccuracyExperiment();

}  // namespace kantaro::scenarios
