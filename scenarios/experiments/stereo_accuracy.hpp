#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// `kantaro experiment stereo-accuracy`: thesis figs 5.10, 5.11, 5.20, 5.21 and the errors of Table
/// 5.2, on views of the twin whose depth is known. The thesis draws squares of 8 x 8 pixels near
/// the manhole by chance (section 5.3.2); so here: squares on the wall within 50 mm of the mouth's
/// plane.
[[nodiscard]] Experiment StereoAccuracyExperiment();

}  // namespace kantaro::scenarios
