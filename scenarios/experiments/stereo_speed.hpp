#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// `kantaro experiment stereo-speed`: thesis figs 5.12 and 5.22 and the times of Table 5.2.
/// Processor time of one thread on 640 x 480 views of the twin, 64 disparities, smoothing included;
/// every method runs on every view, by turns, and so do OpenCV's StereoBM and StereoSGBM. The one
/// experiment whose result is not the same twice.
[[nodiscard]] Experiment StereoSpeedExperiment();

}  // namespace kantaro::scenarios
