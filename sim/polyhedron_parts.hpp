#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sim/polyhedron.hpp"

namespace kantaro::sim {

/// The plane through p whose normal points into the body.
[[nodiscard]] inline Plane PlaneThrough(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
  return {normal.normalized(), normal.normalized().dot(p), false};
}

/// Of a full circle, a multiple of 4: so a kU's lower half has the same corners.
[[nodiscard]] inline std::size_t SegmentsAround(double radius_m, double tolerance_m) {
  const double half = std::atan(std::sqrt(0.5 * tolerance_m / radius_m));
  return 4 * std::max<std::size_t>(
                 2, static_cast<std::size_t>(std::ceil(std::numbers::pi / (8.0 * half))));
}

/// Corners that stand this far off put a polygon half inside and half outside its circle.
[[nodiscard]] inline double CornerRadius(double radius_m, double step_rad) {
  return radius_m * 2.0 / (1.0 + std::cos(0.5 * step_rad));
}

/// Cells that keep a sweep of this radius within the tolerance.
[[nodiscard]] inline std::size_t CellsAlong(const SweptAxis& axis, double radius_m,
                                            double tolerance_m, double max_cell_m) {
  double step = max_cell_m;
  if (axis.curvature != 0.0) {
    const double outer = 1.0 / std::abs(axis.curvature) + radius_m;
    const double turn = 2.0 * std::acos(std::max(0.5, 1.0 - 0.5 * tolerance_m / outer));
    step = std::min(step, turn / std::abs(axis.curvature));
  }
  return static_cast<std::size_t>(std::max(1.0, std::ceil(axis.length_m / step - 1e-9)));
}

/// By the membrane.
inline void Grow(Slab& slab) {
  slab.box.min().array() -= kMembrane_m;
  slab.box.max().array() += kMembrane_m;
}

}  // namespace kantaro::sim
