#include "scenarios/recorded_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/brightness.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/recorded_mission.hpp"

namespace kantaro::scenarios {
namespace {

using perception::LandmarkKind;
using robot::RecordedEstimate;

constexpr double kBetween_m = 0.10, kMostDeviation_m = 0.03;

std::vector<RecordedEstimate> EstimatesOf(const std::filesystem::path& file) {
  robot::Recording recording(file);
  std::vector<RecordedEstimate> estimates;
  while (const auto record = recording.Next()) {
    if (const auto* estimate = std::get_if<RecordedEstimate>(&*record))
      estimates.push_back(*estimate);
  }
  return estimates;
}

/// Between the estimates before and after, which must be of one leg.
std::optional<RecordedEstimate> EstimateAt(const std::vector<RecordedEstimate>& estimates,
                                           robot::RunTime time) {
  const auto after = std::ranges::lower_bound(estimates, time, {}, &RecordedEstimate::at);
  if (after == estimates.begin() || after == estimates.end()) return {};
  const RecordedEstimate& before = *std::prev(after);
  if (before.leg != after->leg || before.deviation_m > kMostDeviation_m) return {};
  const double share = robot::Seconds(time - before.at) / robot::Seconds(after->at - before.at);
  RecordedEstimate between = before;
  between.distance_m += share * (after->distance_m - before.distance_m);
  return between;
}

double InletDiameter(const navigation::MapLeg& leg, const network::Pipe& pipe, double distance_m) {
  const double chainage_m = leg.downstream ? distance_m : leg.length_m - distance_m;
  return std::ranges::min_element(
             pipe.inlets, {},
             [&](const network::Inlet& inlet) { return std::abs(inlet.chainage_m - chainage_m); })
      ->diameter_m;
}

/// The cameras of one kind: where they are, and their pictures as perception takes them.
class RecordedCameras {
 public:
  RecordedCameras(const robot::Description& description, ViewCameras cameras)
      : cameras_(cameras),
        x_m_(description
                 .PoseInBase(cameras == ViewCameras::kFront ? description.front_camera.link
                                                            : description.stereo_left.link)
                 .translation()
                 .x()),
        front_(description.front_camera, robot::FrontRectification(description)),
        stereo_(description) {}

  [[nodiscard]] double x_m() const { return x_m_; }

  [[nodiscard]] std::optional<LandmarkPicture> Take(const robot::Reading& reading) const {
    const auto* front = std::get_if<robot::FrontImage>(&reading.value);
    const auto* stereo = std::get_if<robot::StereoPair>(&reading.value);
    if (cameras_ == ViewCameras::kFront && front != nullptr)
      return LandmarkPicture{front_.Rectify(perception::Brightness(front->image)), {}, 0.0};
    if (cameras_ == ViewCameras::kFront || stereo == nullptr) return {};
    const robot::StereoPair pair = stereo_.Rectify(
        {perception::Brightness(stereo->left), perception::Brightness(stereo->right)});
    return LandmarkPicture{pair.left, pair.right, 0.0};
  }

 private:
  ViewCameras cameras_;
  double x_m_;
  robot::Rectifier front_;
  robot::StereoRectifier stereo_;
};

}  // namespace

std::vector<LandmarkAhead> LandmarksAhead(const navigation::MapLeg& leg, const network::Pipe& pipe,
                                          double length_m, double at_m) {
  std::vector<LandmarkAhead> ahead;
  const auto add = [&](LandmarkKind kind, double distance_m, double inlet_m) {
    if (distance_m < 0.0 || std::ranges::find(ahead, kind, &LandmarkAhead::kind) != ahead.end())
      return;
    ahead.push_back({kind, distance_m, {leg.diameter_m, inlet_m}});
  };
  for (const navigation::MapLandmark& landmark : leg.landmarks) {
    const double distance_m = landmark.distance_m - at_m;
    if (landmark.kind == navigation::LandmarkKind::kJoint) {
      add(LandmarkKind::kJoint, distance_m, 0.0);
    } else {
      const bool left = landmark.kind == navigation::LandmarkKind::kInletLeft;
      add(left ? LandmarkKind::kInletLeft : LandmarkKind::kInletRight, distance_m,
          InletDiameter(leg, pipe, landmark.distance_m));
    }
  }
  add(LandmarkKind::kManhole, length_m - at_m, 0.0);
  std::erase_if(ahead, [](const LandmarkAhead& one) {
    const bool inlet = one.sizes.inlet_diameter_m > 0.0;
    return one.distance_m < kNearestView_m ||
           one.distance_m > (inlet ? kFarthestInlet_m : kFarthestRing_m);
  });
  return ahead;
}

void ForEachRecordedView(const std::filesystem::path& file, ViewCameras cameras,
                         const std::function<void(LandmarkView&&)>& use) {
  const std::vector<RecordedEstimate> estimates = EstimatesOf(file);
  robot::Recording recording(file);
  const RecordedMission mission = MissionOf(recording);
  const navigation::MapRoute route = navigation::MakeRoute(
      mission.scenario.network, RouteManholes(mission.scenario), mission.conditions.map_scale);
  const RecordedCameras taken(mission.robot.description, cameras);
  std::optional<RecordedEstimate> last;
  std::size_t number = 0;
  while (const auto record = recording.Next()) {
    const auto* reading = std::get_if<robot::Reading>(&*record);
    if (reading == nullptr) continue;
    const auto estimate = EstimateAt(estimates, reading->captured_at);
    if (!estimate || estimate->leg >= route.legs.size()) continue;
    if (last && last->leg == estimate->leg &&
        std::abs(estimate->distance_m - last->distance_m) < kBetween_m)
      continue;
    const auto picture = taken.Take(*reading);
    if (!picture) continue;
    last = estimate;
    const navigation::MapLeg& leg = route.legs[estimate->leg];
    const network::Pipe& pipe = mission.scenario.network.PipeNamed(leg.pipe);
    for (const LandmarkAhead& ahead :
         LandmarksAhead(leg, pipe, estimate->leg_length_m, estimate->distance_m + taken.x_m())) {
      LandmarkView view;
      view.number = number++;
      view.plan.kind = ahead.kind;
      view.plan.distance_m = ahead.distance_m;
      view.sizes = ahead.sizes;
      view.pictures = {*picture};
      use(std::move(view));
    }
  }
}

}  // namespace kantaro::scenarios
