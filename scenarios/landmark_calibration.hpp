#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "perception/landmark_parameters.hpp"
#include "robot/description.hpp"
#include "scenarios/experiments/landmark_views.hpp"

namespace kantaro::scenarios {

/// What `kantaro calibrate` is told.
struct CalibrationOptions {
  std::uint64_t seed{1};
  std::size_t views{120};  ///< of each set and camera
  unsigned jobs{1};        ///< threads; changes no result
  std::function<void(std::size_t done, std::size_t all)> progress{
      [](std::size_t, std::size_t) {}};  ///< called from one thread at a time
};

/// Learns from training views of the twin, where distances are known, what the landmark methods
/// need: the thesis' radius-distance table (4.3) and linear fits of edge counts (5.5) from
/// reproduction views, and how the errors of ours compare with what it states, from all.
/// @param parameters  its calibration is not used
[[nodiscard]] perception::LandmarkCalibration CalibrateLandmarks(
    const robot::Description& description, perception::LandmarkParameters parameters,
    const CalibrationOptions& options);

/// The thesis' part alone, for one camera or the pair, from training views of one set.
void CalibrateThesis(const robot::Description& description,
                     const perception::LandmarkParameters& parameters, ViewSet set,
                     ViewCameras cameras, const CalibrationOptions& options,
                     perception::LandmarkCalibration& calibration);

/// The same from the views of a recorded mission (ForEachRecordedView); what fewer than ten of them
/// show stays as it is.
/// @returns how many views there were of each class
/// @throws InputError for a bad recording, and for one without a view
[[nodiscard]] std::array<std::size_t, perception::kLandmarkClasses.size()>
CalibrateThesisFromRecording(const robot::Description& description,
                             const perception::LandmarkParameters& parameters,
                             const std::filesystem::path& recording,
                             perception::LandmarkCalibration& calibration);

/// A measurement in a training view: x (a radius, a count of edges) at a known distance.
struct Sample {
  double distance_m{}, x{};
};

/// Medians of stretches of 0.1 m; neighbours whose radii do not fall with distance are pooled.
/// @throws std::invalid_argument if fewer than two stretches are left.
[[nodiscard]] perception::RadiusTable FitRadiusTable(const std::vector<Sample>& samples);
/// Least squares of distance over the count. @throws std::invalid_argument for equal counts alone
[[nodiscard]] perception::EdgeFit FitEdges(const std::vector<Sample>& samples);

/// An answer in a training view.
struct StatedError {
  double distance_m{}, error_m{}, deviation_m{};
};
/// Median relative error, and the factor that puts 95 % of the errors left within 1.96 deviations.
[[nodiscard]] perception::ErrorFit FitErrors(const std::vector<StatedError>& errors);

}  // namespace kantaro::scenarios
