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

[[nodiscard]] ShaftEnd EndAt(const Network& network, const NetworkIndex& index,
                             std::size_t manhole);

/// The centre line of a pipe between the walls of its two shafts: straight legs joined by arcs,
/// seen from above tangent to each other and aimed at the manholes' centres. It starts at the
/// upstream manhole's invert + upstream_offset_m + pipe radius, where the first leg crosses the
/// shaft's wall.
///
/// The grade, rise over plan length, is spread evenly: every piece is tilted to rise by its plan
/// length times the grade, arcs about their chord. Pieces meet exactly in position. In direction
/// they miss each other by up to grade · (1 − (φ/2) / tan(φ/2)), φ being the turn of the arc piece.
/// Bends sharper than 45° are made of several pieces, so that is 5 % of the grade: 0.5 mrad at 1 %.
/// A bend of less than 1 mrad stays a corner.
class PipeAxis {
 public:
  /// @throws std::invalid_argument saying what is wrong if the bends do not fit between the shafts,
  ///         the shafts leave less than kShortestPipe_m, or the pipe is steeper than 45°.
  /// @throws std::out_of_range if the network lacks one of the pipe's manholes.
  PipeAxis(const Network& network, const Pipe& pipe);
  /// The same for a whole network, without looking names up again. @param pipe  its position.
  PipeAxis(const Network& network, const NetworkIndex& index, std::size_t pipe);
  /// The same from the two ends alone.
  PipeAxis(const ShaftEnd& upstream, const ShaftEnd& downstream, const Pipe& pipe);

  [[nodiscard]] double length_m() const { return length_m_; }
  [[nodiscard]] const std::vector<AxisPiece>& pieces() const { return pieces_; }
  /// Rise over plan length, negative if it falls downstream.
  [[nodiscard]] double grade() const { return grade_; }

  /// Pose of the axis frame at a chainage (x downstream, y left, z towards the crown). Outside
  /// 0 … length_m() it goes on straight.
  [[nodiscard]] Eigen::Isometry3d PoseAt(double chainage_m) const;
  /// The nearest point of the centre line. Points before the start have negative chainage, points
  /// beyond the end more than length_m().
  [[nodiscard]] PipePosition Locate(const Eigen::Vector3d& p_W) const;

 private:
  std::vector<AxisPiece> pieces_;
  double length_m_{};
  double grade_{};
};

/// Direction from the axis to a clock position in the axis frame: 12 is +z, and looking downstream
/// 3 is −y.
[[nodiscard]] Eigen::Vector3d ClockDirection(double clock_h);

}  // namespace kantaro::network
