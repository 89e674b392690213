#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "network/network.hpp"

namespace kantaro::sim {

/// The patterns that surfaces carry. A pattern says how bright the surface is, how it leans and
/// where it is soiled; what colour it has when clean and how wet it is, its Look says.
enum class Pattern : std::uint8_t {
  kPipeWall,   ///< one period is one turn round the pipe from the crown, and two along it: the
               ///< invert's deposit is in it
  kRoughPipe,  ///< likewise, of concrete: grains and pits, stained to the springing line
  kConcrete,   ///< one period is 1 m
  kRough,      ///< lumps, dirt, roots; one period is 0.2 m
  kSlime,      ///< as kRoughPipe, under a dark biofilm up to the springing line
  kGravel      ///< sand and pebbles; one period is 0.2 m
};
inline constexpr int kPatternCount = 6;

/// 8-bit, 3 channels, periodic in both directions: albedo (0 … 1), slope along the column axis
/// (−1 … 1 about 128) and soil (0 clean, ½ stained brown, 1 sludge). Rows run round the wall,
/// columns along it. The robot's lamps shine along the pipe, so that slopes around it change
/// little.
/// @param contrast  of stains, scale and scratches, 1 as on a used sewer, 0 none.
[[nodiscard]] cv::Mat MakePattern(Pattern pattern, std::uint64_t seed, double contrast);

/// How a surface looks under the lamps.
struct Look {
  Pattern pattern{Pattern::kRough};
  Eigen::Vector3f colour{0.5f, 0.5f, 0.5f};  ///< of the clean surface, linear RGB
  float gloss{0.1f};                         ///< strength of highlights, 0 … 1
  float relief{1.0f};                        ///< how much of the pattern's slope shows, 0 … 1
  float film{0.0f};  ///< how sharply the lamps shine back from a film of water or slime, 0 dry
};

/// Walls of a pipe. Water darkens a wall, as light that it holds inside is absorbed there, and
/// makes it shine; slime tints and hides it.
[[nodiscard]] Look PipeWallLook(network::Material material, network::WallCondition condition);
/// What stands in a pipe whose walls are in this condition. Patterns repeat after 0.2 m.
[[nodiscard]] Look ObstacleLook(network::ObstacleKind kind, network::WallCondition condition);
/// What fills a joint's groove and lines its rim: mostly pale mortar and scale, or else dark dirt.
/// @param draw  uniform over 0 … 1: which, and how much of it
[[nodiscard]] Look JointLook(network::Material material, network::WallCondition condition,
                             double draw);
/// The end of a house connection that stands into a pipe: orange-brown plastic.
[[nodiscard]] Look StubLook(network::WallCondition condition);

}  // namespace kantaro::sim
