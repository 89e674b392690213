#include "perception/shaft_view.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSmooth_px = 1.0;
constexpr double kBeside_px[] = {2.0, 3.5};
constexpr int kMargin_px = 12;      ///< rectified pictures may be black at the rim
constexpr double kDarkFloor = 4.0;  ///< as LogBrightness adds
constexpr double kMostContrast = 0.5;
constexpr double kChannelRadius = 0.66;  ///< of the shaft's radius, if the channel turns
constexpr double kSeenThrough = 0.97;    ///< of the mouth's radius
constexpr int kPasses = 8;
constexpr double kOutlier = 0.15, kCorrelated = 30.0;  ///< of the light's fit
constexpr double kUsualSlope = 0.85, kSlopeSpread = 0.1;
constexpr double kInside = 0.84, kBeside = 1.08, kOutside = 1.4;  ///< of a ring's radius
constexpr double kLeastJump = -1.0, kMostJump = 2.0;
constexpr double kNear_m = 0.25, kFar_m = 0.7;  ///< where the wall's brightness is measured

/// Directions of the upper wall, to 110° from the crown.
std::vector<Vector2d> Upper() {
  std::vector<Vector2d> directions;
  for (int i = -22; i <= 22; ++i) {
    const double angle = i * 5.0 * std::numbers::pi / 180.0;
    directions.emplace_back(std::sin(angle), -std::cos(angle));
  }
  return directions;
}

/// Robust line through (log light, log brightness), first level and last slope.
Vector2d FitLight(const std::vector<Vector2d>& samples) {
  Vector2d line(0.0, kUsualSlope);
  bool started = false;
  for (int pass = 0; pass < kPasses; ++pass) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Vector2d right = Vector2d::Zero();
    for (const Vector2d& sample : samples) {
      const Vector2d row(1.0, sample.x());
      const double off = (sample.y() - line.dot(row)) / kOutlier;
      const double weight = started ? 1.0 / ((1.0 + off * off) * (1.0 + off * off)) : 1.0;
      normal += weight * row * row.transpose();
      right += weight * sample.y() * row;
    }
    const double prior = 1.0 / (kSlopeSpread * kSlopeSpread);
    normal(0, 0) += 1e-9;
    normal(1, 1) += prior * kOutlier * kOutlier * kCorrelated;
    right[1] += prior * kOutlier * kOutlier * kCorrelated * kUsualSlope;
    line = normal.ldlt().solve(right);
    started = true;
  }
  return line;
}

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double MeanOf(const std::vector<double>& values) {
  if (values.size() < 3) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double ShaftView::EndWall::All() const {
  return std::min(top, kMostContrast) + std::min(left, kMostContrast) +
         std::min(right, kMostContrast);
}

ShaftView::ShaftView(const robot::Camera& camera, std::vector<Vector3d> p_CLamp,
                     double pipe_radius_m, double shaft_diameter_m)
    : camera_(camera),
      p_CLamp_(std::move(p_CLamp)),
      pipe_radius_m_(pipe_radius_m),
      shaft_diameter_m_(shaft_diameter_m),
      ring_px_m_(camera.focal_px * pipe_radius_m) {}

double ShaftView::Look(const Sight& sight, const PipeWall& wall, double distance_m,
                       const Vector2d& direction) const {
  const cv::Point2d p = wall.Project(distance_m, direction);
  const auto x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
  if (x < kMargin_px || y < kMargin_px || x >= sight.smooth.cols - kMargin_px ||
      y >= sight.smooth.rows - kMargin_px)
    return NAN;
  return sight.smooth.at<float>(y, x);
}

double ShaftView::WallLight(const WallPose& pose, double distance_m,
                            const Vector2d& direction) const {
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  const cv::Point2d p = wall.Project(distance_m, direction);
  const Vector3d point = wall.PointAt(p), inward = wall.Inward(point);
  double light = 1e-6;
  for (const Vector3d& lamp : p_CLamp_) {
    const Vector3d to = lamp - point;
    const double range2 = to.squaredNorm();
    light += std::max(0.0, inward.dot(to)) * std::max(0.0, -to.z()) / (range2 * range2);
  }
  const double tangent2 = point.head<2>().squaredNorm() / (point.z() * point.z());
  return light / ((1.0 + tangent2) * (1.0 + tangent2));  // the lens passes less off its axis
}

double ShaftView::Expected(const Sight& sight, double distance_m, const Vector2d& direction) const {
  const double light = std::log(WallLight(sight.pose, distance_m, direction));
  return std::log(std::exp(sight.light.dot(Vector2d(1.0, light))) + kDarkFloor);
}

ShaftView::Sight ShaftView::Take(const cv::Mat& log_brightness, const WallPose& pose) const {
  Sight sight{{}, pose, {}};
  cv::GaussianBlur(log_brightness, sight.smooth, {}, kSmooth_px);
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  std::vector<Vector2d> samples;  // log light, log brightness
  for (double d = kNear_m; d < kFar_m; d *= 1.1) {
    for (const Vector2d& direction : Upper()) {
      const double seen = Look(sight, wall, d, direction);
      if (std::isnan(seen)) continue;
      samples.emplace_back(std::log(WallLight(pose, d, direction)),
                           std::log(std::max(0.1, std::exp(seen) - kDarkFloor)));
    }
  }
  sight.light = FitLight(samples);
  return sight;
}

ShaftView::EndWall ShaftView::EndWallAt(const Sight& sight, double distance_m) const {
  const double there_m = distance_m + shaft_diameter_m_;
  const double radius_px = ring_px_m_ / there_m;
  const PipeWall wall(camera_, pipe_radius_m_, sight.pose);
  const auto contrast = [&](const Vector2d& at, const Vector2d& outward) {
    double sum = 0.0;
    for (const double beside_px : kBeside_px) {
      const Vector2d by = beside_px / radius_px * outward;
      sum += Look(sight, wall, there_m, at - by) - Look(sight, wall, there_m, at + by);
    }
    return sum / std::size(kBeside_px);
  };
  EndWall end;
  double sums[3] = {}, counts[3] = {};
  const auto add = [&](int part, const Vector2d& at, const Vector2d& outward) {
    const double one = contrast(at, outward);
    if (std::isnan(one)) return;
    sums[part] += one;
    counts[part] += 1.0;
  };
  for (int i = -6; i <= 6; ++i) add(0, {0.14 * i, -1.0}, {0.0, -1.0});
  for (int i = 0; i < 6; ++i) {
    add(1, {-1.0, -0.25 - 0.12 * i}, {-1.0, 0.0});
    add(2, {1.0, -0.25 - 0.12 * i}, {1.0, 0.0});
  }
  end.top = counts[0] > 0.0 ? sums[0] / counts[0] : 0.0;
  end.left = counts[1] > 0.0 ? sums[1] / counts[1] : 0.0;
  end.right = counts[2] > 0.0 ? sums[2] / counts[2] : 0.0;
  return end;
}

ShaftView::Turn ShaftView::TurnAt(const Sight& sight, double distance_m) const {
  const PipeWall wall(camera_, pipe_radius_m_, sight.pose);
  const double shaft_m = shaft_diameter_m_ / 2.0, channel_m = kChannelRadius * shaft_m;
  const double straight_m = distance_m + shaft_m - channel_m;
  const auto edges = [&](double side) {
    std::vector<double> outer, inner;
    const auto add = [&](std::vector<double>& to, double there_m, const Vector2d& at,
                         const Vector2d& outward) {
      if (at.norm() * distance_m > kSeenThrough * there_m) return;  // hidden by the pipe's wall
      double edge = 0.0;
      for (const double beside_px : kBeside_px) {
        const Vector2d by = beside_px * there_m / ring_px_m_ * outward;
        edge += Look(sight, wall, there_m, at - by) - Look(sight, wall, there_m, at + by);
      }
      edge /= static_cast<double>(std::size(kBeside_px));
      if (!std::isnan(edge)) to.push_back(std::clamp(edge, -kMostContrast, kMostContrast));
    };
    for (double across = -0.9; across < 0.95; across += 0.15) {  // in pipe radii, to the inner side
      const double cosine =
          std::min(1.0, (channel_m - across * pipe_radius_m_) / (channel_m + pipe_radius_m_));
      const double arc_m = (channel_m + pipe_radius_m_) * std::sqrt(1.0 - cosine * cosine);
      add(outer, straight_m + arc_m, {side * across, -1.0}, {0.0, -1.0});
    }
    for (double down = -0.9; down < 0.15; down += 0.1)
      add(inner, straight_m, {side, down}, {side, 0.0});
    return Turn{MeanOf(outer), MeanOf(inner)};
  };
  Turn left = edges(-1.0), right = edges(1.0);
  // An end wall shows such an edge to either side.
  const double left_inner = left.inner;
  left.inner -= std::max(0.0, right.inner);
  right.inner -= std::max(0.0, left_inner);
  return left.outer + left.inner > right.outer + right.inner ? left : right;
}

double ShaftView::Jump(const Sight& sight, double distance_m) const {
  static const std::vector<Vector2d> kUpper = Upper();
  const PipeWall wall(camera_, pipe_radius_m_, sight.pose);
  const auto brighter = [&](double share) {  // than a wall, on a ring this much as wide
    std::vector<double> values;
    for (const Vector2d& direction : kUpper) {
      const double seen = Look(sight, wall, distance_m / share, direction);
      if (!std::isnan(seen))
        values.push_back(seen - Expected(sight, distance_m / share, direction));
    }
    return 3 * values.size() < kUpper.size() ? NAN : Median(values);
  };
  const double inside = brighter(kInside), beside = brighter(kBeside), outside = brighter(kOutside);
  // What the light's fit misses goes on.
  const double goes_on =
      (beside - outside) * std::log(kInside / kBeside) / std::log(kBeside / kOutside);
  const double jump = inside - beside - goes_on;
  return std::isnan(jump) ? 0.0 : std::clamp(jump, kLeastJump, kMostJump);
}

}  // namespace kantaro::perception
