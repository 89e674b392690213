#pragma once

#include <cmath>
#include <cstdint>

namespace kantaro::robot {

/// 2π, in words that C++17 knows too: the recorder is built with it.
inline constexpr double kFullTurn_rad = 6.28318530717958647692;

/// Angle of a count of the laser mirror's encoder [rad], 0 <= a < 2π for counts below
/// `counts_per_turn`. The one formula for it: the twin, a recording and the device all go through
/// here, so that one count is one angle to the bit.
[[nodiscard]] inline double MirrorAngle(std::uint32_t count, std::uint32_t counts_per_turn) {
  return kFullTurn_rad * static_cast<double>(count) / static_cast<double>(counts_per_turn);
}

/// The count whose angle is nearest; the inverse of MirrorAngle, from singles too.
[[nodiscard]] inline std::uint32_t MirrorCount(double angle_rad, std::uint32_t counts_per_turn) {
  const double turns = angle_rad / kFullTurn_rad;
  return static_cast<std::uint32_t>(
      std::llround((turns - std::floor(turns)) * static_cast<double>(counts_per_turn)) %
      counts_per_turn);
}

}  // namespace kantaro::robot
