#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "network/network.hpp"

namespace kantaro::network {

/// One piece of a pipe's centre line: straight, or an arc in its frame's x-y plane.
struct AxisPiece {
  /// Pose at the piece's start, S: x downstream along the axis, y left, z towards the crown.
  Eigen::Isometry3d X_WS{Eigen::Isometry3d::Identity()};
  double start_m{};       ///< chainage of its start
  double length_m{};      ///< > 0
  double curvature{};     ///< 1 / radius [1/m], positive turning left (+Sy), 0 if straight
};

/// A point of the wall or the void in a pipe's own coordinates.
struct PipePosition {
  double chainage_m{};
  double offset_m{};      ///< distance from the centre line
  double clock_h{};       ///< 0 < h <= 12, looking downstream, 12 at the crown
};

/// The centre line of a pipe between the walls of its two shafts: straight legs joined by arcs.
/// The grade is spread evenly over the length, so every piece climbs alike.
class PipeAxis {
 public:
  /// @throws std::invalid_argument if the bends do not fit between the shafts, or the shafts touch.
  PipeAxis(const Network& network, const Pipe& pipe);

  [[nodiscard]] double length_m() const { return length_m_; }
  [[nodiscard]] const std::vector<AxisPiece>& pieces() const { return pieces_; }

  /// Pose of the axis frame at a chainage (x downstream, y left, z towards the crown). Outside
  /// 0 … length_m() it goes on straight.
  [[nodiscard]] Eigen::Isometry3d PoseAt(double chainage_m) const;
  /// The nearest point of the centre line. Points before the start have negative chainage.
  [[nodiscard]] PipePosition Locate(const Eigen::Vector3d& p_W) const;

 private:
  std::vector<AxisPiece> pieces_;
  double length_m_{};
};

/// Direction from the axis to a clock position in the axis frame: 12 is +z, and looking downstream 3 is −y.
[[nodiscard]] Eigen::Vector3d ClockDirection(double clock_h);

}  // namespace kantaro::network
