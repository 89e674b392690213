#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>

namespace kantaro::sim {

/// What part of a sewer a surface belongs to.
enum class Feature : std::uint8_t { kStraight, kBend, kJoint, kInlet, kShaft, kChannel, kObstacle };

/// A locally flat wall near a point: the void lies where distance is positive.
struct Wall {
  double distance_m{};                                ///< signed, positive inside the void
  Eigen::Vector3d normal_W{Eigen::Vector3d::Zero()};  ///< unit, into the void
};

/// Cross-section of a sweep, in its axis frame's y-z plane.
enum class Profile : std::uint8_t {
  kRound,  ///< a circle
  kU  ///< open at the top: a circle's lower part, with vertical sides where it rises above the axis
};

/// A straight or circular line. Frame S stands at its start: x along it, y left, z towards the
/// crown. It bends in S's x-y plane, to the left for positive curvature.
struct SweptAxis {
  Eigen::Isometry3d X_WS{Eigen::Isometry3d::Identity()};
  double length_m{};   ///< > 0
  double curvature{};  ///< 1 / radius [1/m], 0 if straight
};

/// One convex-walled piece of empty space: a profile swept along an axis, closed by a flat cap at
/// both ends. Pipes, bends, joint grooves, inlets, channels and (upright) shafts are all sweeps;
/// the sewer is their union, less its solids.
struct VoidPrimitive : SweptAxis {
  double radius_m{};  ///< of the profile; |curvature| * radius_m < 1
  Profile profile{Profile::kRound};
  double wall_height_m{};  ///< kU only: top of the profile above the axis, > -radius_m
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
[[nodiscard]] SweepPoint ToSweep(const SweptAxis& axis, const Eigen::Vector3d& p_W);
/// And back.
[[nodiscard]] Eigen::Vector3d FromSweep(const SweptAxis& axis, const SweepPoint& point);
/// Pose of the axis frame at a distance along it.
[[nodiscard]] Eigen::Isometry3d AxisPose(const SweptAxis& axis, double along_m);

/// The walls of one primitive around a point: its side, both caps, and for kU the top. Only those
/// nearer than a cap, but always the least.
struct Walls {
  std::array<Wall, 4> wall;
  std::array<int, 4> index{};  ///< of each, for WallAt
  int count{};
  int least{};  ///< position of the least distance
};
[[nodiscard]] Walls WallsAround(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W,
                                double cap_m = std::numeric_limits<double>::infinity());

/// One of these walls as seen from another point.
[[nodiscard]] Wall WallAt(const VoidPrimitive& primitive, int index, const Eigen::Vector3d& p_W);

/// Smallest wall distance: positive inside the void, negative outside (there a lower bound of its
/// distance).
[[nodiscard]] double InsideDistance(const VoidPrimitive& primitive, const Eigen::Vector3d& p_W);

/// Corners of an axis-aligned box around the primitive.
[[nodiscard]] Eigen::AlignedBox3d BoundingBox(const VoidPrimitive& primitive);

}  // namespace kantaro::sim
