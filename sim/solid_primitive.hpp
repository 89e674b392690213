#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// A bed of sediment: a prism along the axis, level across, reaching a little into the wall.
struct Bed {
  SweptAxis axis;  ///< of the stretch it lies in
  /// Its outline seen from the side, (along, above the axis), convex, counter-clockwise.
  std::array<Eigen::Vector2d, 6> outline{};
  std::size_t corners{};
  double half_width_m{};
};

/// A stone: a ball, cut off inside the wall.
struct Ball {
  Eigen::Vector3d p_WB{Eigen::Vector3d::Zero()};
  double radius_m{};
  Eigen::Vector3d up_W{Eigen::Vector3d::UnitZ()};  ///< away from the wall, unit
  double foot_m{};                                 ///< height of the cut above its middle, < radius
};

/// Mortar across the wall: a ring or a part of one, with square faces.
struct Ridge {
  SweptAxis axis;  ///< from its first face to its last
  double inner_radius_m{};
  double outer_radius_m{};  ///< inside the wall
  double middle_rad{};      ///< of its arc, from the crown, clockwise looking along the axis
  double half_arc_rad{};    ///< pi: a full ring
};

/// A brick.
struct Block {
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};  ///< at its middle
  Eigen::Vector3d half_m{Eigen::Vector3d::Zero()};
};

/// The end of a branch that stands into the pipe: a tube around the x axis of its frame.
struct Stub {
  Eigen::Isometry3d X_WS{Eigen::Isometry3d::Identity()};  ///< x out along the branch
  double start_m{};                                       ///< where it ends in the pipe
  double end_m{};                                         ///< inside the wall
  double inner_radius_m{};
  double outer_radius_m{};
};

/// Something solid that stands in a void. Where it reaches into the wall it is one with it.
struct SolidPrimitive {
  std::variant<Bed, Ball, Ridge, Block, Stub> shape;
  Feature feature{Feature::kObstacle};  ///< or kInlet: a stub
  std::uint32_t part{};                 ///< index into the sewer's parts
  std::uint32_t item{};                 ///< index into the pipe's obstacles, or its inlets
  double start_chainage_m{};            ///< where it begins, for texture
};

/// Signed distance to the surface, positive outside the solid, and the way out. Exact along a
/// straight axis; round a bend, lengths along it are taken as at the point.
[[nodiscard]] Wall SurfaceOf(const SolidPrimitive& solid, const Eigen::Vector3d& p_W);

/// The same solid elsewhere.
[[nodiscard]] SolidPrimitive Moved(SolidPrimitive solid, const Eigen::Vector3d& by_W);

/// Corners of an axis-aligned box around the solid.
[[nodiscard]] Eigen::AlignedBox3d BoundingBox(const SolidPrimitive& solid);

}  // namespace kantaro::sim
