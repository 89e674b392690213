#include "perception/wall_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "perception/wall_texture.hpp"

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
      (Swayed() << 0.008, 0.004, 0.040, 0.010, 0.080).finished();
  return prior;
}();
constexpr double kSmallStep = 0.02;   ///< of those deviations
constexpr double kCorrelated = 25.0;  ///< samples that say the same, or are wrong alike
constexpr double kOutlier = 2.2;      ///< deviations
constexpr double kLeastNoise = 0.01;  ///< of a texture's scatter
constexpr double kTold = 0.5;  ///< of what was in doubt at first: more is left by an even wall
constexpr std::size_t kFewest = 100;
constexpr double kFarthest_m = 1.1, kNearest_m = 0.22;
constexpr int kMargin_px = 2;
constexpr int kApart_px = 3;  ///< places that are compared, in a texture

/// From smooth to sharp. At first neighbours only are compared: what lies farther apart has moved
/// by more than the texture is wide.
struct Level {
  TextureScale scale;
  int passes;
  bool neighbours;
};
constexpr std::array<Level, 3> kLevels{
    {{{2, 1.4}, 12, true}, {{2, 1.0}, 10, false}, {{1, 1.0}, 10, false}}};

bool Inside(const robot::Camera& camera, const cv::Point2d& p) {
  return p.x >= kMargin_px && p.y >= kMargin_px && p.x < camera.width_px - kMargin_px - 1 &&
         p.y < camera.height_px - kMargin_px - 1;
}

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Which part of the wall: such as to the left, 0.5 m ahead.
int PatchOf(const WallPlace& place) {
  constexpr double kLength_m = 0.08;
  const auto& u = place.direction;
  const int side = std::abs(u.x()) > std::abs(u.y()) ? (u.x() > 0.0 ? 0 : 1) : u.y() > 0.0 ? 2 : 3;
  return 4 * static_cast<int>(place.distance_m / kLength_m) + side;
}

/// A point of the wall in one sight.
struct Speck {
  bool seen{};
  double value{};
  double along{}, around{};  ///< its slopes on the wall, per metre
  Vector3d p_C{Vector3d::Zero()};
};

WallMotion MotionOf(const Vector& x) {
  WallMotion motion{{x.head<2>(), x.segment<2>(2)}, x[4], x[5], {}, {}};
  for (int n = 0; n < kPowers; ++n) {
    const Swayed swayed = x.segment<kOfSway>(kFixed + n * kOfSway);
    motion.sway[n] = {{swayed.head<2>(), swayed.segment<2>(2)}, swayed[4]};
  }
  return motion;
}

/// How much farther from the wall than the last the farthest sight was taken.
double Behind(const std::vector<WallSight>& sights) {
  constexpr double kMost_m = 1.0;  // the grid would be too coarse for all the others
  double first_m = sights.back().travel_m;
  for (const WallSight& sight : sights) first_m = std::min(first_m, sight.travel_m);
  return std::min(kMost_m, sights.back().travel_m - first_m);
}

/// Where a sight was taken, for one set of parameters.
struct Stand {
  WallSighting sighting;
  double travel_m;  ///< odometry, from the last
  bool right;
};

/// Compares one level of all sights.
class Comparison {
 public:
  /// @param unrolled_by  parameters: those asked for later are close
  Comparison(const robot::Camera& camera, double radius_m, const std::vector<WallSight>& sights,
             const Level& level, const Vector& unrolled_by)
      : camera_(camera),
        radius_m_(radius_m),
        sights_(sights),
        grid_(camera.focal_px * radius_m, Behind(sights), kNearest_m, kFarthest_m, level.scale),
        places_(grid_.Places(kApart_px)),
        groups_(Groups(level.neighbours)),
        unrolled_(Stands(unrolled_by)) {
    for (std::size_t k = 0; k < sights.size(); ++k)
      textures_.push_back(grid_.Texture(sights[k].log_brightness, unrolled_[k].sighting));
  }

  /// All points in all sights, those of a point after each other.
  [[nodiscard]] std::vector<Speck> Look(const Vector& x) const;

  struct Equations {
    std::size_t samples{};
    std::vector<double> noise;  ///< of each place's patch
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
  [[nodiscard]] Vector Slope(const Stand& stand, const WallPlace& place, const Vector3d& p_C,
                             double along, double around) const;
  [[nodiscard]] std::vector<double> Noise(const std::vector<Speck>& specks,
                                          std::size_t* samples) const;

  /// Calls use(point, its specks in all sights, those compared as pairs of sight and weight, their
  /// mean).
  template <typename Use>
  void ForEachGroup(const std::vector<Speck>& specks, const std::vector<double>& noise,
                    const Use& use) const {
    std::vector<double> values;
    std::vector<std::pair<std::size_t, double>> weights;
    for (std::size_t i = 0; i < places_.size(); ++i) {
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
          const double scaled = (of_point[k].value - middle) / (kOutlier * noise[i]);
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
  WallGrid grid_;
  std::vector<WallPlace> places_;
  std::vector<Group> groups_;
  std::vector<Stand> unrolled_;
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
    const bool right = sight.right_m != 0.0;
    const PipeWall wall(camera_, radius_m_, SeenFrom(motion.PoseAt(travel_m), sight.right_m));
    stands.push_back({{wall, Eigen::Rotation2Dd(motion.SwayAt(travel_m).roll_rad),
                       -motion.travel_scale * travel_m - sight.right_m * wall.Along().x(),
                       right ? motion.turned_px : 0.0},
                      travel_m,
                      right});
  }
  return stands;
}

std::vector<Speck> Comparison::Look(const Vector& x) const {
  std::vector<Speck> specks(places_.size() * sights_.size());
  const std::vector<Stand> stands = Stands(x);
  for (std::size_t k = 0; k < stands.size(); ++k) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Vector3d p_C = stands[k].sighting.PointAt(places_[i]);
      if (p_C.z() <= 0.0) continue;
      const cv::Point2d pixel = stands[k].sighting.PixelOf(p_C);
      if (!Inside(camera_, pixel)) continue;
      const auto sample = grid_.Take(textures_[k], unrolled_[k].sighting.PlaceAt(pixel));
      if (!sample) continue;
      specks[i * sights_.size() + k] = {true, sample->value, sample->along,
                                        sample->around / radius_m_, p_C};
    }
  }
  return specks;
}

/// How a speck's brightness in its sight changes with the parameters, but for what is the same in
/// all sights: a shift of the whole wall along the axis.
Vector Comparison::Slope(const Stand& stand, const WallPlace& place, const Vector3d& p_C,
                         double along, double around) const {
  const Vector3d axis = stand.sighting.wall.Along(),
                 out = stand.sighting.wall.Outward(stand.sighting.turn * place.direction);
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

/// By patches of wall: what is none, such as a manhole that the camera sees into, differs at any
/// pose, and does so by itself.
std::vector<double> Comparison::Noise(const std::vector<Speck>& specks,
                                      std::size_t* samples) const {
  std::map<int, std::vector<double>> patches;
  std::vector<double> all;
  ForEachGroup(specks, std::vector<double>(places_.size(), HUGE_VAL),
               [&](std::size_t i, const Speck* seen, const auto& weights, double mean) {
                 for (const auto& [k, weight] : weights) {
                   all.push_back(std::abs(seen[k].value - mean));
                   patches[PatchOf(places_[i])].push_back(all.back());
                 }
               });
  *samples = all.size();
  const auto of = [](std::vector<double>& sizes) {
    return sizes.empty() ? kLeastNoise : std::max(kLeastNoise, 1.4826 * Median(sizes));
  };
  const double usual = of(all);
  std::map<int, double> noise;
  for (auto& [patch, sizes] : patches) noise[patch] = sizes.size() < kFewest ? usual : of(sizes);
  std::vector<double> of_places;
  for (const WallPlace& place : places_) {
    const auto found = noise.find(PatchOf(place));
    of_places.push_back(found == noise.end() ? usual : found->second);
  }
  return of_places;
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
                   slopes.push_back(Slope(stands[k], places_[i], seen[k].p_C, along, around));
                   mean_slope += weight * slopes.back();
                   sum += weight;
                 }
                 mean_slope /= sum;
                 const double scale = 1.0 / (equations.noise[i] * equations.noise[i] * kCorrelated);
                 for (std::size_t n = 0; n < weights.size(); ++n) {
                   const auto& [k, weight] = weights[n];
                   const Vector slope = slopes[n] - mean_slope;
                   equations.normal += scale * weight * slope * slope.transpose();
                   equations.right -= scale * weight * (seen[k].value - mean) * slope;
                 }
               });
  return equations;
}

double Comparison::Misfit(const std::vector<Speck>& specks, const Equations& at) const {
  double sum = 0.0;
  std::size_t samples = 0;
  ForEachGroup(specks, at.noise,
               [&](std::size_t i, const Speck* seen, const auto& weights, double mean) {
                 for (const auto& [k, weight] : weights) {
                   const double scaled = (seen[k].value - mean) / (kOutlier * at.noise[i]);
                   sum += scaled * scaled / (1.0 + scaled * scaled);
                 }
                 samples += weights.size();
               });
  if (samples < kFewest) return HUGE_VAL;
  const double count = static_cast<double>(at.samples) / static_cast<double>(samples);
  return kOutlier * kOutlier * count * sum / kCorrelated;
}

/// Levenberg and Marquardt: a step is taken if specks then differ less. Returns the covariance that
/// is left, nothing if there was not enough to compare.
std::optional<Matrix> Align(const Comparison& comparison, int passes, const Vector& first,
                            Vector* x) {
  const auto from_start = [&](const Vector& at) -> Vector {
    return (at - first).cwiseQuotient(kPrior);
  };
  std::vector<Speck> specks = comparison.Look(*x);
  Matrix normal;
  double damping = 0.0;
  for (int pass = 0; pass < passes; ++pass) {
    Comparison::Equations equations = comparison.Linearise(*x, specks);
    if (equations.samples < kFewest) return std::nullopt;
    normal = equations.normal;
    normal.diagonal() += kPrior.cwiseAbs2().cwiseInverse();
    equations.right -= from_start(*x).cwiseQuotient(kPrior);
    Matrix damped = normal;
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
  return normal.inverse();
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
  const WallMotion unmoved{start, 1.0, 0.0, {}, DoubtOfLight()};
  if (sights.size() < 2) return unmoved;
  Vector first = Vector::Zero();
  first.head<5>() << start.off_m, start.lean, 1.0;
  Vector x = first;
  std::optional<Matrix> covariance;
  for (const Level& level : kLevels) {
    covariance = Align({camera, pipe_radius_m, sights, level, x}, level.passes, first, &x);
    if (!covariance) return unmoved;
  }
  WallMotion motion = MotionOf(x);
  motion.doubt = {covariance->topLeftCorner<4, 4>()};
  const PoseDoubt first_doubt{kPrior.head<4>().cwiseAbs2().asDiagonal()};
  const auto ahead = [](const PoseDoubt& of) { return of.OfAxisAt(kFarthest_m).trace(); };
  return ahead(motion.doubt) < kTold * ahead(first_doubt) ? motion : unmoved;
}

}  // namespace kantaro::perception
