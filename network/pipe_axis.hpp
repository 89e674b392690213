#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "network/network.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {

/// One piece of a pipe's centre line: straight, or an arc in its frame's x-y plane.
struct AxisPiece {
  /// Pose at the piece's start, S: x downstream along the axis, y left, z towards the crown.
  Eigen::Isometry3d X_WS{Eigen::Isometry3d::Identity()};
  double start_m{};    ///< chainage of its start
  double length_m{};   ///< > 0
  double curvature{};  ///< 1 / radius [1/m], positive turning left (+Sy), 0 if straight
};

/// Pose of the axis frame along a piece, from its start; beyond its ends it goes on straight.
[[nodiscard]] Eigen::Isometry3d PoseOn(const AxisPiece& piece, double along_m);

/// A point of the wall or the void in a pipe's own coordinates.
struct PipePosition {
  double chainage_m{};
  double offset_m{};  ///< distance from the centre line
  double clock_h{};   ///< 0 < h <= 12, looking downstream, 12 at the crown
};

/// What a pipe needs to know of the manhole it ends in.
struct ShaftEnd {
  Eigen::Vector3d p_WM{Eigen::Vector3d::Zero()};  ///< as in Manhole
  double radius_m{};                              ///< of the shaft, > 0
};

/// The shortest pipe between two shaft walls [m]: anything less is a fault of the drawing.
inline constexpr double kShortestPipe_m = 0.1;

/// Slope against the design line beyond which a length is refused: no pipe is laid like that.
inline constexpr double kSteepestLength = 0.5;

[[nodiscard]] ShaftEnd EndAt(const Network& network, const NetworkIndex& index,
                             std::size_t manhole);

/// The centre line of a pipe between the walls of its two shafts.
///
/// As designed it has straight legs joined by arcs, seen from above tangent to each other and aimed
/// at the manholes' centres. It starts at the upstream manhole's invert + upstream_offset_m + pipe
/// radius, where the first leg crosses the shaft's wall, and ends likewise, with the downstream
/// diameter. The grade, rise over plan length, is spread evenly: every piece is tilted to rise by
/// its plan length times the grade, arcs about their chord. Pieces meet exactly in position. In
/// direction they miss each other by up to grade · (1 − (φ/2) / tan(φ/2)), φ being the turn of the
/// arc piece. Bends sharper than 45° are made of several pieces, so that is 5 % of the grade:
/// 0.5 mrad at 1 %. A bend of less than 1 mrad stays a corner.
///
/// As laid it is what the pipe has become: joints with an offset or a deflection, sags and diameter
/// changes displace it from the design line by u (left, up; in the design line's axis frame).
///  - u jumps by the offset at a joint, and its slope changes by tan(deflection). In between it is
///    linear. It is zero at both ends, which the manholes hold: one slope that all lengths share
///    sees to that, as lengths turn a little in the walls of their manholes.
///  - The joints within a sag lie on a parabola below that, the lengths are its chords.
///  - At a diameter change u steps by half the change: up where the inverts run on, down where the
///    crowns do. The grade is such that both ends' inverts are met.
/// Pieces then begin and end at such joints and changes, and there alone they do not meet: they lie
/// apart by the offset or step. Where only straight pieces follow each other within a length, it is
/// straight; arcs keep their turn, and their radius follows from their displaced ends (5 mm inwards
/// make 450 mm 445 mm), tangent to their neighbours within some percent of the slope.
///
/// Chainage is measured along the line as laid, and the joints stand at theirs exactly. The line is
/// longer than the design by half its slopes' square (a slope of 10 mm in 1 m: 5e-5) and by
/// what bends gain or lose (radius by turn): commonly less than 1e-4 of its length.
class PipeAxis {
 public:
  /// @throws std::invalid_argument saying what is wrong if the bends do not fit between the shafts,
  ///         the shafts leave less than kShortestPipe_m, the pipe is steeper than 45°, or what
  ///         displaces it turns a length by more than kSteepestLength from the design line.
  /// @throws std::out_of_range if the network lacks one of the pipe's manholes.
  PipeAxis(const Network& network, const Pipe& pipe);
  /// The same for a whole network, without looking names up again. @param pipe  its position.
  PipeAxis(const Network& network, const NetworkIndex& index, std::size_t pipe);
  /// The same from the two ends alone.
  PipeAxis(const ShaftEnd& upstream, const ShaftEnd& downstream, const Pipe& pipe);

  [[nodiscard]] double length_m() const { return length_m_; }  ///< as laid
  [[nodiscard]] const std::vector<AxisPiece>& pieces() const { return pieces_; }
  /// Rise over plan length as designed, negative if it falls downstream.
  [[nodiscard]] double grade() const { return grade_; }

  /// Pose of the axis frame at a chainage (x downstream, y left, z towards the crown); at a joint
  /// or diameter change, of the length that begins there. Outside 0 … length_m() it goes on
  /// straight.
  [[nodiscard]] Eigen::Isometry3d PoseAt(double chainage_m) const;
  /// The nearest point of the centre line. Points before the start have negative chainage, points
  /// beyond the end more than length_m().
  [[nodiscard]] PipePosition Locate(const Eigen::Vector3d& p_W) const;

 private:
  std::vector<AxisPiece> pieces_;
  double length_m_{};
  double grade_{};
};

/// Length of the centre line as designed [m], whatever displaces it. Patterns of joints go by it.
/// @throws as PipeAxis
[[nodiscard]] double DesignLength(const ShaftEnd& upstream, const ShaftEnd& downstream,
                                  const Pipe& pipe);

/// Direction from the axis to a clock position in the axis frame: 12 is +z, and looking downstream
/// 3 is −y.
[[nodiscard]] Eigen::Vector3d ClockDirection(double clock_h);

}  // namespace kantaro::network
