#pragma once

#include "scenarios/experiments/experiment.hpp"

namespace kantaro::scenarios {

/// `kantaro experiment stereo-pairs`: the matchers on photographs of the Middlebury benchmark
/// (Scharstein and Szeliski 2003, 2006), which may not ship. They are looked for under
/// $KANTARO_DATA/stereo, else in shared/data/stereo beside the checkout; without them there are no
/// rows and a sentence in "skipped".
[[nodiscard]] Experiment StereoPairsExperiment();

}  // namespace kantaro::scenarios
