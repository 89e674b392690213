#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/laser_passage.hpp"
#include "perception/parameters.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/experiments/landmark_drive.hpp"

namespace kantaro::scenarios {

/// One drive past one landmark, and how it was drawn.
struct LaserPass {
  PassedKind kind{};
  double diameter_m{};
  bool downstream{};
  double inlet_m{}, inlet_up_h{};
  LandmarkDriveConditions conditions;
};

/// What one method made of it.
struct LaserPassOutcome {
  std::vector<perception::PassedLandmark> passed;
  bool recognised{};  ///< that one landmark, its middle inside of it, and no other; of joints, none
  std::optional<double> error_m{};  ///< of its middle along the pipe, where it was recognised
};

/// Draws pass `index` of a set: "reproduction" is the thesis' 300 mm (fig 5.26), upright and with
/// the scanner on the axis; "stress" is 250 to 350 mm, the scanner up to 20 mm off the axis, the
/// robot up to 5° up the wall, started up to 4° askew, on wheels of any grip, inlets up to half an
/// hour off 3 and 9 o'clock. Kinds take turns.
[[nodiscard]] LaserPass DrawLaserPass(const std::string& set, std::size_t index,
                                      std::uint64_t seed);

/// Drives it once and asks each method. @param methods  parameters of each
[[nodiscard]] std::vector<LaserPassOutcome> DriveLaserPass(
    const robot::Description& description, const LaserPass& pass,
    const std::vector<perception::Parameters>& methods);

/// Table 5.3 and fig 5.26: landmarks that the laser passes at 15 cm/s, by kind.
[[nodiscard]] Experiment LaserLandmarksExperiment();

}  // namespace kantaro::scenarios
