#pragma once

#include <vector>

#include "perception/ring_scan.hpp"
#include "perception/tried_distance.hpp"
#include "perception/wall_pose.hpp"

namespace kantaro::perception {

/// What one picture shows of a joint ahead.
struct JointSight {
  RingScan::Scanned rings;
  double ahead_m{};  ///< added to a distance from the last left picture, the distance from this one
};

/// Where the nearest joint is, by all pictures together: before calibration.
///
/// The pictures' contrasts are averaged where they show the same wall, so that a line that no
/// single picture shows can still be told from noise. How likely a joint is at a distance follows
/// from how much more likely its contrasts all round are for a line than for mere texture, and a
/// plain ring farther off says nothing against a faint one: it may be a manhole's mouth behind the
/// joint.
/// @param sights  at least one; the last is the one that distances count from
/// @param doubt   of the pose by which the pictures were unrolled: so far aside a ring may be, up
/// to
///                8 px
[[nodiscard]] RangedLandmark FindJoint(const std::vector<JointSight>& sights,
                                       const PoseDoubt& doubt, double near_m, double far_m);

}  // namespace kantaro::perception
