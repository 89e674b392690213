#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// Figs 4.7 and 4.8: what the upward sensor (IR-1) says along a manhole and a side sensor (IR-3)
/// along a junction, and what perception makes of it.
[[nodiscard]] Experiment IrLandmarksExperiment();

}  // namespace kantaro::scenarios
