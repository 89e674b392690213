#include "perception/our_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kantaro::perception {
namespace {

constexpr std::size_t kSights = 4;  ///< kept
constexpr double kStep = 0.004;     ///< of the distances tried, as a share
constexpr double kLeast = 2.0;      ///< significance
constexpr double kApart = 0.15;
constexpr double kSurelyStep = 0.35, kPerhapsStep = 0.6;
constexpr int kEcho_px = 7;
constexpr double kNearestShare = 0.7;  ///< of the best score makes a nearer ring the landmark
constexpr double kFarthestInlet_m = 1.0, kLeastInlet = 0.06, kInletDeviation = 0.01;
constexpr double kPoseError_m = 0.006;
constexpr double kPixel = 0.6;       ///< deviation of a ring's radius
constexpr double kOdometry = 0.015;  ///< of the travel between two pictures

double CameraHeight(double pipe_diameter_m) {
  // Where the robot stands on its wheels (docs/robot.md): the wheels' treads are leaned outwards.
  return 0.56 * (0.300 - pipe_diameter_m);
}

/// The column of the largest score within `reach` of a place, if any is seen there.
std::optional<int> BestColumn(const std::vector<double>& scores, double column, int reach) {
  const auto middle = static_cast<int>(std::lround(column));
  std::optional<int> best;
  for (int k = std::max(0, middle - reach);
       k <= std::min(static_cast<int>(scores.size()) - 1, middle + reach); ++k) {
    if (scores[k] > 0.0 && (!best || scores[k] > scores[*best])) best = k;
  }
  return best;
}

struct Peak {
  double distance_m{}, score{};
};

/// Maxima that no stronger one is near; the strongest first.
std::vector<Peak> Peaks(const std::vector<std::pair<double, double>>& scores) {
  std::vector<Peak> all, peaks;
  for (const auto& [distance_m, score] : scores) all.push_back({distance_m, score});
  std::stable_sort(all.begin(), all.end(),
                   [](const Peak& a, const Peak& b) { return a.score > b.score; });
  for (const Peak& one : all) {
    if (one.score < 0.5 * all.front().score) break;
    const bool near_stronger = std::any_of(peaks.begin(), peaks.end(), [&](const Peak& other) {
      return std::abs(one.distance_m / other.distance_m - 1.0) < kApart;
    });
    if (!near_stronger) peaks.push_back(one);
  }
  return peaks;
}

}  // namespace

LandmarkTracker::LandmarkTracker(const robot::Description& description, const robot::Camera& camera,
                                 const LandmarkParameters& parameters, LandmarkKind kind,
                                 const KnownSizes& sizes)
    : camera_(camera),
      parameters_(parameters),
      kind_(kind),
      sizes_(sizes),
      camera_height_m_(CameraHeight(sizes.pipe_diameter_m)),
      lamps_(LampsBefore(description, camera)) {
  if (ClassOf(kind) != LandmarkClass::kInlet)
    scan_.emplace(camera, sizes.pipe_diameter_m / 2.0, parameters.near_m, parameters.far_m + 0.3);
}

std::optional<RangedLandmark> LandmarkTracker::Update(const cv::Mat& brightness, double travel_m) {
  pose_ = FindWallPose(brightness, camera_, lamps_, sizes_.pipe_diameter_m / 2.0, camera_height_m_);
  Sight sight{travel_m, pose_, {}, {}};
  if (scan_) {
    sight.rings = scan_->Scan(brightness, pose_);
  } else {
    sight.log_brightness = LogBrightness(brightness);
  }
  sights_.push_back(std::move(sight));
  if (sights_.size() > kSights) sights_.erase(sights_.begin());
  return scan_ ? FindRing() : FindInlet();
}

/// What all pictures together say of a ring at this distance from the last one.
double LandmarkTracker::ScoreAt(double distance_m, bool mouth) const {
  double sum = 0.0;
  int seen = 0;
  for (const Sight& sight : sights_) {
    const double there_m = distance_m + sights_.back().travel_m - sight.travel_m;
    const auto& scores = mouth ? sight.rings.mouth : sight.rings.joint;
    const auto column = BestColumn(scores.significance, sight.rings.ColumnOf(there_m), 1);
    if (!column) continue;
    sum += scores.significance[*column];
    ++seen;
  }
  return seen == 0 ? 0.0 : sum / std::sqrt(seen);
}

/// How much worse a line explains what is seen about this distance than a step does: below 1 it is
/// a mouth rather than a joint.
double LandmarkTracker::StepOverLine(double distance_m) const {
  RingScan::Misfit all;
  for (const Sight& sight : sights_) {
    const double column =
        sight.rings.ColumnOf(distance_m + sights_.back().travel_m - sight.travel_m);
    const auto line = BestColumn(sight.rings.joint.significance, column, kEcho_px);
    const auto step = BestColumn(sight.rings.mouth.significance, column, kEcho_px);
    if (!line || !step) continue;
    const RingScan::Misfit misfit = RingScan::Compare(sight.rings, *line, *step);
    all.line += misfit.line;
    all.step += misfit.step;
  }
  return all.line > 0.0 ? all.step / all.line : 1.0;
}

std::optional<RangedLandmark> LandmarkTracker::FindRing() const {
  const bool mouth = kind_ == LandmarkKind::kManhole;
  std::vector<std::pair<double, double>> scores;  // by distance
  for (double d = parameters_.near_m; d <= parameters_.far_m; d *= 1.0 + kStep)
    scores.emplace_back(d, ScoreAt(d, mouth));
  std::vector<Peak> rings = Peaks(scores);
  double best = 0.0;
  for (const Peak& ring : rings) best = std::max(best, ring.score);
  std::erase_if(rings, [&](const Peak& ring) {
    if (ring.score < kLeast) return true;
    const double ratio = StepOverLine(ring.distance_m);
    return mouth ? ratio > kPerhapsStep : ratio < kSurelyStep;
  });
  best = 0.0;
  for (const Peak& ring : rings) best = std::max(best, ring.score);
  std::erase_if(rings, [&](const Peak& ring) {
    return ring.score < kLeast || ring.score < kNearestShare * best;
  });
  const auto nearest =
      std::min_element(rings.begin(), rings.end(),
                       [](const Peak& a, const Peak& b) { return a.distance_m < b.distance_m; });
  if (nearest == rings.end()) return {};

  double weights = 0.0, sum = 0.0;
  for (const Sight& sight : sights_) {
    const double travel_m = sights_.back().travel_m - sight.travel_m;
    const auto& all = (mouth ? sight.rings.mouth : sight.rings.joint).significance;
    const auto k = BestColumn(all, sight.rings.ColumnOf(nearest->distance_m + travel_m), 2);
    if (!k) continue;
    const double there_m = sight.rings.DistanceOf(RingScan::Refine(sight.rings, mouth, *k).column);
    const double pixel_m = there_m * there_m / sight.rings.ring_px_m * kPixel;
    const double drift_m = kOdometry * travel_m;
    const double weight = std::min(all[*k], 15.0) / 15.0 / (pixel_m * pixel_m + drift_m * drift_m);
    weights += weight;
    sum += weight * (there_m - travel_m);
  }
  if (weights <= 0.0) return {};
  return RangedLandmark{sum / weights, std::sqrt(1.0 / weights), nearest->score};
}

std::optional<RangedLandmark> LandmarkTracker::FindInlet() const {
  InletFit best;
  const bool left = kind_ == LandmarkKind::kInletLeft;
  const auto try_it = [&](const InletFit& fit) {
    InletFit tried = fit;
    tried.score = ScoreOf(tried);
    if (tried.score > best.score) best = tried;
  };
  for (double d = parameters_.near_m; d <= kFarthestInlet_m; d *= 1.03) {
    for (double up = -0.35; up <= 0.8; up += 0.1)
      try_it({d, left ? std::numbers::pi + up : -up, Eigen::Vector2d::Zero(), 0.0});
  }
  if (best.score <= 0.0) return {};
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
  if (best.score < kLeastInlet) return {};
  return RangedLandmark{best.distance_m, kInletDeviation * best.distance_m, best.score};
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
    const double there_m = fit.distance_m + sights_.back().travel_m - sight.travel_m;
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
