#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>

#include "network/network.hpp"

namespace kantaro::sim {

/// What a surface offers to what stands on it, and to the light of an IR sensor.
struct Grip {
  double tyre_friction{};         ///< tyre rubber on it, Coulomb
  double hull_friction{};         ///< the robot's boxes on it
  double rolling_resistance_m{};  ///< of a wheel: lever arm of the wall's force
  double infrared_return{1.0};    ///< of what dry plastic sends back to an IR sensor
};

/// Surfaces that differ in their grip. The first four are network::Material in its order; stones,
/// bricks and mortar count as concrete.
enum class Ground : std::uint8_t { kPvc, kClay, kConcrete, kLined, kSediment };
inline constexpr std::size_t kGroundCount = 5;
inline constexpr std::size_t kConditionCount = 3;

[[nodiscard]] Ground GroundOf(network::Material material);

/// The grip of every ground in every condition (models/materials.yaml).
struct GripTable {
  std::array<std::array<Grip, kConditionCount>, kGroundCount> grips;

  [[nodiscard]] const Grip& At(Ground ground, network::WallCondition condition) const {
    return grips[static_cast<std::size_t>(ground)][static_cast<std::size_t>(condition)];
  }
};

/// Every entry must be there and name its source; in no ground may slime grip better than water, or
/// water better than a dry wall. @throws InputError
[[nodiscard]] GripTable ReadGripTable(const std::filesystem::path& file);
/// The same from text; `name` stands in complaints.
[[nodiscard]] GripTable ParseGripTable(const std::string& text, const std::filesystem::path& name);

}  // namespace kantaro::sim
