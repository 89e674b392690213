#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "network/network.hpp"

namespace kantaro::network {

/// What a made-up network looks like from above.
enum class Layout {
  kGrid,  ///< streets at right angles, every one with a pipe: curves, tees and crosses, with loops
  kTree,  ///< one trunk with branches at 90° (tees) and 45° (wyes), wider downstream
  kCity   ///< street blocks with a forest of collectors in them, diameters mixed as in Table 2.3
};

/// "grid", "tree" or "city".
[[nodiscard]] std::optional<Layout> LayoutNamed(const std::string& word);

/// Mean distance of manholes [m]: the thesis' city has about 90,000 pipes on 3,220 km. Well below
/// the most that rules allow up to 600 mm (Japan's sewerage design guideline 75 m; Ten States
/// Standards 120 m to 375 mm).
inline constexpr double kManholeSpacing_m = 35.8;
inline constexpr double kShortestManholeSpacing_m = 6.0, kLongestManholeSpacing_m = 1000.0;
inline constexpr std::size_t kMostGeneratedPipes = 1'000'000;

/// The most that is made at a spacing of manholes [m, m].
[[nodiscard]] double LongestGenerated(double spacing_m);

struct GeneratorOptions {
  Layout layout{Layout::kCity};
  std::optional<std::size_t> pipes;     ///< how many; exactly one of this and `length_m` is given
  std::optional<double> length_m;       ///< of all pipes between their shafts, reached within 1 %
  double spacing_m{kManholeSpacing_m};  ///< of manholes, mean; single ones vary by 30 %
  std::uint64_t seed{1};
};

/// Length by nominal diameter [m, m] of the pipes below 800 mm of Kitakyushu (thesis Table 2.3,
/// 2000). The 18,692 m of unknown diameter ("0") are left out: they are taken to be mixed like the
/// rest.
[[nodiscard]] const std::vector<std::pair<double, double>>& KitakyushuMix();

/// The least grade at which a full pipe cleans itself: 0.6 m/s by Manning's formula with n = 0.013.
[[nodiscard]] double SelfCleaningGrade(double diameter_m);

/// A sound network of its own: everything falls towards the one outfall "M1" (its pipes lead there
/// from every manhole), crowns meet where sizes differ, and no pipe crosses another anywhere but in
/// a manhole. Same options, same network. Passes CheckNetwork.
/// @throws std::invalid_argument for options out of range.
[[nodiscard]] Network Generate(const GeneratorOptions& options);

}  // namespace kantaro::network
