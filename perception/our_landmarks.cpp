#include "perception/our_landmarks.hpp"

#include <algorithm>
#include <cmath>

#include "perception/mouth_search.hpp"

namespace kantaro::perception {
namespace {

constexpr std::size_t kPictures = 3;  ///< kept, of each camera
constexpr double kStep = 0.003;       ///< of the distances tried, as a share

/// How much each sign says [log odds]: logistic regression among all distances, on training views.
constexpr double kJointWeight = 0.93;
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
      sizes_(sizes),
      baseline_m_(baseline_m),
      camera_height_m_(CameraHeight(sizes.pipe_diameter_m)),
      lamps_(LampsBefore(description, camera)) {
  const double radius_m = sizes.pipe_diameter_m / 2.0;
  if (ClassOf(kind) == LandmarkClass::kInlet) {
    inlet_.emplace(camera, lamps_, sizes, kind == LandmarkKind::kInletLeft, parameters.near_m);
    return;
  }
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
  if (inlet_) return FindInlet();
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
  std::vector<InletSight> sights;
  for (const Sight& sight : sights_)
    sights.push_back({sight.log_brightness, sight.pose, Ahead(sight, 0.0)});
  return inlet_->Find(sights);
}

}  // namespace kantaro::perception
