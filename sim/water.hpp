#pragma once

#include <vector>

#include "sim/sewer.hpp"

namespace kantaro::sim {

/// Water that stands along the inverts of a sewer: level across, and as deep everywhere in a pipe,
/// whatever its slope. The channels of a manhole hold the deepest water of the pipes that end in
/// it.
class Water {
 public:
  /// The sewer must outlive it.
  explicit Water(const Sewer& sewer);

  /// Depth along the invert of a part of the sewer [m], 0 if it is dry.
  [[nodiscard]] double DepthIn(std::uint32_t part) const { return depth_m_[part]; }
  /// How far the surface lies above a point in this void or on its wall [m], 0 where none does.
  [[nodiscard]] double Over(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W) const;
  /// Height of the surface above the void's axis [m], below 0 if it lies under it. For pipes and
  /// channels.
  [[nodiscard]] double AboveAxis(const VoidPrimitive& primitive) const;

 private:
  const Sewer& sewer_;
  std::vector<double> depth_m_;  ///< by part
};

/// A wheel as water meets it: an upright disc, `width_m` thick.
struct WadingWheel {
  double radius_m{};
  double width_m{};
};

/// Force that resists a wheel moving through water at rest [N], 1/2 rho c A v^2 with c = 1: the
/// part of the wheel's outline that is under water, seen from ahead, as if it did not turn. The
/// rolling tread is slower the lower it is, so this is what the water can do at most.
/// @param depth_m  of the water over the place where the wheel stands.
[[nodiscard]] double WadingDrag_N(const WadingWheel& wheel, double depth_m, double speed_m_s);

/// Weight of the water that the wheel displaces [N].
[[nodiscard]] double WadingLift_N(const WadingWheel& wheel, double depth_m);

}  // namespace kantaro::sim
