#include "robot/lens.hpp"

#include <Eigen/LU>

namespace kantaro::robot {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Vector2d Distort(const Lens& lens, const Vector2d& d) {
  const double x = d.x(), y = d.y(), r2 = d.squaredNorm();
  const double radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  return {x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x),
          y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y};
}

/// The distortion's derivative.
Matrix2d Slope(const Lens& lens, const Vector2d& d) {
  const double x = d.x(), y = d.y(), r2 = d.squaredNorm();
  const double radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double steep = 2.0 * (lens.k1 + r2 * (2.0 * lens.k2 + 3.0 * r2 * lens.k3));
  const double mixed = x * y * steep + 2.0 * (lens.p1 * x + lens.p2 * y);
  return (Matrix2d() << radial + x * x * steep + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x, mixed,
          mixed, radial + y * y * steep + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x)
      .finished();
}

}  // namespace

Vector2d Project(const Lens& lens, const Vector2d& direction) {
  const Vector2d d = Distort(lens, direction);
  return {lens.center_x_px + lens.focal_x_px * d.x(), lens.center_y_px + lens.focal_y_px * d.y()};
}

Vector2d Unproject(const Lens& lens, const Vector2d& p_px) {
  constexpr int kMostSteps = 30;
  const Vector2d seen((p_px.x() - lens.center_x_px) / lens.focal_x_px,
                      (p_px.y() - lens.center_y_px) / lens.focal_y_px);
  Vector2d d = seen;
  for (int i = 0; i < kMostSteps; ++i) {  // Newton's
    const Vector2d error = Distort(lens, d) - seen;
    if (error.squaredNorm() < 1e-28) break;
    d -= Slope(lens, d).inverse() * error;
  }
  return d;
}

bool Folds(const Lens& lens, double largest_radius) {
  constexpr int kSteps = 256;
  for (int i = 0; i <= kSteps; ++i) {
    const double r = largest_radius * i / kSteps, r2 = r * r;
    if (1.0 + r2 * (3.0 * lens.k1 + r2 * (5.0 * lens.k2 + 7.0 * r2 * lens.k3)) <= 0.0) return true;
  }
  return false;
}

}  // namespace kantaro::robot
