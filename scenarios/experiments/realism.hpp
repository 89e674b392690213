#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// The twin's pictures beside photographs from sewers, and its depth beside scans of pipes.
[[nodiscard]] Experiment RealismExperiment();

}  // namespace kantaro::scenarios
