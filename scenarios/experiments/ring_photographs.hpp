#pragma once

#include <opencv2/core/types.hpp>

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// Whether a circle is the labelled ring: the box about it, as far as it lies in the picture,
/// shares half with the label's (intersection over union).
[[nodiscard]] bool IsLabelled(cv::Point2d center, double radius_px, const cv::Rect2d& label,
                              cv::Size picture);

/// The ring and landmark finders on photographs of real sewers, whose joints are labelled.
[[nodiscard]] Experiment RingPhotographsExperiment();

}  // namespace kantaro::scenarios
