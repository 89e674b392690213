#pragma once

#include <Eigen/Core>

namespace kantaro::robot {

/// A lens in front of a sensor: pinhole and Brown-Conrady distortion (D. C. Brown, Photogrammetric
/// Engineering 32, 1966), as OpenCV and ROS ("plumb_bob") write it. Pixel centres lie at whole
/// numbers. Directions are (x, y) = (X/Z, Y/Z) in the optical frame C (x right, y down, z forward).
struct Lens {
  double focal_x_px{}, focal_y_px{};
  double center_x_px{}, center_y_px{};
  double k1{}, k2{};  ///< radial: r² and r⁴
  double p1{}, p2{};  ///< tangential
  double k3{};        ///< radial: r⁶
};

/// Where a direction is seen [px].
[[nodiscard]] Eigen::Vector2d Project(const Lens& lens, const Eigen::Vector2d& direction);

/// The direction that a pixel sees: Project's inverse, to 1e-12, where the lens does not fold.
[[nodiscard]] Eigen::Vector2d Unproject(const Lens& lens, const Eigen::Vector2d& p_px);

/// Whether two directions within this angle's tangent of the axis may be seen in one place: such a
/// lens has no inverse. Counts the radial part alone; the tangential one is small.
[[nodiscard]] bool Folds(const Lens& lens, double largest_radius);

}  // namespace kantaro::robot
