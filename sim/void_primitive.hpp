#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace kantaro::sim {

/// What part of a sewer a surface belongs to.
enum class Feature : std::uint8_t { kStraight, kBend, kJoint, kInlet, kShaft, kChannel };

/// A locally flat wall near a point: the void lies where distance is positive.
struct Wall {
  double distance_m{};                                ///< signed, positive inside the void
  Eigen::Vector3d normal_W{Eigen::Vector3d::Zero()};  ///< unit, into the void
};

/// Cross-section of a sweep, in its axis frame's y-z plane.
enum class Profile : std::uint8_t {
  kRound,  ///< a circle
  kU       ///< lower half circle, vertical sides from the axis up to the wall height
};

/// One convex-walled piece of empty space: a profile swept along a straight or circular axis,
/// closed by a flat cap at both ends. Pipes, bends, joint grooves, inlets, channels and (upright)
/// shafts are all sweeps; the sewer is their union.
///
/// Frame S stands at the start of the axis: x along it, y left, z towards the crown. The axis bends
/// in S's x-y plane, to the left for positive curvature.
struct VoidPrimitive {
  Eigen::Isometry3d X_WS{Eigen::Isometry3d::Identity()};
  double length_m{};   ///< along the axis, > 0
  double curvature{};  ///< 1 / radius of the axis [1/m], 0 if straight; |curvature| * radius_m < 1
  double radius_m{};   ///< of the profile
  Profile profile{Profile::kRound};
  double wall_height_m{};  ///< kU only: top of the sides above the axis
  Feature feature{Feature::kStraight};
  std::uint32_t part{};  ///< index into the sewer's parts (pipe or manhole it came from)
  /// Chainage of the axis' start in its pipe, for texture and truth; 0 for manholes.
  double start_chainage_m{};
};

/// A point in sweep coordinates: along the axis, left of it, above it.
struct SweepPoint {
  double along_m{}, left_m{}, up_m{};
};

/// World point to sweep coordinates. Beyond the ends the axis is continued straight or round.
[[nodiscard]] SweepPoint ToSweep(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W);
/// And back.
[[nodiscard]] Eigen::Vector3d FromSweep(const VoidPrimitive& primitive, const SweepPoint& point);
/// Pose of the axis frame at a distance along it.
[[nodiscard]] Eigen::Isometry3d AxisPose(const VoidPrimitive& primitive, double along_m);

/// The walls of one primitive around a point: sides, start cap, end cap, and for kU the top.
struct Walls {
  std::array<Wall, 4> wall;
  int count{};
};
[[nodiscard]] Walls WallsAround(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W);

/// Smallest wall distance: positive inside the void, negative outside (there a lower bound of its
/// distance).
[[nodiscard]] double InsideDistance(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W);

/// Corners of an axis-aligned box around the primitive.
[[nodiscard]] Eigen::AlignedBox3d BoundingBox(const VoidPrimitive& primitive);

}  // namespace kantaro::sim
