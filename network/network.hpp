#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace kantaro::network {

/// Wall material: decides the look and the friction of a pipe.
enum class Material { kPvc, kClay, kConcrete, kLined };

/// What covers the wall: decides friction and rolling resistance, and how it shines.
enum class WallCondition { kDry, kWet, kSlimy };

/// How high the benching of a manhole stands, measured from the invert of its channels: at the axis
/// or the crown of the largest pipe, or as given. A flat floor has neither channels nor benching.
enum class BenchHeight { kFlat, kAxis, kCrown, kGiven };

/// Which line runs on where the diameter changes.
enum class Alignment { kInvert, kAxis, kCrown };

/// The nine categories of JSWA faults (thesis Table 3.1).
enum class FaultCategory {
  kCrack,
  kWaterInfiltration,
  kRootInvasion,
  kPipeBreak,
  kJointAndGap,
  kMountingPipeProjection,
  kAdhesionOfMortar,
  kForeignSubstance,
  kAdhesionOfGrease
};
/// JSWA rank: A most visible, C hardly visible (thesis section 3.2).
enum class FaultRank { kA, kB, kC };

/// A node of the network. Its centre line is vertical; pipes are aimed at it.
struct Manhole {
  std::string name;
  Eigen::Vector3d p_WM{
      Eigen::Vector3d::Zero()};            ///< centre at the invert of the channels [m], z up
  std::optional<double> shaft_diameter_m;  ///< absent: largest connected pipe + 500 mm (thesis 5.2)
  double depth_m{2.0};                     ///< invert to cover [m], > 0
  BenchHeight bench_height{BenchHeight::kCrown};
  double given_bench_m{};  ///< kGiven only: of the benching above the invert, > 0
  /// Centre-line radius of a curved channel [m]; absent: 0.66 of the shaft's radius.
  std::optional<double> channel_radius_m;

  bool operator==(const Manhole&) const = default;
};

/// A joint between two pipe lengths, seen as a groove around the wall. The length after it may lie
/// beside the one before (offset) and point elsewhere (deflection); PipeAxis says how the line is
/// laid then.
struct Joint {
  double chainage_m{};             ///< of the groove's middle
  double gap_m{0.008};             ///< width of the groove along the axis, > 0
  double depth_m{0.006};           ///< depth of the groove into the wall, > 0
  double offset_m{};               ///< of the next length's axis against this one's, >= 0
  double offset_clock_h{6.0};      ///< which way it is offset, looking downstream
  double deflection_rad{};         ///< angle between the two lengths' axes, >= 0
  double deflection_clock_h{6.0};  ///< which way the next length points, looking downstream

  bool operator==(const Joint&) const = default;
};

/// A stretch of pipe that has sunk: its joints lie on a parabola below the grade, and the lengths
/// between them are chords of it.
struct Sag {
  double start_m{};  ///< chainage
  double end_m{};
  double depth_m{};  ///< below the grade at the middle, > 0

  bool operator==(const Sag&) const = default;
};

/// From here on, downstream, the pipe has another diameter: a step with a plane face.
struct DiameterChange {
  double chainage_m{};
  double diameter_m{};
  Alignment alignment{Alignment::kInvert};

  bool operator==(const DiameterChange&) const = default;
};

/// A house connection: a round branch ending in the pipe's wall.
struct Inlet {
  std::string name;
  double chainage_m{};  ///< where its axis meets the pipe's
  double diameter_m{};  ///< less than the pipe's
  double clock_h{3.0};  ///< clock position of its mouth, 0 < h <= 12, looking downstream
  /// Between the branch, going out, and the way upstream. Square: 90°; at 45° its water joins the
  /// flow.
  double angle_rad{std::numbers::pi / 2.0};
  double protrusion_m{};  ///< how far its end stands into the pipe, 0 if flush

  bool operator==(const Inlet&) const = default;
};

/// Something in the way, solid to wheels and rays.
enum class ObstacleKind {
  kSediment,     ///< bed along the invert, level across; its ends lie at the angle of repose
  kStone,        ///< cap of a sphere on the wall, `width_m` across at its foot
  kMortarRidge,  ///< ridge of even height across the wall; without `width_m` a full ring
  kBrick         ///< box standing on the wall
};
struct Obstacle {
  std::string name;
  ObstacleKind kind{ObstacleKind::kStone};
  double chainage_m{};  ///< of its middle
  double clock_h{6.0};  ///< of its middle; sediment lies at 6
  double height_m{};    ///< from the wall (sediment: the invert) towards the axis, > 0
  double length_m{};    ///< along the pipe, > 0; a stone's is its width
  double width_m{};     ///< across: a stone's foot, a brick's side, a ridge's arc; 0: full ring

  bool operator==(const Obstacle&) const = default;
};

/// Damage planted on a wall: it is seen, and it is what the fault detector is judged against.
struct Fault {
  std::string name;
  FaultCategory category{FaultCategory::kCrack};
  FaultRank rank{FaultRank::kA};
  double chainage_m{};    ///< of its middle
  double clock_h{12.0};   ///< of its middle
  double length_m{0.1};   ///< extent along the axis
  double width_m{0.005};  ///< opening of a crack; extent around the wall of anything else

  bool operator==(const Fault&) const = default;
};

/// A point where a pipe's centre line turns, rounded by an arc.
struct Bend {
  Eigen::Vector2d p_W{Eigen::Vector2d::Zero()};  ///< where the two straight legs would meet [m]
  double radius_m{};                             ///< of the centre line, > diameter / 2

  bool operator==(const Bend&) const = default;
};

/// A circular pipe between two manholes. Chainage runs from the upstream manhole's shaft wall to
/// the downstream one's (PipeAxis tells where that is).
struct Pipe {
  std::string name;
  std::string upstream;    ///< manhole name
  std::string downstream;  ///< manhole name
  double diameter_m{};     ///< inner, at the upstream end
  Material material{Material::kPvc};
  WallCondition condition{WallCondition::kDry};
  double water_m{};            ///< depth of the water that stands along the invert, 0 if none
  double upstream_offset_m{};  ///< invert of this end above the manhole's invert [m], >= 0
  double downstream_offset_m{};
  std::vector<Bend> bends;                       ///< in the order of chainage
  std::vector<Joint> joints;                     ///< likewise
  std::vector<Sag> sags;                         ///< likewise
  std::vector<DiameterChange> diameter_changes;  ///< likewise
  std::vector<Inlet> inlets;
  std::vector<Obstacle> obstacles;
  std::vector<Fault> faults;

  [[nodiscard]] double DiameterAt(double chainage_m) const;
  [[nodiscard]] double DownstreamDiameter() const;
  /// Inner diameter at its end in this manhole.
  [[nodiscard]] double DiameterIn(const std::string& manhole) const;

  bool operator==(const Pipe&) const = default;
};

/// What a reader left out or filled in, for the person who supplied the file.
struct Remark {
  std::optional<int> line;  ///< in the file, 1-based
  std::string subject;      ///< "conduit 17"
  std::string text;         ///< what was done and why
  bool operator==(const Remark&) const = default;
};

/// Something between two manholes that KANTARO cannot enter and that is not built (egg-shaped, a
/// pump, a weir ...): kept for the map. Its ends may be no manholes of the network.
struct SkippedLink {
  std::string name, upstream, downstream;
  std::string reason;
  double length_m{};                     ///< from node to node, 0 if not known
  double height_m{};                     ///< inside, 0 if not known
  std::vector<Eigen::Vector2d> via_W{};  ///< corners of its course between its ends [m]
  bool operator==(const SkippedLink&) const = default;
};

/// The sewer as a domain model. Names are unique among manholes and among pipes.
struct Network {
  std::string name;
  std::vector<Manhole> manholes;
  std::vector<Pipe> pipes;
  std::vector<SkippedLink> skipped;
  std::vector<Remark> remarks;

  /// Position in `manholes` or `pipes`, absent if there is none of that name.
  [[nodiscard]] std::optional<std::size_t> FindManhole(const std::string& manhole) const;
  [[nodiscard]] std::optional<std::size_t> FindPipe(const std::string& pipe) const;
  /// @throws std::out_of_range
  [[nodiscard]] const Manhole& ManholeNamed(const std::string& manhole) const;
  [[nodiscard]] const Pipe& PipeNamed(const std::string& pipe) const;
  /// Indices of the pipes that end in this manhole, in the order of `pipes`.
  [[nodiscard]] std::vector<std::size_t> PipesAt(const std::string& manhole) const;
  /// Given, or the largest connected pipe + 500 mm.
  [[nodiscard]] double ShaftDiameter(const Manhole& manhole) const;
  bool operator==(const Network&) const = default;
};

/// A shaft is at least so much wider than each of its pipes: the channel in its floor needs walls.
inline constexpr double kLeastBenching_m = 0.100;

/// Diameters KANTARO is built for [m] (thesis 5.5: 250 to 350 mm; the platform: from 200 mm).
inline constexpr double kSmallestEnterable_m = 0.200;
inline constexpr double kLargestEnterable_m = 0.350;
/// Whether it is so over the pipe's whole length.
[[nodiscard]] bool IsEnterable(const Pipe& pipe);

}  // namespace kantaro::network
