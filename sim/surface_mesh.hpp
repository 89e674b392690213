#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// Triangles of the wall, seen from the void: counter-clockwise, normals pointing into the void.
struct SurfaceMesh {
  std::vector<Eigen::Vector3f> positions;        ///< p_WV [m]
  std::vector<Eigen::Vector3f> normals;          ///< unit, into the void
  std::vector<Eigen::Vector2f> surface_m;        ///< texture coordinates [m]: along the sweep, around its profile from the crown
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> owner;              ///< of each triangle: index of its primitive
};

}  // namespace kantaro::sim
