#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sim/solid_primitive.hpp"
#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// What can matter around a place: at most a few dozen in any real sewer, and then nothing is
/// allocated.
class Nearby {
 public:
  [[nodiscard]] std::span<const VoidPrimitive* const> voids() const {
    return {voids_.data(), voids_.size()};
  }
  [[nodiscard]] std::span<const SolidPrimitive* const> solids() const {
    return {solids_.data(), solids_.size()};
  }

 private:
  friend class VoidField;
  boost::container::small_vector<const VoidPrimitive*, 24> voids_;
  boost::container::small_vector<const SolidPrimitive*, 8> solids_;
};

/// Distance to the wall of a sewer, with its normal: what contact is made from.
///
/// Free is what lies in some void and in no solid. The ground is the intersection of the voids'
/// outsides, and each void's outside is the union of the spaces behind its walls. The nearest point
/// of the ground is sought from wall to wall: the nearest point of one wall, if another void takes
/// it away, gives way to the nearest point of that wall's edge with one of the other void's walls,
/// and so on. The nearest of ground and solids counts.
///
/// Exact on every wall, solid and edge, and at any distance from a single wall; away from an edge
/// between curved walls it is so to second order in (distance / radius of curvature).
class VoidField {
 public:
  explicit VoidField(std::vector<VoidPrimitive> voids, std::vector<SolidPrimitive> solids = {});

  [[nodiscard]] const std::vector<VoidPrimitive>& voids() const { return voids_; }
  [[nodiscard]] const std::vector<SolidPrimitive>& solids() const { return solids_; }

  /// All primitives within `reach_m` (at most kLargestReach_m) of a point.
  [[nodiscard]] Nearby Around(const Eigen::Vector3d& p_W, double reach_m) const;
  static constexpr double kLargestReach_m = 0.25;

  /// Signed distance to the nearest wall, no more than `cap_m`, and its normal there (into the
  /// void). Negative in the ground and in solids, where it is the depth below the nearest wall as
  /// far as `nearby` reaches, and at most kLargestReach_m.
  [[nodiscard]] static Wall NearestWall(const Nearby& nearby, const Eigen::Vector3d& p_W,
                                        double cap_m);

 private:
  /// Runs of `members_`: voids by index, then solids by index.
  struct Cell {
    std::uint32_t first_void{}, first_solid{}, end{};
  };
  void Index();

  std::vector<VoidPrimitive> voids_;
  std::vector<SolidPrimitive> solids_;
  std::vector<Eigen::AlignedBox3d> void_boxes_, solid_boxes_;
  /// By grid cell: everything within the largest reach of it.
  std::unordered_map<std::uint64_t, Cell> cells_;
  std::vector<std::uint32_t> members_;
};

}  // namespace kantaro::sim
