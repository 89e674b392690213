#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace kantaro::perception {

/// A pipe's end in a manhole, benching to the crown (thesis 5.2), as geometry: a channel as wide as
/// the pipe, its sides upright above the axis and open above the crown, in a round shaft whose wall
/// touches the pipe's end. Frame P: x right, y down, z along the pipe's axis.
class ChamberModel {
 public:
  /// How the channel goes on: to a pipe opposite, to the wall opposite, or by a right angle.
  enum class Channel { kStraight, kEnds, kLeft, kRight };

  enum class Surface { kPipe, kChannel, kEndWall, kShaft, kFarPipe };
  static constexpr std::size_t kSurfaces = 5;
  struct Hit {
    Surface surface{Surface::kPipe};
    double along{1.0};  ///< of the ray, 1 where it would meet the pipe's wall
    Eigen::Vector3d normal_P{Eigen::Vector3d::Zero()};  ///< towards the void; unit
  };

  ChamberModel(double pipe_radius_m, double shaft_diameter_m);

  /// What a ray meets first.
  /// @param from_P   in the pipe, before the mouth, at z = 0; beyond the manhole or its bend rays
  ///                 meet a pipe again, for all that is known
  /// @param wall_P   where the ray would meet the wall of an endless pipe, z above 0, and not far
  ///                 below the axis, where water lies
  /// @param mouth_m  where the pipe ends
  [[nodiscard]] Hit Trace(const Eigen::Vector3d& from_P, const Eigen::Vector3d& wall_P,
                          double mouth_m, Channel channel) const;

 private:
  [[nodiscard]] Hit FarPipe(const Eigen::Vector3d& wall_P) const;
  [[nodiscard]] Hit InShaft(const Eigen::Vector3d& from_P, const Eigen::Vector3d& ray_P,
                            double mouth_m, double over_crown) const;
  [[nodiscard]] Hit Straight(const Eigen::Vector3d& from_P, const Eigen::Vector3d& ray_P,
                             double mouth_m, bool ends) const;
  [[nodiscard]] Hit Turning(const Eigen::Vector3d& from_P, const Eigen::Vector3d& ray_P,
                            double mouth_m, double side) const;

  double pipe_m_, shaft_m_, turn_m_;  ///< radii
};

}  // namespace kantaro::perception
