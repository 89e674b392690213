#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// Thesis Table 4.1: distance of landmarks by a single camera.
[[nodiscard]] Experiment MonoLocalisationExperiment();
/// Thesis Table 5.4: by the stereo pair.
[[nodiscard]] Experiment StereoLocalisationExperiment();

}  // namespace kantaro::scenarios
