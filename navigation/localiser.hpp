#pragma once

#include <Eigen/Core>

#include "navigation/map.hpp"
#include "navigation/parameters.hpp"

namespace kantaro::navigation {

/// Position along one leg of a route, from wheels that slip and a map that is off.
///
/// A Kalman filter over x = (d, L, s): d, distance of the base's origin from the wall where the leg
/// begins [m]; L, true length of the leg [m]; s, true travel per wheel travel, learned over the
/// whole mission. Every landmark is a linear measurement of these: a wall tells L − d or d, a
/// mapped landmark at share f of the leg tells f L − d.
class Localiser {
 public:
  Localiser(const MapLeg& leg, double distance_m, const Parameters& parameters);

  /// The wheels have rolled so far [m], negative backwards.
  void Advance(double wheel_travel_m);
  /// The end wall is `ahead_m` in front of the base's origin (negative: behind). @returns whether
  /// it was believed.
  bool SeeEndWall(double ahead_m, double deviation_m);
  /// The start wall is `behind_m` behind the base's origin.
  bool SeeStartWall(double behind_m, double deviation_m);
  /// A landmark that the map has at `mapped_m` of the leg is `ahead_m` in front. Believed within
  /// the gate.
  bool SeeLandmark(double mapped_m, double ahead_m, double deviation_m);
  /// True travel per wheel travel was measured.
  void SeeScale(double scale, double deviation);

  /// The distance may be off by so much more [m], as after wheels that may have spun.
  void Doubt(double deviation_m) { P_(0, 0) += deviation_m * deviation_m; }

  /// What was learned of the leg's length was wrong: back to the map's, as unsure as at first.
  void ForgetLength();

  /// Goes over to the next leg; the base's origin is `distance_m` beyond its start wall (usually
  /// negative: still in the manhole).
  void Begin(const MapLeg& leg, double distance_m, double deviation_m);

  [[nodiscard]] double distance_m() const { return x_(0); }
  [[nodiscard]] double length_m() const { return x_(1); }
  [[nodiscard]] double scale() const { return x_(2); }
  [[nodiscard]] double deviation_m() const;  ///< of the distance
  [[nodiscard]] double to_end_m() const { return x_(1) - x_(0); }
  [[nodiscard]] double to_end_deviation_m() const {
    return to_landmark_deviation_m(mapped_length_m_);
  }
  /// Of the way to a landmark that the map has at `mapped_m` of the leg.
  [[nodiscard]] double to_landmark_deviation_m(double mapped_m) const;

 private:
  bool Update(const Eigen::RowVector3d& h, double measured, double deviation,
              double gate_deviations);

  Parameters parameters_;
  double mapped_length_m_{};
  Eigen::Vector3d x_{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d P_{Eigen::Matrix3d::Zero()};
};

}  // namespace kantaro::navigation
