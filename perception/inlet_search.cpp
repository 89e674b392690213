#include "perception/inlet_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace kantaro::perception {
namespace {

constexpr double kFarthest_m = 1.0, kStep = 0.02, kDeviation = 0.01;
constexpr double kWeight = 3.0, kEdgeWeight = 20.0;
constexpr double kPoseError_m = 0.006;

}  // namespace

InletSearch::InletSearch(const robot::Camera& camera, const std::vector<Eigen::Vector3d>& p_CLamp,
                         const KnownSizes& sizes, bool left, double nearest_m)
    : camera_(camera),
      sizes_(sizes),
      left_(left),
      nearest_m_(nearest_m),
      light_(camera, p_CLamp, sizes.pipe_diameter_m / 2.0, sizes.pipe_diameter_m) {}

RangedLandmark InletSearch::Find(const std::vector<InletSight>& pictures) const {
  std::vector<Sight> sights;
  for (const InletSight& picture : pictures)
    sights.push_back({picture, light_.Take(picture.log_brightness, picture.pose)});
  Fit best;
  std::vector<TriedDistance> tried;
  double most = -HUGE_VAL;
  for (double d = nearest_m_; d <= kFarthest_m; d *= 1.0 + kStep) {
    TriedDistance here{d, -HUGE_VAL};
    for (double up = -0.25; up <= 0.65; up += 0.09) {
      const Fit fit{d, left_ ? std::numbers::pi + up : -up, Eigen::Vector2d::Zero(), 0.0};
      const double signs = Darkness(sights, fit) + kEdgeWeight * ScoreOf(sights, fit);
      here.log_odds = std::max(here.log_odds, kWeight * signs);
      if (signs <= most) continue;
      most = signs;
      best = fit;
    }
    tried.push_back(here);
  }
  best = Refine(sights, best);
  const double doubt_m = Likeliest(tried).deviation_m;
  return {best.distance_m, std::hypot(kDeviation * best.distance_m, doubt_m)};
}

InletSearch::Fit InletSearch::Refine(const std::vector<Sight>& sights, Fit best) const {
  const auto try_it = [&](const Fit& fit) {
    Fit tried_fit = fit;
    tried_fit.score = ScoreOf(sights, tried_fit);
    if (tried_fit.score > best.score) best = tried_fit;
  };
  best.score = ScoreOf(sights, best);
  double step = 1.0;
  for (int pass = 0; pass < 7; ++pass, step *= 0.6) {
    for (int repeat = 0; repeat < 2; ++repeat) {
      for (const double sign : {-1.0, 1.0}) {
        const double by = sign * step;
        Fit fit = best;
        fit.distance_m *= 1.0 + 0.02 * by;
        try_it(fit);
        // Along the line of sight: farther, and the wall as much farther off.
        fit = best;
        fit.distance_m *= 1.0 + 0.03 * by;
        const double out_m = 0.03 * by * sizes_.pipe_diameter_m / 2.0;
        fit.off_m += out_m * Eigen::Vector2d(std::cos(fit.angle_rad), std::sin(fit.angle_rad));
        try_it(fit);
        fit = best;
        fit.angle_rad += 0.05 * by;
        try_it(fit);
        fit = best;
        fit.off_m.x() += 0.004 * by;
        try_it(fit);
        fit = best;
        fit.off_m.y() += 0.004 * by;
        try_it(fit);
      }
    }
  }
  return best;
}

/// By how many deviations a mouth here would be darker than the wall about it, against what is
/// usual on the wall.
double InletSearch::Darkness(const std::vector<Sight>& sights, const Fit& fit) const {
  constexpr int kAngles = 16;
  constexpr double kInside[] = {0.3, 0.6, 0.85}, kOutside[] = {1.15, 1.35};
  constexpr double kSeen = 0.4, kLeast = 0.15;
  const double radius_m = sizes_.inlet_diameter_m / 2.0, pipe_m = sizes_.pipe_diameter_m / 2.0;
  struct Sums {
    double n{}, x{}, xx{};
    void Add(double value) {
      n += 1.0;
      x += value;
      xx += value * value;
    }
    [[nodiscard]] double Mean() const { return x / n; }
    [[nodiscard]] double Variance() const { return std::max(0.0, xx / n - Mean() * Mean()); }
  } inside, outside;
  for (const Sight& sight : sights) {
    const PipeWall wall(camera_, pipe_m, sight.picture.pose);
    const double there_m = fit.distance_m + sight.picture.ahead_m;
    const auto add = [&](Sums& to, double scale) {
      for (int i = 0; i < kAngles; ++i) {
        const double a = 2.0 * std::numbers::pi * i / kAngles;
        const double along_m = there_m + scale * radius_m * std::cos(a);
        if (along_m < 0.1) continue;
        const double angle =
            fit.angle_rad +
            std::asin(std::clamp(scale * radius_m * std::sin(a) / pipe_m, -0.99, 0.99));
        const double excess =
            light_.Excess(sight.light, wall, along_m, {std::cos(angle), std::sin(angle)});
        if (!std::isnan(excess)) to.Add(std::clamp(excess, -1.0, 1.0));
      }
    };
    for (const double scale : kInside) add(inside, scale);
    for (const double scale : kOutside) add(outside, scale);
  }
  const double all = static_cast<double>(kAngles * sights.size());
  if (inside.n < kSeen * all * std::size(kInside) || outside.n < kSeen * all * std::size(kOutside))
    return 0.0;
  const double spread = std::sqrt(kLeast * kLeast + (inside.Variance() + outside.Variance()) / 2.0);
  const double seen = std::pow((inside.n + outside.n) / (5.0 * all), 1.5);
  return seen * (outside.Mean() - inside.Mean()) / spread;
}

/// Mean of what the wall about an inlet's mouth is brighter than the mouth, in logarithms, over all
/// pictures; less what speaks against moving the axis.
double InletSearch::ScoreOf(const std::vector<Sight>& sights, const Fit& fit) const {
  constexpr int kPoints = 32;
  constexpr double kBeside = 0.14;  // of the mouth's radius
  const double radius_m = sizes_.inlet_diameter_m / 2.0, pipe_m = sizes_.pipe_diameter_m / 2.0;
  double sum = 0.0;
  int seen = 0;
  for (const Sight& sight : sights) {
    const double there_m = fit.distance_m + sight.picture.ahead_m;
    WallPose pose = sight.picture.pose;
    pose.off_m += fit.off_m;
    const PipeWall wall(camera_, pipe_m, pose);
    const auto look = [&](double scale, double a) -> std::optional<double> {
      const double along_m = there_m + scale * radius_m * std::cos(a);
      const double angle =
          fit.angle_rad +
          std::asin(std::clamp(scale * radius_m * std::sin(a) / pipe_m, -0.99, 0.99));
      if (along_m < 0.1) return {};
      const cv::Point2d p = wall.Project(along_m, {std::cos(angle), std::sin(angle)});
      const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
      if (x < 1 || y < 1 || x > camera_.width_px - 3 || y > camera_.height_px - 3) return {};
      const double fx = p.x - x, fy = p.y - y;
      const float* const row = sight.picture.log_brightness.ptr<float>(y);
      const float* const next = sight.picture.log_brightness.ptr<float>(y + 1);
      return (row[x] * (1.0 - fx) + row[x + 1] * fx) * (1.0 - fy) +
             (next[x] * (1.0 - fx) + next[x + 1] * fx) * fy;
    };
    for (int i = 0; i < kPoints; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kPoints;
      const auto outside = look(1.0 + kBeside, a), inside = look(1.0 - kBeside, a);
      if (!outside || !inside) continue;
      sum += std::clamp(*outside - *inside, -0.4, 0.4);
      ++seen;
    }
  }
  const double most = static_cast<double>(kPoints) * static_cast<double>(sights.size());
  if (seen < 0.35 * most) return 0.0;
  return sum / seen - 0.02 * fit.off_m.squaredNorm() / (kPoseError_m * kPoseError_m);
}

}  // namespace kantaro::perception
