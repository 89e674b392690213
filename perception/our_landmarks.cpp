#include "perception/our_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/mouth_search.hpp"

namespace kantaro::perception {
namespace {

constexpr std::size_t kPictures = 3;  ///< kept, of each camera
constexpr double kStep = 0.003;       ///< of the distances tried, as a share

/// How much each sign says [log odds]: logistic regression among all distances, on training views.
constexpr double kJointWeight = 0.93;

constexpr double kFarthestInlet_m = 1.0, kInletStep = 0.02, kInletDeviation = 0.01;
constexpr double kInletWeight = 3.0, kEdgeWeight = 20.0;
constexpr double kPoseError_m = 0.006;
constexpr double kJointPixels = 0.5;  ///< deviation of a ring's radius
constexpr double kWidening_m = 0.5;   ///< a shaft is wider than its pipe by so much (thesis 5.2)

double CameraHeight(double pipe_diameter_m) {
  // Where the robot stands on its wheels (docs/robot.md): the wheels' treads are leaned outwards.
  return 0.56 * (0.300 - pipe_diameter_m);
}

}  // namespace

LandmarkTracker::LandmarkTracker(const robot::Description& description, const robot::Camera& camera,
                                 double baseline_m, const LandmarkParameters& parameters,
                                 LandmarkKind kind, const KnownSizes& sizes)
    : camera_(camera),
      parameters_(parameters),
      kind_(kind),
      sizes_(sizes),
      baseline_m_(baseline_m),
      camera_height_m_(CameraHeight(sizes.pipe_diameter_m)),
      lamps_(LampsBefore(description, camera)) {
  const double radius_m = sizes.pipe_diameter_m / 2.0;
  if (ClassOf(kind) != LandmarkClass::kInlet)
    scan_.emplace(camera, radius_m, parameters.near_m, parameters.far_m + 0.3);
  if (kind == LandmarkKind::kJoint) return;
  shaft_.emplace(
      camera, lamps_, radius_m,
      sizes.shaft_diameter_m > 0.0 ? sizes.shaft_diameter_m : sizes.pipe_diameter_m + kWidening_m);
}

std::optional<RangedLandmark> LandmarkTracker::Update(const cv::Mat& brightness,
                                                      const cv::Mat& right, double travel_m) {
  const double radius_m = sizes_.pipe_diameter_m / 2.0;
  if (sights_.empty())
    motion_.pose = FindWallPose(brightness, camera_, lamps_, radius_m, camera_height_m_);
  if (!right.empty()) sights_.push_back({LogBrightness(right), travel_m, baseline_m_, {}, {}, {}});
  sights_.push_back({LogBrightness(brightness), travel_m, 0.0, {}, {}, {}});
  const std::size_t most = kPictures * (right.empty() ? 1 : 2);
  if (sights_.size() > most)
    sights_.erase(sights_.begin(), sights_.end() - static_cast<std::ptrdiff_t>(most));
  std::vector<WallSight> passing;
  for (const Sight& sight : sights_)
    passing.push_back({sight.log_brightness, sight.travel_m, sight.right_m});
  motion_ = FollowWall(camera_, radius_m, passing, motion_.pose);
  Scan();
  if (!scan_) return FindInlet();
  return shaft_ ? FindMouth() : FindJoint();
}

void LandmarkTracker::Scan() {
  for (Sight& sight : sights_) {
    sight.pose = SeenFrom(motion_.pose, sight.right_m);
    if (sight.right_m != 0.0) sight.pose.lean.x() += motion_.turned_px / camera_.focal_px;
    if (scan_) sight.rings = scan_->Scan(sight.log_brightness, sight.pose, shaft_.has_value());
    if (shaft_) sight.shaft = shaft_->Take(sight.log_brightness, sight.pose);
  }
}

/// How far what is at a distance from the last left picture is from where another one was taken.
double LandmarkTracker::Ahead(const Sight& sight, double distance_m) const {
  return distance_m + motion_.travel_scale * (sights_.back().travel_m - sight.travel_m) -
         sight.right_m * motion_.pose.lean.x();
}

/// What all pictures together say of a ring at this distance from the last one.
double LandmarkTracker::SumAt(double distance_m, PickScores pick) const {
  double sum = 0.0;
  int seen = 0;
  for (const Sight& sight : sights_) {
    const double score = sight.rings.At(pick(sight.rings), Ahead(sight, distance_m));
    if (score < RingScan::kUnseen / 2.0) continue;
    sum += score;
    ++seen;
  }
  return seen == 0 ? RingScan::kUnseen : sum / std::sqrt(seen);
}

/// With what a ring's radius says that is off by so many pixels in the last picture.
RangedLandmark LandmarkTracker::Doubted(const RangedLandmark& found, double pixels) const {
  const double off_m = pixels * found.distance_m * found.distance_m /
                       (camera_.focal_px * sizes_.pipe_diameter_m / 2.0);
  return {found.distance_m, std::hypot(found.deviation_m, off_m)};
}

std::optional<RangedLandmark> LandmarkTracker::FindJoint() const {
  constexpr PickScores kBright = [](const RingScan::Scanned& s) -> const auto& { return s.bright; };
  constexpr PickScores kDark = [](const RingScan::Scanned& s) -> const auto& { return s.dark; };
  std::vector<TriedDistance> tried;
  for (double d = parameters_.near_m; d <= parameters_.far_m; d *= 1.0 + kStep)
    tried.push_back({d, kJointWeight * std::max(SumAt(d, kBright), SumAt(d, kDark))});
  RangedLandmark found = Likeliest(tried);
  const bool bright = SumAt(found.distance_m, kBright) > SumAt(found.distance_m, kDark);
  found.distance_m = RefineJoint(found.distance_m, bright ? kBright : kDark);
  return Doubted(found, kJointPixels);
}

double LandmarkTracker::RefineJoint(double distance_m, PickScores pick) const {
  double weights = 0.0, sum = 0.0;
  for (const Sight& sight : sights_) {
    const double ahead_m = Ahead(sight, distance_m) - distance_m;
    const RingScan::Scores& scores = pick(sight.rings);
    const auto middle = static_cast<int>(std::lround(sight.rings.ColumnOf(distance_m + ahead_m)));
    if (middle < 2 || middle + 2 >= static_cast<int>(scores.significance.size())) continue;
    const auto first = scores.significance.begin() + middle - 2;
    const auto best =
        static_cast<int>(std::max_element(first, first + 5) - scores.significance.begin());
    if (scores.significance[best] < 1.0) continue;
    const double there_m =
        sight.rings.DistanceOf(RingScan::Refine(sight.rings, scores, best).column);
    const double weight = std::min(scores.significance[best], 10.0) / std::pow(there_m, 4.0);
    weights += weight;
    sum += weight * (there_m - ahead_m);
  }
  return weights > 0.0 ? sum / weights : distance_m;
}

std::optional<RangedLandmark> LandmarkTracker::FindMouth() const {
  std::vector<MouthSight> sights;
  for (const Sight& sight : sights_)
    sights.push_back({sight.rings, sight.shaft, Ahead(sight, 0.0)});
  return perception::FindMouth(*shaft_, sights, parameters_.near_m, parameters_.far_m,
                               camera_.focal_px * sizes_.pipe_diameter_m / 2.0);
}

std::optional<RangedLandmark> LandmarkTracker::FindInlet() const {
  const bool left = kind_ == LandmarkKind::kInletLeft;
  InletFit best;
  std::vector<TriedDistance> tried;
  double most = -HUGE_VAL;
  for (double d = parameters_.near_m; d <= kFarthestInlet_m; d *= 1.0 + kInletStep) {
    TriedDistance here{d, -HUGE_VAL};
    for (double up = -0.25; up <= 0.65; up += 0.09) {
      const InletFit fit{d, left ? std::numbers::pi + up : -up, Eigen::Vector2d::Zero(), 0.0};
      const double signs = Darkness(fit) + kEdgeWeight * ScoreOf(fit);
      here.log_odds = std::max(here.log_odds, kInletWeight * signs);
      if (signs <= most) continue;
      most = signs;
      best = fit;
    }
    tried.push_back(here);
  }
  const auto try_it = [&](const InletFit& fit) {
    InletFit tried_fit = fit;
    tried_fit.score = ScoreOf(tried_fit);
    if (tried_fit.score > best.score) best = tried_fit;
  };
  best.score = ScoreOf(best);
  double step = 1.0;
  for (int pass = 0; pass < 7; ++pass, step *= 0.6) {
    for (int repeat = 0; repeat < 2; ++repeat) {
      for (const double sign : {-1.0, 1.0}) {
        const double by = sign * step;
        InletFit fit = best;
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
  const double doubt_m = Likeliest(tried).deviation_m;
  return RangedLandmark{best.distance_m, std::hypot(kInletDeviation * best.distance_m, doubt_m)};
}

/// By how many deviations a mouth here would be darker than the wall about it, against what is
/// usual on the wall.
double LandmarkTracker::Darkness(const InletFit& fit) const {
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
  for (const Sight& sight : sights_) {
    const PipeWall wall(camera_, pipe_m, sight.pose);
    const double there_m = Ahead(sight, fit.distance_m);
    const auto add = [&](Sums& to, double scale) {
      for (int i = 0; i < kAngles; ++i) {
        const double a = 2.0 * std::numbers::pi * i / kAngles;
        const double along_m = there_m + scale * radius_m * std::cos(a);
        if (along_m < 0.1) continue;
        const double angle =
            fit.angle_rad +
            std::asin(std::clamp(scale * radius_m * std::sin(a) / pipe_m, -0.99, 0.99));
        const double excess =
            shaft_->Excess(sight.shaft, wall, along_m, {std::cos(angle), std::sin(angle)});
        if (!std::isnan(excess)) to.Add(std::clamp(excess, -1.0, 1.0));
      }
    };
    for (const double scale : kInside) add(inside, scale);
    for (const double scale : kOutside) add(outside, scale);
  }
  const double all = static_cast<double>(kAngles * sights_.size());
  if (inside.n < kSeen * all * std::size(kInside) || outside.n < kSeen * all * std::size(kOutside))
    return 0.0;
  const double spread = std::sqrt(kLeast * kLeast + (inside.Variance() + outside.Variance()) / 2.0);
  const double seen = std::pow((inside.n + outside.n) / (5.0 * all), 1.5);
  return seen * (outside.Mean() - inside.Mean()) / spread;
}

/// Mean of what the wall about an inlet's mouth is brighter than the mouth, in logarithms, over all
/// pictures; less what speaks against moving the axis.
double LandmarkTracker::ScoreOf(const InletFit& fit) const {
  constexpr int kPoints = 32;
  constexpr double kBeside = 0.14;  // of the mouth's radius
  const double radius_m = sizes_.inlet_diameter_m / 2.0, pipe_m = sizes_.pipe_diameter_m / 2.0;
  double sum = 0.0;
  int seen = 0;
  for (const Sight& sight : sights_) {
    const double there_m = Ahead(sight, fit.distance_m);
    WallPose pose = sight.pose;
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
      const float* const row = sight.log_brightness.ptr<float>(y);
      const float* const next = sight.log_brightness.ptr<float>(y + 1);
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
  const double most = static_cast<double>(kPoints) * static_cast<double>(sights_.size());
  if (seen < 0.35 * most) return 0.0;
  return sum / seen - 0.02 * fit.off_m.squaredNorm() / (kPoseError_m * kPoseError_m);
}

}  // namespace kantaro::perception
