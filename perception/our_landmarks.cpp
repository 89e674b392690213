#include "perception/our_landmarks.hpp"

#include <algorithm>

#include "perception/joint_search.hpp"
#include "perception/mouth_search.hpp"

namespace kantaro::perception {
namespace {

constexpr double kWidening_m = 0.5;  ///< a shaft is wider than its pipe by so much (thesis 5.2)

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
    inlet_.emplace(camera, lamps_, sizes, kind == LandmarkKind::kInletLeft, parameters.near_m,
                   parameters.far_m);
    return;
  }
  if (kind == LandmarkKind::kJoint) {
    scan_.emplace(camera, radius_m, parameters.near_m, parameters.far_m + 0.3);
    return;
  }
  mouth_.emplace(
      camera, lamps_, radius_m,
      sizes.shaft_diameter_m > 0.0 ? sizes.shaft_diameter_m : sizes.pipe_diameter_m + kWidening_m);
}

void LandmarkTracker::Add(const cv::Mat& brightness, const cv::Mat& right, double travel_m) {
  if (!right.empty())
    sights_.push_back({{}, LogBrightness(right), travel_m, baseline_m_, {}, {}, {}});
  sights_.push_back({brightness.clone(), LogBrightness(brightness), travel_m, 0.0, {}, {}, {}});
  const std::size_t most = kPicturesOfApproach * (right.empty() ? 1 : 2);
  if (sights_.size() > most)
    sights_.erase(sights_.begin(), sights_.end() - static_cast<std::ptrdiff_t>(most));
}

RangedLandmark LandmarkTracker::Answer() {
  const double radius_m = sizes_.pipe_diameter_m / 2.0;
  const Sight& first = *std::ranges::find(sights_, 0.0, &Sight::right_m);
  std::vector<WallSight> passing;
  for (const Sight& sight : sights_)
    passing.push_back({sight.log_brightness, sight.travel_m, sight.right_m});
  motion_ = FollowWall(camera_, radius_m, passing,
                       FindWallPose(first.brightness, camera_, lamps_, radius_m, camera_height_m_));
  Scan();
  if (inlet_) return FindInlet();
  return mouth_ ? FindMouth() : FindJoint();
}

void LandmarkTracker::Scan() {
  for (Sight& sight : sights_) {
    const double travel_m = sight.travel_m - sights_.back().travel_m;
    sight.pose = SeenFrom(motion_.PoseAt(travel_m), sight.right_m);
    sight.roll_rad = motion_.SwayAt(travel_m).roll_rad;
    if (sight.right_m != 0.0) sight.pose.lean.x() += motion_.turned_px / camera_.focal_px;
    if (scan_) sight.rings = scan_->Scan(sight.log_brightness, sight.pose);
  }
}

/// How far what is at a distance from the last left picture is from where another one was taken.
double LandmarkTracker::Ahead(const Sight& sight, double distance_m) const {
  return distance_m + motion_.travel_scale * (sights_.back().travel_m - sight.travel_m) -
         sight.right_m * sight.pose.lean.x();
}

RangedLandmark LandmarkTracker::FindJoint() const {
  std::vector<JointSight> sights;
  for (const Sight& sight : sights_) sights.push_back({sight.rings, Ahead(sight, 0.0)});
  return perception::FindJoint(sights, motion_.doubt, parameters_.near_m, parameters_.far_m);
}

RangedLandmark LandmarkTracker::FindMouth() const {
  std::vector<MouthSight> sights;
  for (const Sight& sight : sights_)
    sights.push_back(
        {sight.log_brightness, sight.pose, sight.roll_rad, Ahead(sight, 0.0), sight.right_m});
  return perception::FindMouth(*mouth_, sights, parameters_.near_m, parameters_.far_m);
}

RangedLandmark LandmarkTracker::FindInlet() const {
  std::vector<InletSight> sights;
  for (const Sight& sight : sights_)
    sights.push_back(
        {sight.log_brightness, sight.pose, sight.roll_rad, Ahead(sight, 0.0), sight.right_m});
  return inlet_->Find(sights);
}

}  // namespace kantaro::perception
