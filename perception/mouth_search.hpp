#pragma once

#include <vector>

#include "perception/ring_scan.hpp"
#include "perception/shaft_view.hpp"
#include "perception/tried_distance.hpp"

namespace kantaro::perception {

/// What one picture shows of a manhole ahead.
struct MouthSight {
  RingScan::Scanned rings;
  ShaftView::Sight shaft;
  double ahead_m{};  ///< added to a distance from the last left picture, the distance from this one
};

/// Where a manhole's mouth is, by all pictures together: before calibration.
/// @param ring_px_m  focal length times the pipe's radius
[[nodiscard]] RangedLandmark FindMouth(const ShaftView& shaft,
                                       const std::vector<MouthSight>& sights, double near_m,
                                       double far_m, double ring_px_m);

}  // namespace kantaro::perception
