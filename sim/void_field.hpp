#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// The primitives that can matter around a place.
class Nearby {
 public:
  [[nodiscard]] std::span<const VoidPrimitive* const> voids() const {
    return {voids_.data(), count_};
  }

 private:
  friend class VoidField;
  static constexpr std::size_t kMost = 24;
  std::array<const VoidPrimitive*, kMost> voids_{};
  std::size_t count_{};
};

/// Distance to the wall of a union of voids, with its normal: what contact is made from.
///
/// The wall is the intersection, over the voids, of each void's outside, and a void's outside is
/// the union of the half-spaces behind its walls. The nearest point of the solid is therefore
/// sought over all choices of one wall from each void; where two chosen walls meet in an edge, the
/// distance is that to the edge of their wedge. Walls are taken as flat: exact on the wall and at
/// its edges, second order in (distance / radius of curvature) away from it.
class VoidField {
 public:
  explicit VoidField(std::vector<VoidPrimitive> voids);

  [[nodiscard]] const std::vector<VoidPrimitive>& voids() const { return voids_; }

  /// All primitives within `reach_m` (at most kLargestReach_m) of a point. @throws
  /// std::length_error beyond 24.
  [[nodiscard]] Nearby Around(const Eigen::Vector3d& p_W, double reach_m) const;
  static constexpr double kLargestReach_m = 0.25;

  /// Signed distance to the nearest wall, no more than `cap_m`, and its normal there (into the
  /// void). Negative in the solid, where it is the depth below the nearest wall as far as `nearby`
  /// reaches.
  [[nodiscard]] static Wall NearestWall(const Nearby& nearby, const Eigen::Vector3d& p_W,
                                        double cap_m);

 private:
  [[nodiscard]] std::uint64_t Cell(const Eigen::Vector3d& p_W) const;

  std::vector<VoidPrimitive> voids_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  /// Voids by grid cell, as runs of `members_`; boxes are grown by the largest reach before they
  /// are entered.
  std::unordered_map<std::uint64_t, std::pair<std::uint32_t, std::uint32_t>> cells_;
  std::vector<std::uint32_t> members_;
};

}  // namespace kantaro::sim
