#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robot/description.hpp"
#include "scenarios/experiments/image_statistics.hpp"

namespace kantaro::scenarios {

/// A frame of the twin like those of an inspection: a pipe of random diameter (200 to 350 mm),
/// material, condition, joints, water, sediment and stones, seen from a random place near its axis
/// by the robot's front camera under its own lamps, at the photographs' size.
///
/// The materials' shares are those of the 34 photographs: 22 of concrete or the like, 8 of orange
/// plastic or clay, the rest grey.
[[nodiscard]] LabelledImage TwinFrame(const robot::Description& robot, std::uint64_t seed,
                                      std::size_t index);

}  // namespace kantaro::scenarios
