#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "sim/solid_primitive.hpp"
#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// A face of a convex body; its normal points into the body.
struct Plane {
  Eigen::Vector3d normal;
  double offset{};
  bool internal{};  ///< between two slabs of one polyhedron: no surface

  [[nodiscard]] double Distance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

/// A convex piece of a polyhedron.
struct Slab {
  std::vector<Plane> planes;
  Eigen::AlignedBox3d box;
};

/// A planar face, counter-clockwise seen from the void.
struct Facet {
  std::vector<std::uint32_t> corners;  ///< points of the polyhedron
  std::vector<std::size_t> edges;  ///< numbers of those behind the corners, shared by neighbours
  /// Facets of one shade share the normals and texture coordinates of the points they share.
  std::uint32_t shade{};
  double angle{};                                    ///< of its middle from the crown
  Eigen::Vector3d normal{Eigen::Vector3d::UnitZ()};  ///< of a flat one, into the void
};

/// How the surface looks at a point of a facet: as in SurfaceMesh.
struct VertexLook {
  Eigen::Vector3d normal{Eigen::Vector3d::Zero()};
  Eigen::Vector2d surface_m{Eigen::Vector2d::Zero()};
};

/// What stands for a primitive in the mesh: flat facets, within the tolerance of its true surface.
struct Polyhedron {
  std::vector<Eigen::Vector3d> points;
  std::vector<Facet> facets;
  std::vector<Slab> slabs;  ///< together the inside
  Eigen::AlignedBox3d box;
  std::function<VertexLook(const Eigen::Vector3d&, const Facet&)> look;
};

/// @param tolerance_m  largest distance between a facet and the true surface
/// @param max_cell_m   longest facet along an axis
[[nodiscard]] Polyhedron PolyhedronOf(const VoidPrimitive& primitive, double tolerance_m,
                                      double max_cell_m);
[[nodiscard]] Polyhedron PolyhedronOf(const SolidPrimitive& solid, double tolerance_m,
                                      double max_cell_m);

/// Slabs' boxes are grown by so much; facing caps closer than this have no wall between them.
inline constexpr double kMembrane_m = 1e-5;

}  // namespace kantaro::sim
