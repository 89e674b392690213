#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "navigation/map.hpp"
#include "scenarios/experiments/landmark_views.hpp"

namespace kantaro::scenarios {

/// A landmark and how far it is ahead of a camera.
struct LandmarkAhead {
  perception::LandmarkKind kind{};
  double distance_m{};
  perception::KnownSizes sizes;
};

/// The nearest landmark of each kind, if it is as far ahead as views of landmarks are: rings 0.3 to
/// 1.5 m, inlets 0.3 to 0.8 m.
/// @param leg       as the map has it
/// @param pipe      that the leg drives along, for the inlets' diameters
/// @param length_m  of the leg, wall to wall, as believed
/// @param at_m      where the camera is, from the wall where the leg begins
[[nodiscard]] std::vector<LandmarkAhead> LandmarksAhead(const navigation::MapLeg& leg,
                                                        const network::Pipe& pipe, double length_m,
                                                        double at_m);

/// Views of landmarks in a recording of a mission, one for each landmark each 10 cm of travel, by
/// where the robot believed to be when the picture was taken; none while it was off by more than
/// 3 cm (standard deviation) by its own account.
/// @throws InputError for a bad recording
void ForEachRecordedView(const std::filesystem::path& recording, ViewCameras cameras,
                         const std::function<void(LandmarkView&&)>& use);

}  // namespace kantaro::scenarios
