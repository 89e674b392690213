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

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFixed = 6, kOfSway = 5, kPowers = std::tuple_size_v<decltype(WallMotion::sway)>;
/// Off x, off y, lean x, lean y, travel scale, turned; of each power off, lean and roll.
constexpr int kParameters = kFixed + kOfSway * kPowers;
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;
using Swayed = Eigen::Matrix<double, kOfSway, 1>;

/// Of the pose where it starts, odometry's 1 %, the stereo calibration, and how a robot sways on a
/// power of a metre.
const Vector kPrior = [] {
  Vector prior;
  prior.head<kFixed>() << 0.008, 0.008, 0.025, 0.025, 0.012, 0.6;
  prior.tail<kOfSway * kPowers>().reshaped(kOfSway, kPowers).colwise() =
      (Swayed() << 0.008, 0.004, 0.040, 0.015, 0.080).finished();
  return prior;
}();
constexpr double kSmallStep = 0.02;    ///< of those deviations
constexpr double kCorrelated = 100.0;  ///< samples that say the same, or are wrong alike
constexpr double kOutlier = 6.0;       ///< deviations
constexpr double kLeastNoise = 0.01;   ///< of a texture's scatter
constexpr std::size_t kFewest = 100;
constexpr double kLowest = 0.75;  ///< of the wall below the axis, in radii: water lies under it
constexpr double kFarthest_m = 1.1, kNearest_m = 0.22;
constexpr int kMargin_px = 2;
constexpr float kFlat = 1e-5F;  ///< variance of log brightness where there is no texture

/// From smooth to sharp. At first neighbours only are compared: what lies farther apart has moved
/// by more than the texture is wide.
struct Level {
  int shrink;         ///< pixels of a picture, to either side, in one of the texture's
  double smooth_px;   ///< of the texture's
  double between_px;  ///< rings of points, in the picture
  int directions;
  int passes;
  bool neighbours;
};
constexpr std::array<Level, 3> kLevels{
    {{4, 1.4, 8.0, 48, 12, true}, {4, 1.0, 6.0, 72, 10, false}, {2, 1.0, 4.0, 96, 10, false}}};

struct WallPoint {
  double distance_m;
  Vector2d direction;
};

std::vector<WallPoint> PointsOnWall(double ring_px_m, const Level& level) {
  std::vector<WallPoint> points;
  for (double r = ring_px_m / kFarthest_m; r < ring_px_m / kNearest_m; r += level.between_px) {
    for (int i = 0; i < level.directions; ++i) {
      const double a = 2.0 * std::numbers::pi * i / level.directions;
      if (std::sin(a) < kLowest) points.push_back({ring_px_m / r, {std::cos(a), std::sin(a)}});
    }
  }
  return points;
}

/// Texture without the fall of light, in deviations: less a mean over the neighbourhood, of such
/// weights that a quadratic leaves nothing. The light stays with the robot; what is left of it
/// would too. So would a manhole's edges, far stronger than any texture, if contrast counted as it
/// is.
cv::Mat Texture(const cv::Mat& log_brightness, const Level& level) {
  const cv::Size size = log_brightness.size() / level.shrink;
  cv::Mat small, texture;
  cv::resize(log_brightness({{0, 0}, size * level.shrink}), small, size, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(small, texture, {}, level.smooth_px);
  const auto odd = [&](double sizes) {
    return 2 * static_cast<int>(sizes * level.smooth_px / 2.0) + 1;
  };
  const auto mean = [](const cv::Mat& of, int width_px) {
    cv::Mat result;
    cv::blur(of, result, {width_px, width_px});
    return result;
  };
  const auto spread = [](int width_px) { return (width_px * width_px - 1) / 12.0; };
  const int near = odd(12.0), far = odd(17.0);
  const double far_weight =
      (level.smooth_px * level.smooth_px - spread(near)) / (spread(far) - spread(near));
  texture -= (1.0 - far_weight) * mean(small, near) + far_weight * mean(small, far);
  cv::Mat scatter;
  cv::sqrt(mean(texture.mul(texture), near) + kFlat, scatter);
  return texture / scatter;
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

bool Inside(const cv::Mat& picture, const cv::Point2d& p) {
  return p.x >= kMargin_px && p.y >= kMargin_px && p.x < picture.cols - kMargin_px - 1 &&
         p.y < picture.rows - kMargin_px - 1;
}

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// A point of the wall in one sight.
struct Speck {
  bool seen{};
  double value{};
  double along{}, around{};  ///< its slopes on the wall, per metre
  Vector3d p_C{Vector3d::Zero()};
};

WallMotion MotionOf(const Vector& x) {
  WallMotion motion{{x.head<2>(), x.segment<2>(2)}, x[4], x[5], {}};
  for (int n = 0; n < kPowers; ++n) {
    const Swayed swayed = x.segment<kOfSway>(kFixed + n * kOfSway);
    motion.sway[n] = {{swayed.head<2>(), swayed.segment<2>(2)}, swayed[4]};
  }
  return motion;
}

/// Where a sight was taken, for one set of parameters.
struct Stand {
  PipeWall wall;
  Eigen::Rotation2Dd turn;  ///< of the wall in the picture
  double ahead_m;           ///< how much farther from it the wall is than from the last
  double travel_m;          ///< odometry, from the last: not above 0
  bool right;
};

/// Compares one level of all sights.
class Comparison {
 public:
  Comparison(const robot::Camera& camera, double radius_m, const std::vector<WallSight>& sights,
             const Level& level)
      : camera_(camera),
        radius_m_(radius_m),
        sights_(sights),
        shrink_(level.shrink),
        points_(PointsOnWall(camera.focal_px * radius_m, level)),
        groups_(Groups(level.neighbours)) {
    for (const WallSight& sight : sights) textures_.push_back(Texture(sight.log_brightness, level));
  }

  /// All points in all sights, those of a point after each other.
  [[nodiscard]] std::vector<Speck> Look(const Vector& x) const;

  struct Equations {
    std::size_t samples{};
    double noise{};
    Matrix normal{Matrix::Zero()};
    Vector right{Vector::Zero()};
  };
  /// Linearised, what differs much weighed down. A speck's slope is the mean of what its sights
  /// show: noise in each one's would pass for texture, and steps would be too short.
  [[nodiscard]] Equations Linearise(const Vector& x, const std::vector<Speck>& specks) const;

  /// By how much specks differ, of the size of as many samples, per squared deviation.
  [[nodiscard]] double Misfit(const std::vector<Speck>& specks, const Equations& at) const;

 private:
  using Group = std::vector<std::size_t>;  ///< sights that are compared with their mean

  [[nodiscard]] std::vector<Group> Groups(bool neighbours) const;
  [[nodiscard]] std::vector<Stand> Stands(const Vector& x) const;
  [[nodiscard]] Vector Slope(const Stand& stand, const WallPoint& point, const Vector3d& p_C,
                             double along, double around) const;
  [[nodiscard]] double Noise(const std::vector<Speck>& specks, std::size_t* samples) const;

  /// Calls use(point, its specks in all sights, those compared as pairs of sight and weight, their
  /// mean).
  template <typename Use>
  void ForEachGroup(const std::vector<Speck>& specks, double noise, const Use& use) const {
    std::vector<double> values;
    std::vector<std::pair<std::size_t, double>> weights;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Speck* of_point = &specks[i * sights_.size()];
      for (const Group& group : groups_) {
        values.clear();
        for (const std::size_t k : group)
          if (of_point[k].seen) values.push_back(of_point[k].value);
        if (values.size() < 2) continue;
        const double middle = Median(values);
        weights.clear();
        double sum = 0.0, mean = 0.0;
        for (const std::size_t k : group) {
          if (!of_point[k].seen) continue;
          const double scaled = (of_point[k].value - middle) / (kOutlier * noise);
          const double root = 1.0 + scaled * scaled;
          weights.emplace_back(k, 1.0 / (root * root));
          sum += weights.back().second;
          mean += weights.back().second * of_point[k].value;
        }
        use(i, of_point, weights, mean / sum);
      }
    }
  }

  const robot::Camera& camera_;
  double radius_m_;
  const std::vector<WallSight>& sights_;
  double shrink_;
  std::vector<WallPoint> points_;
  std::vector<Group> groups_;
  std::vector<cv::Mat> textures_;
};

/// Either all, or one by one with the next of the same camera and the other camera's.
std::vector<Comparison::Group> Comparison::Groups(bool neighbours) const {
  std::vector<Group> groups(neighbours ? 0 : 1);
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    if (!neighbours) groups[0].push_back(i);
    bool next_found = false;
    for (std::size_t j = i + 1; neighbours && j < sights_.size(); ++j) {
      const bool same_camera = sights_[i].right_m == sights_[j].right_m;
      if (same_camera ? !next_found : sights_[i].travel_m == sights_[j].travel_m)
        groups.push_back({i, j});
      next_found = next_found || same_camera;
    }
  }
  return groups;
}

std::vector<Stand> Comparison::Stands(const Vector& x) const {
  const WallMotion motion = MotionOf(x);
  std::vector<Stand> stands;
  for (const WallSight& sight : sights_) {
    const double travel_m = sight.travel_m - sights_.back().travel_m;
    const PipeWall wall(camera_, radius_m_, SeenFrom(motion.PoseAt(travel_m), sight.right_m));
    stands.push_back({wall, Eigen::Rotation2Dd(motion.SwayAt(travel_m).roll_rad),
                      -motion.travel_scale * travel_m - sight.right_m * wall.Along().x(), travel_m,
                      sight.right_m != 0.0});
  }
  return stands;
}

std::vector<Speck> Comparison::Look(const Vector& x) const {
  std::vector<Speck> specks(points_.size() * sights_.size());
  const std::vector<Stand> stands = Stands(x);
  for (std::size_t k = 0; k < stands.size(); ++k) {
    const auto& [wall, turn, ahead_m, travel_m, right] = stands[k];
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const WallPoint point{points_[i].distance_m, turn * points_[i].direction};
      const Vector3d p_C = wall.PointAt(point.distance_m + ahead_m, point.direction);
      if (p_C.z() <= 0.0) continue;
      const double px_m = camera_.focal_px / p_C.z();
      const double shift_px = 0.5 + (right ? x[5] : 0.0);
      const cv::Point2d at((camera_.center_x_px + px_m * p_C.x() + shift_px) / shrink_ - 0.5,
                           (camera_.center_y_px + px_m * p_C.y() + 0.5) / shrink_ - 0.5);
      if (!Inside(textures_[k], at)) continue;
      const Taken taken = Take(textures_[k], at);
      const Vector3d slope_C =
          px_m / shrink_ *
          Vector3d(taken.dx, taken.dy, -(taken.dx * p_C.x() + taken.dy * p_C.y()) / p_C.z());
      specks[i * sights_.size() + k] = {
          true, taken.value, slope_C.dot(wall.Along()),
          slope_C.dot(wall.Along().cross(wall.Outward(point.direction))), p_C};
    }
  }
  return specks;
}

/// How a speck's brightness in its sight changes with the parameters, but for what is the same in
/// all sights: a shift of the whole wall along the axis.
Vector Comparison::Slope(const Stand& stand, const WallPoint& point, const Vector3d& p_C,
                         double along, double around) const {
  const Vector3d axis = stand.wall.Along(), out = stand.wall.Outward(stand.turn * point.direction);
  const Vector3d side = axis.cross(out);
  // Nothing changes along the ray.
  const double outwards = -(along * p_C.dot(axis) + around * p_C.dot(side)) / p_C.dot(out);
  const Vector3d across = around * side + outwards * out, from_axis = radius_m_ * out;
  Swayed swayed;  // off, lean and roll
  swayed << across.head<2>(),
      (p_C.z() - from_axis.z()) * across.head<2>() - along * axis.z() * from_axis.head<2>(),
      around * radius_m_;
  Vector slope;
  slope.head<kFixed>() << swayed.head<4>(), -stand.travel_m * along,
      stand.right ? (along * axis.x() + across.x()) * p_C.z() / camera_.focal_px : 0.0;
  double power = 1.0;
  for (int n = 0; n < kPowers; ++n)
    slope.segment<kOfSway>(kFixed + n * kOfSway) = (power *= stand.travel_m) * swayed;
  return slope;
}

double Comparison::Noise(const std::vector<Speck>& specks, std::size_t* samples) const {
  std::vector<double> sizes;
  ForEachGroup(specks, HUGE_VAL,
               [&](std::size_t, const Speck* seen, const auto& weights, double mean) {
                 for (const auto& [k, weight] : weights)
                   sizes.push_back(std::abs(seen[k].value - mean));
               });
  *samples = sizes.size();
  return sizes.empty() ? kLeastNoise : std::max(kLeastNoise, 1.4826 * Median(sizes));
}

Comparison::Equations Comparison::Linearise(const Vector& x,
                                            const std::vector<Speck>& specks) const {
  Equations equations;
  equations.noise = Noise(specks, &equations.samples);
  const std::vector<Stand> stands = Stands(x);
  std::vector<Vector> slopes;
  ForEachGroup(specks, equations.noise,
               [&](std::size_t i, const Speck* seen, const auto& weights, double mean) {
                 double along = 0.0, around = 0.0;
                 for (const auto& [k, weight] : weights) {
                   along += seen[k].along / static_cast<double>(weights.size());
                   around += seen[k].around / static_cast<double>(weights.size());
                 }
                 slopes.clear();
                 Vector mean_slope = Vector::Zero();
                 double sum = 0.0;
                 for (const auto& [k, weight] : weights) {
                   slopes.push_back(Slope(stands[k], points_[i], seen[k].p_C, along, around));
                   mean_slope += weight * slopes.back();
                   sum += weight;
                 }
                 mean_slope /= sum;
                 for (std::size_t n = 0; n < weights.size(); ++n) {
                   const auto& [k, weight] = weights[n];
                   const Vector slope = slopes[n] - mean_slope;
                   equations.normal += weight * slope * slope.transpose();
                   equations.right -= weight * (seen[k].value - mean) * slope;
                 }
               });
  const double scale = 1.0 / (equations.noise * equations.noise * kCorrelated);
  equations.normal *= scale;
  equations.right *= scale;
  return equations;
}

double Comparison::Misfit(const std::vector<Speck>& specks, const Equations& at) const {
  double sum = 0.0;
  std::size_t samples = 0;
  ForEachGroup(specks, at.noise,
               [&](std::size_t, const Speck* seen, const auto& weights, double mean) {
                 for (const auto& [k, weight] : weights) {
                   const double scaled = (seen[k].value - mean) / (kOutlier * at.noise);
                   sum += scaled * scaled / (1.0 + scaled * scaled);
                 }
                 samples += weights.size();
               });
  if (samples < kFewest) return HUGE_VAL;
  const double count = static_cast<double>(at.samples) / static_cast<double>(samples);
  return kOutlier * kOutlier * count * sum / kCorrelated;
}

/// Levenberg and Marquardt: a step is taken if specks then differ less. Returns whether there was
/// enough to compare.
bool Align(const Comparison& comparison, int passes, const Vector& first, Vector* x) {
  const auto from_start = [&](const Vector& at) -> Vector {
    return (at - first).cwiseQuotient(kPrior);
  };
  std::vector<Speck> specks = comparison.Look(*x);
  double damping = 0.0;
  for (int pass = 0; pass < passes; ++pass) {
    Comparison::Equations equations = comparison.Linearise(*x, specks);
    if (equations.samples < kFewest) return false;
    equations.normal.diagonal() += kPrior.cwiseAbs2().cwiseInverse();
    equations.right -= from_start(*x).cwiseQuotient(kPrior);
    Matrix damped = equations.normal;
    damped.diagonal() *= 1.0 + damping;
    const Vector step = damped.ldlt().solve(equations.right);
    const Vector tried = *x + step;
    std::vector<Speck> then = comparison.Look(tried);
    const auto cost = [&](const std::vector<Speck>& seen, const Vector& at) {
      return comparison.Misfit(seen, equations) + from_start(at).squaredNorm();
    };
    const bool better = cost(then, tried) < cost(specks, *x);
    if (better) {
      *x = tried;
      specks = std::move(then);
    }
    if (step.cwiseQuotient(kPrior).cwiseAbs().maxCoeff() < kSmallStep) break;
    damping = !better ? std::max(0.1, 5.0 * damping) : damping < 0.1 ? 0.0 : damping / 5.0;
  }
  return true;
}

}  // namespace

WallSway WallMotion::SwayAt(double travel_m) const {
  WallSway changed;
  double power = 1.0;
  for (const WallSway& one : sway) {
    power *= travel_m;
    changed.pose.off_m += power * one.pose.off_m;
    changed.pose.lean += power * one.pose.lean;
    changed.roll_rad += power * one.roll_rad;
  }
  return changed;
}

WallPose WallMotion::PoseAt(double travel_m) const {
  const WallPose changed = SwayAt(travel_m).pose;
  return {pose.off_m + changed.off_m, pose.lean + changed.lean};
}

WallPose SeenFrom(const WallPose& pose, double right_m) {
  return {{pose.off_m.x() - right_m, pose.off_m.y()}, pose.lean};
}

WallMotion FollowWall(const robot::Camera& camera, double pipe_radius_m,
                      const std::vector<WallSight>& sights, const WallPose& start) {
  const WallMotion unmoved{start, 1.0, 0.0, {}};
  if (sights.size() < 2) return unmoved;
  Vector first = Vector::Zero();
  first.head<5>() << start.off_m, start.lean, 1.0;
  Vector x = first;
  for (const Level& level : kLevels) {
    const Comparison comparison(camera, pipe_radius_m, sights, level);
    if (!Align(comparison, level.passes, first, &x)) return unmoved;
  }
  return MotionOf(x);
}

}  // namespace kantaro::perception
