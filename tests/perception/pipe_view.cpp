#include "pipe_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>

#include "base/random.hpp"

namespace kantaro::perception {
namespace {

using Eigen::Vector3d;

constexpr double kShaftRadius_m = 0.4, kShaftHeight_m = 2.0;

/// A repeatable number in [-1, 1] for a patch of the wall.
double Speckle(int a, int b) {
  std::uint32_t h =
      static_cast<std::uint32_t>(a) * 374761393U + static_cast<std::uint32_t>(b) * 668265263U;
  h = (h ^ (h >> 13U)) * 1274126177U;
  return static_cast<double>((h ^ (h >> 16U)) & 0xFFFFU) / 32767.5 - 1.0;
}

double Lit(const Vector3d& p, const Vector3d& normal, const Vector3d& eye) {
  const Vector3d to_eye = eye - p;
  const double square = to_eye.squaredNorm();
  return std::abs(normal.dot(to_eye)) / std::sqrt(square) / square;
}

double WallBrightness(const PipeView& view, const Vector3d& p, const Vector3d& eye) {
  const double clock_rad = std::atan2(p.x(), -p.y());
  double brightness = Lit(p, Vector3d(p.x(), p.y(), 0) / view.radius_m, eye);
  brightness *=
      1 + view.texture * Speckle(static_cast<int>(std::floor(p.z() / 0.008)),
                                 static_cast<int>(std::floor(clock_rad * view.radius_m / 0.008)));
  for (const ViewedJoint& joint : view.joints) {
    if (std::abs(p.z() - joint.distance_m) < joint.width_m / 2) brightness *= joint.brightness;
  }
  for (const ViewedCrack& crack : view.cracks) {
    const double off_rad =
        std::remainder(clock_rad - crack.clock_h * std::numbers::pi / 6, 2 * std::numbers::pi);
    const double wander_m = 0.006 * std::sin(p.z() * 60);  // cracks are not straight
    if (p.z() > crack.near_m && p.z() < crack.far_m &&
        std::abs(off_rad * view.radius_m - wander_m) < crack.width_m / 2) {
      brightness *= 0.15;
    }
  }
  return brightness;
}

/// Inside the manhole beyond the mouth: from pipe to pipe a channel with upright sides up to the
/// crown, above it the round shaft.
bool InManhole(const PipeView& view, double from_mouth_m, const Vector3d& p) {
  const double r = view.radius_m;
  if (from_mouth_m < 0) return false;
  if (from_mouth_m > 2 * kShaftRadius_m || p.y() > 0) return std::hypot(p.x(), p.y()) < r;
  if (p.y() > -r) return std::abs(p.x()) < r;
  return p.y() > -kShaftHeight_m &&
         std::hypot(p.x(), from_mouth_m - kShaftRadius_m) < kShaftRadius_m;
}

/// Marches on from the mouth. The brightness of what is met: lit as the surface of the void, by its
/// gradient.
double BeyondMouth(const PipeView& view, const Vector3d& eye, const Vector3d& ray, double start) {
  double t = start;
  while (t < start + 4.0) {
    const Vector3d p = eye + t * ray;
    if (!InManhole(view, p.z() - *view.mouth_m, p)) {
      const double d = 0.004;
      const auto outside = [&](const Vector3d& at) {
        return InManhole(view, at.z() - *view.mouth_m, at) ? 0.0 : 1.0;
      };
      Vector3d normal = Vector3d::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d e = d * Vector3d::Unit(axis);
        normal[axis] = outside(p + e) - outside(p - e);
      }
      if (normal.norm() < 0.5) normal = ray;
      return Lit(p, normal.normalized(), eye);
    }
    t += 0.003;
  }
  return 0.0;
}

double Trace(const PipeView& view, const Vector3d& eye, const Vector3d& ray) {
  const double a = ray.x() * ray.x() + ray.y() * ray.y();
  const double b = eye.x() * ray.x() + eye.y() * ray.y();
  const double c = eye.x() * eye.x() + eye.y() * eye.y() - view.radius_m * view.radius_m;
  const double t = a > 1e-12 ? (-b + std::sqrt(b * b - a * c)) / a : 1e6;
  const double z = eye.z() + t * ray.z();
  if (view.mouth_m && z > *view.mouth_m) {
    return BeyondMouth(view, eye, ray, (*view.mouth_m - eye.z()) / ray.z() + 1e-4);
  }
  return z > 30 ? 0.0 : WallBrightness(view, eye + t * ray, eye);
}

}  // namespace

robot::Camera FrontCamera() {
  robot::Camera camera;
  camera.width_px = 704;
  camera.height_px = 480;
  camera.focal_px = 609.682;
  camera.center_x_px = 351.5;
  camera.center_y_px = 239.5;
  return camera;
}

cv::Mat Draw(const PipeView& view) {
  const robot::Camera camera = FrontCamera();
  const Vector3d eye(view.camera_right_m, view.camera_down_m, view.camera_ahead_m);
  const Eigen::Matrix3d R_QC = (Eigen::AngleAxisd(view.yaw_rad, Vector3d::UnitY()) *
                                Eigen::AngleAxisd(view.pitch_rad, Vector3d::UnitX()))
                                   .toRotationMatrix();
  // 80 grey levels on the wall half a metre ahead.
  const double gain = 80 / Lit({0, view.radius_m, 0.5}, Vector3d::UnitY(), Vector3d::Zero());
  RandomStream noise(view.noise_seed, "pipe view");
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC3);
  constexpr int kSubs = 3;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      double sum = 0;
      for (int s = 0; s < kSubs * kSubs; ++s) {
        const double u = column - 0.5 + (s % kSubs + 0.5) / kSubs;
        const double v = row - 0.5 + (s / kSubs + 0.5) / kSubs;
        const Vector3d ray = R_QC * Vector3d((u - camera.center_x_px) / camera.focal_px,
                                             (v - camera.center_y_px) / camera.focal_px, 1)
                                        .normalized();
        sum += Trace(view, eye, ray);
      }
      const double level =
          gain * sum / (kSubs * kSubs) + (view.noise > 0 ? noise.Normal(view.noise) : 0);
      const auto grey = static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
      image.at<cv::Vec3b>(row, column) = {grey, grey, grey};
    }
  }
  return image;
}

}  // namespace kantaro::perception
