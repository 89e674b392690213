#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "scenarios/result.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// What the robot's cameras see while it stands at a place of a scenario's world, in the conditions
/// of a seed, with the ground truth beside it. For each camera NAME `NAME.png` as it comes and
/// `NAME_rectified.png`, and of the rectified picture `NAME_depth.png` (16-bit, millimetres along
/// the optical axis, 0 where nothing is in reach) and `NAME_identity.png` (16-bit, what each pixel
/// shows), each also in colours. `truth.json` says where base, cameras and rectified pinholes
/// truly are, what the robot knows of each camera, and what the numbers of the identities mean. The
/// robot faces the way in which the scenario's route drives the pipe; downstream off the route.
/// @throws InputError (file "--pipe" or "--chainage") for a place that does not exist or that the
/// robot cannot enter.
[[nodiscard]] FolderFiles RenderView(const Scenario& scenario, const std::string& pipe,
                                     double chainage_m, std::uint64_t seed);

}  // namespace kantaro::scenarios
