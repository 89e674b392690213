#include "perception/wall_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kantaro::perception {
namespace {

constexpr int kParameters = 6;  // off x, off y, lean x, lean y, travel scale, turned
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

/// Of the pose where it starts, odometry's 1 % and the stereo calibration.
const Vector kPrior = (Vector() << 0.008, 0.008, 0.025, 0.025, 0.012, 0.6).finished();
const Vector kSmall = (Vector() << 2e-4, 2e-4, 5e-4, 5e-4, 1e-3, 0.1).finished();
constexpr double kCorrelated = 3.0;  ///< samples that say the same
constexpr double kOutlier = 6.0;     ///< deviations
constexpr double kStride = 1.6;      ///< gradients are too steep between blurred pictures
constexpr std::size_t kFewest = 100;
constexpr int kDirectionsTried = 96;
constexpr double kLowest = 0.75;  ///< of the wall below the axis, in radii: water lies under it
constexpr double kFarthest_m = 1.1, kNearest_m = 0.22;
constexpr double kColumn_px = 4.0;
constexpr int kMargin_px = 12;

struct Level {
  double smooth_px;
  int passes;
};
constexpr std::array<Level, 2> kLevels{{{5.0, 10}, {2.0, 8}}};

struct WallPoint {
  double distance_m;
  Eigen::Vector2d direction;
};

std::vector<WallPoint> PointsOnWall(double ring_px_m) {
  std::vector<WallPoint> points;
  for (double r = ring_px_m / kFarthest_m; r < ring_px_m / kNearest_m; r += kColumn_px) {
    for (int i = 0; i < kDirectionsTried; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kDirectionsTried;
      if (std::sin(a) < kLowest) points.push_back({ring_px_m / r, {std::cos(a), std::sin(a)}});
    }
  }
  return points;
}

/// Texture without the fall of light: less a mean over the neighbourhood, of such weights that a
/// quadratic leaves nothing. The light stays with the robot; what is left of it would too.
cv::Mat Texture(const cv::Mat& log_brightness, double smooth_px) {
  const auto box = [&](double width_px) {
    const int odd = 2 * static_cast<int>(width_px / 2.0) + 1;
    cv::Mat mean;
    cv::blur(log_brightness, mean, {odd, odd});
    return std::pair(mean, (odd * odd - 1) / 12.0);
  };
  cv::Mat fine;
  cv::GaussianBlur(log_brightness, fine, {}, smooth_px);
  const auto [near, near_spread] = box(12.0 * smooth_px);
  const auto [far, far_spread] = box(17.0 * smooth_px);
  const double far_weight = (smooth_px * smooth_px - near_spread) / (far_spread - near_spread);
  return fine - (1.0 - far_weight) * near - far_weight * far;
}

/// Where each sight shows a point of the wall, for one set of parameters.
class Projector {
 public:
  Projector(const robot::Camera& camera, double radius_m, const std::vector<WallSight>& sights,
            const Vector& x) {
    const WallPose pose{{x[0], x[1]}, {x[2], x[3]}};
    for (const WallSight& sight : sights) {
      walls_.emplace_back(camera, radius_m, SeenFrom(pose, sight.right_m));
      ahead_m_.push_back(x[4] * (sights.back().travel_m - sight.travel_m) -
                         sight.right_m * x[2] / std::hypot(1.0, x[2], x[3]));
      shift_px_.push_back(sight.right_m == 0.0 ? 0.0 : x[5]);
    }
  }
  [[nodiscard]] cv::Point2d At(std::size_t sight, const WallPoint& point) const {
    const cv::Point2d p =
        walls_[sight].Project(point.distance_m + ahead_m_[sight], point.direction);
    return {p.x + shift_px_[sight], p.y};
  }

 private:
  std::vector<PipeWall> walls_;
  std::vector<double> ahead_m_, shift_px_;
};

bool Inside(const cv::Mat& picture, const cv::Point2d& p) {
  return p.x >= kMargin_px && p.y >= kMargin_px && p.x < picture.cols - kMargin_px &&
         p.y < picture.rows - kMargin_px;
}

/// Value and gradient between pixels.
struct Taken {
  double value, dx, dy;
};
Taken Take(const cv::Mat& picture, const cv::Point2d& p) {
  const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
  const double fx = p.x - x, fy = p.y - y;
  const float *row = picture.ptr<float>(y) + x, *next = picture.ptr<float>(y + 1) + x;
  const double a = row[0], b = row[1], c = next[0], d = next[1];
  const double top = a + fx * (b - a), bottom = c + fx * (d - c);
  return {top + fy * (bottom - top), (b - a) * (1.0 - fy) + (d - c) * fy, bottom - top};
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// By how much brightness differs between the last sight and each other one, and how that changes
/// with the parameters.
struct Differences {
  std::vector<double> values;
  std::vector<Vector> slopes;
};

Differences Compare(const robot::Camera& camera, double radius_m,
                    const std::vector<WallSight>& sights, const std::vector<cv::Mat>& textures,
                    const std::vector<WallPoint>& points, const Vector& x) {
  const Projector here(camera, radius_m, sights, x);
  std::vector<Projector> moved;
  for (int i = 0; i < kParameters; ++i) {
    Vector other = x;
    other[i] += kSmall[i];
    moved.emplace_back(camera, radius_m, sights, other);
  }
  const auto slope = [&](std::size_t sight, const WallPoint& point, const cv::Point2d& at,
                         const Taken& taken) {
    Vector by;
    for (int i = 0; i < kParameters; ++i) {
      const cv::Point2d d = moved[i].At(sight, point) - at;
      by[i] = (taken.dx * d.x + taken.dy * d.y) / kSmall[i];
    }
    return by;
  };
  Differences differences;
  const std::size_t last = sights.size() - 1;
  for (const WallPoint& point : points) {
    const cv::Point2d at_last = here.At(last, point);
    if (!Inside(textures[last], at_last)) continue;
    const Taken seen_last = Take(textures[last], at_last);
    const Vector slope_last = slope(last, point, at_last, seen_last);
    for (std::size_t k = 0; k < last; ++k) {
      const cv::Point2d at = here.At(k, point);
      if (!Inside(textures[k], at)) continue;
      const Taken seen = Take(textures[k], at);
      differences.values.push_back(seen.value - seen_last.value);
      differences.slopes.push_back(slope(k, point, at, seen) - slope_last);
    }
  }
  return differences;
}

/// One step of Gauss and Newton; what differs more than others do weighs less.
Vector Step(const Differences& differences, const Vector& from_start) {
  std::vector<double> sizes;
  for (const double value : differences.values) sizes.push_back(std::abs(value));
  const double noise = std::max(1e-4, 1.4826 * Median(sizes));
  Matrix normal = Matrix::Zero();
  Vector right = Vector::Zero();
  for (std::size_t i = 0; i < differences.values.size(); ++i) {
    const double scaled = differences.values[i] / (kOutlier * noise);
    const double weight = std::pow(1.0 + scaled * scaled, -2.0) / (noise * noise * kCorrelated);
    const Vector& slope = differences.slopes[i];
    normal += weight * slope * slope.transpose();
    right -= weight * differences.values[i] * slope;
  }
  for (int i = 0; i < kParameters; ++i) {
    normal(i, i) += 1.0 / (kPrior[i] * kPrior[i]);
    right[i] -= from_start[i] / (kPrior[i] * kPrior[i]);
  }
  return kStride * normal.ldlt().solve(right);
}

}  // namespace

WallPose SeenFrom(const WallPose& pose, double right_m) {
  return {{pose.off_m.x() - right_m, pose.off_m.y()}, pose.lean};
}

WallMotion FollowWall(const robot::Camera& camera, double pipe_radius_m,
                      const std::vector<WallSight>& sights, const WallPose& start) {
  if (sights.size() < 2) return {start, 1.0, 0.0};
  const std::vector<WallPoint> points = PointsOnWall(camera.focal_px * pipe_radius_m);
  Vector first;
  first << start.off_m, start.lean, 1.0, 0.0;
  Vector x = first;
  for (const Level& level : kLevels) {
    std::vector<cv::Mat> textures;
    for (const WallSight& sight : sights)
      textures.push_back(Texture(sight.log_brightness, level.smooth_px));
    for (int pass = 0; pass < level.passes; ++pass) {
      const Differences differences = Compare(camera, pipe_radius_m, sights, textures, points, x);
      if (differences.values.size() < kFewest) return {start, 1.0, 0.0};
      x += Step(differences, x - first);
    }
  }
  return {{{x[0], x[1]}, {x[2], x[3]}}, x[4], x[5]};
}

}  // namespace kantaro::perception
