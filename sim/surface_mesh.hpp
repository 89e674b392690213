#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/solid_primitive.hpp"
#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// Triangles of the wall, seen from the void: counter-clockwise, normals pointing into the void.
struct SurfaceMesh {
  std::vector<Eigen::Vector3d> positions;  ///< p_WV [m]; a map's coordinates outgrow floats
  std::vector<Eigen::Vector3f> normals;    ///< unit, into the void
  /// Texture coordinates [m]. On sides: (chainage, arc length around the profile from the crown,
  /// clockwise looking along the axis); a kU profile counts as if it had a crown, so it continues
  /// the pipe it leads into. On caps: (chainage of the cap + height above the axis, distance left
  /// of the axis). Under a kU's top: (chainage, distance left of the axis).
  std::vector<Eigen::Vector2f> surface_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> owner;  ///< of each triangle: its primitive's number, ascending
};

/// How finely the wall is cut into flat facets.
struct TessellationOptions {
  double tolerance_m{0.2e-3};  ///< largest distance between a facet and the true surface, > 0
  double max_cell_m{1.0};      ///< longest facet along an axis, > 0
};

/// The boundary of what is free: in some void and in no solid. Each primitive becomes a polyhedron
/// (its facets are planar, round the bend too). Of a void's facet what lies inside another void or
/// a solid is cut away; of a solid's what lies in no void or in another solid. So both sides of a
/// mouth meet in the same line; they overlap there by 0.02 mm, lest a ray slip between. Where
/// surfaces coincide the earlier primitive's stays; end caps that lean on each other vanish.
/// Vertices are shared within a primitive, and no vertex lies inside a neighbour's edge there.
/// Owners are numbered voids first, then solids.
/// @throws std::invalid_argument if an option or a primitive's size makes no sense
[[nodiscard]] SurfaceMesh Tessellate(std::span<const VoidPrimitive> voids,
                                     std::span<const SolidPrimitive> solids,
                                     const TessellationOptions& options = {});
[[nodiscard]] SurfaceMesh Tessellate(std::span<const VoidPrimitive> voids,
                                     const TessellationOptions& options = {});

/// The triangles of the primitives first_owner, …, end_owner − 1, with their vertices only.
[[nodiscard]] SurfaceMesh Extract(const SurfaceMesh& mesh, std::uint32_t first_owner,
                                  std::uint32_t end_owner);

}  // namespace kantaro::sim
