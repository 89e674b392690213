#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "network/network.hpp"

namespace kantaro::network {

/// The words for an enumeration in files and reports, in the order of its values.
template <typename Enum>
inline constexpr std::array<std::string_view, 0> kWords{};
template <>
inline constexpr std::array<std::string_view, 4> kWords<Material>{"pvc", "clay", "concrete",
                                                                  "lined"};
template <>
inline constexpr std::array<std::string_view, 3> kWords<WallCondition>{"dry", "wet", "slimy"};
/// A given height has no word: it is a number.
template <>
inline constexpr std::array<std::string_view, 3> kWords<BenchHeight>{"flat", "axis", "crown"};
template <>
inline constexpr std::array<std::string_view, 3> kWords<Alignment>{"invert", "axis", "crown"};
template <>
inline constexpr std::array<std::string_view, 4> kWords<ObstacleKind>{"sediment", "stone",
                                                                      "mortar_ridge", "brick"};
template <>
inline constexpr std::array<std::string_view, 9> kWords<FaultCategory>{"crack",
                                                                       "water_infiltration",
                                                                       "root_invasion",
                                                                       "pipe_break",
                                                                       "joint_and_gap",
                                                                       "mounting_pipe_projection",
                                                                       "adhesion_of_mortar",
                                                                       "foreign_substance",
                                                                       "adhesion_of_grease"};
template <>
inline constexpr std::array<std::string_view, 3> kWords<FaultRank>{"A", "B", "C"};

/// "pvc", "crown", "root_invasion", "A" ...
template <typename Enum>
[[nodiscard]] constexpr std::string_view WordFor(Enum value) {
  return kWords<Enum>.at(static_cast<std::size_t>(value));
}

/// The value a word stands for, absent if it stands for none.
template <typename Enum>
[[nodiscard]] constexpr std::optional<Enum> FromWord(std::string_view word) {
  for (std::size_t i = 0; i < kWords<Enum>.size(); ++i) {
    if (kWords<Enum>[i] == word) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

}  // namespace kantaro::network
