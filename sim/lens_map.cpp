#include "sim/lens_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// What a drop does to the line of sight of a pixel and to its light.
struct Bent {
  Vector2d p_px;
  double transmission{1.0};
};

Bent Bend(const std::vector<LensDrop>& drops, const Vector2d& p_px) {
  for (const LensDrop& drop : drops) {
    const Vector2d from = p_px - drop.middle_px;
    if (from.norm() >= (1.0 + drop.sag) * drop.radius_px) continue;
    const double downward = from.y() / std::max(from.norm(), 1e-9);
    const double share = from.norm() / (drop.radius_px * (1.0 + drop.sag * downward));
    if (share >= 1.0) continue;
    // Thickest in the middle; towards the rim it lets the picture pass as it is.
    const double thick = 1.0 - share * share;
    const double rim = std::exp(-std::pow((share - 0.85) / 0.12, 2.0));
    return {drop.middle_px + (1.0 - drop.squeeze * thick * thick) * from,
            1.0 - 0.35 * rim * std::min(1.0, 8.0 * (1.0 - share))};
  }
  return {p_px};
}

double Vignetting(const robot::Camera& camera, const robot::Lens& lens, const Vector2d& p_px,
                  const Vector2d& direction) {
  if (!camera.sensor.vignetting) {
    const double cos2 = 1.0 / (1.0 + direction.squaredNorm());
    return cos2 * cos2;
  }
  const auto& [a, b, c] = *camera.sensor.vignetting;
  const double half_diagonal = 0.5 * std::hypot(camera.width_px, camera.height_px);
  const double r2 = (p_px - Vector2d(lens.center_x_px, lens.center_y_px)).squaredNorm() /
                    (half_diagonal * half_diagonal);
  return std::max(0.0, 1.0 + r2 * (a + r2 * (b + r2 * c)));
}

/// The smallest pinhole picture that holds all directions that the lens sees, and a margin.
CameraView IdealView(const robot::Camera& camera, const robot::Lens& lens) {
  const int margin_px =
      LensMap::kBlurMargin_px + (camera.sensor.interlaced ? LensMap::kFieldMargin_px : 0);
  Vector2d least(0.0, 0.0), most(0.0, 0.0);
  const auto include = [&](double x, double y) {
    const Vector2d direction = robot::Unproject(lens, {x, y});
    least = least.cwiseMin(direction);
    most = most.cwiseMax(direction);
  };
  const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
  for (int x = 0; x < camera.width_px; ++x) {
    include(x, 0.0);
    include(x, bottom);
  }
  for (int y = 0; y < camera.height_px; ++y) {
    include(0.0, y);
    include(right, y);
  }
  CameraView view;
  view.focal_px = lens.focal_x_px;
  view.center_x_px = std::ceil(margin_px - view.focal_px * least.x());
  view.center_y_px = std::ceil(margin_px - view.focal_px * least.y());
  view.width_px =
      static_cast<int>(std::ceil(view.center_x_px + view.focal_px * most.x() + margin_px)) + 1;
  view.height_px =
      static_cast<int>(std::ceil(view.center_y_px + view.focal_px * most.y() + margin_px)) + 1;
  return view;
}

}  // namespace

std::vector<LensDrop> ScatterDrops(int count, const robot::Camera& camera, RandomStream& random) {
  std::vector<LensDrop> drops;
  const double unit_px = 0.01 * camera.height_px;
  for (int i = 0; i < count; ++i) {
    LensDrop drop;
    drop.middle_px = {random.Uniform(0.0, camera.width_px), random.Uniform(0.0, camera.height_px)};
    drop.radius_px = unit_px * random.Uniform(3.0, 9.0);
    drop.squeeze = random.Uniform(1.2, 2.2);
    drop.sag = random.Uniform(0.02, 0.2);
    drops.push_back(drop);
  }
  return drops;
}

LensMap::LensMap(const robot::Camera& camera, const std::vector<LensDrop>& drops)
    : lens_(robot::LensOf(camera)),
      ideal_(IdealView(camera, lens_)),
      base_(camera.height_px, camera.width_px, CV_32SC2),
      transmission_(base_.size(), CV_32F) {
  const Vector2d last(camera.width_px - 1.0, camera.height_px - 1.0);
  const Vector2d middle(ideal_.center_x_px, ideal_.center_y_px);
  for (int row = 0; row < base_.rows; ++row) {
    for (int col = 0; col < base_.cols; ++col) {
      const Bent bent = Bend(drops, Vector2d(col, row));
      const Vector2d from = bent.p_px.cwiseMax(Vector2d::Zero()).cwiseMin(last);
      const Vector2d p_px = middle + ideal_.focal_px * robot::Unproject(lens_, from);
      base_.at<cv::Vec2i>(row, col) = {static_cast<int>(std::lround(kUnit * p_px.x())),
                                       static_cast<int>(std::lround(kUnit * p_px.y()))};
      const Vector2d straight(col, row);
      transmission_.at<float>(row, col) =
          static_cast<float>(bent.transmission * Vignetting(camera, lens_, straight,
                                                            robot::Unproject(lens_, straight)));
    }
  }
}

Vector3d LensMap::Direction(const Vector2d& p_px) const {
  return robot::Unproject(lens_, p_px).homogeneous();
}

}  // namespace kantaro::sim
