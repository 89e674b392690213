#include "navigation/ring_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kantaro::navigation {
namespace {

constexpr double kSameRing_m = 0.08;  ///< between where a ring is expected and where it is seen
constexpr int kMostMissed = 2;        ///< frames
constexpr std::size_t kLeastSightings = 5;
constexpr double kLeastTravel_m = 0.25;
constexpr double kLeastError_m = 0.01;  ///< of one distance: residuals of a few points flatter

}  // namespace

std::optional<ScaleSighting> FitScale(const std::vector<double>& travel_m,
                                      const std::vector<double>& distance_m) {
  const std::size_t count = travel_m.size();
  if (count < kLeastSightings || std::abs(travel_m.back() - travel_m.front()) < kLeastTravel_m)
    return std::nullopt;
  const double n = static_cast<double>(count);
  const double mean_travel = std::accumulate(travel_m.begin(), travel_m.end(), 0.0) / n;
  const double mean_distance = std::accumulate(distance_m.begin(), distance_m.end(), 0.0) / n;
  double spread = 0.0;
  double common = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    spread += (travel_m[i] - mean_travel) * (travel_m[i] - mean_travel);
    common += (travel_m[i] - mean_travel) * (distance_m[i] - mean_distance);
  }
  const double slope = common / spread;
  double residuals = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double residual = distance_m[i] - mean_distance - slope * (travel_m[i] - mean_travel);
    residuals += residual * residual;
  }
  const double error_m = std::max(kLeastError_m, std::sqrt(residuals / (n - 2.0)));
  return ScaleSighting{-slope, error_m / std::sqrt(spread)};
}

std::vector<ScaleSighting> RingTracker::Follow(const std::vector<perception::RingSighting>& rings,
                                               double wheel_travel_m) {
  for (Track& track : tracks_) ++track.missed;
  for (const perception::RingSighting& ring : rings) {
    Track* nearest = nullptr;
    double least = kSameRing_m;
    for (Track& track : tracks_) {
      const double expected = track.distance_m.back() - (wheel_travel_m - track.travel_m.back());
      const double error = std::abs(ring.distance_m - expected);
      if (track.kind == ring.kind && error < least) {
        least = error;
        nearest = &track;
      }
    }
    if (nearest == nullptr) nearest = &tracks_.emplace_back(Track{ring.kind, {}, {}, 0});
    nearest->travel_m.push_back(wheel_travel_m);
    nearest->distance_m.push_back(ring.distance_m);
    nearest->missed = 0;
  }
  std::vector<ScaleSighting> scales;
  std::erase_if(tracks_, [&](const Track& track) {
    if (track.missed <= kMostMissed) return false;
    if (const auto scale = FitScale(track.travel_m, track.distance_m)) scales.push_back(*scale);
    return true;
  });
  return scales;
}

std::size_t RingTracker::TimesSeen(const perception::RingSighting& ring) const {
  for (const Track& track : tracks_) {
    if (track.kind == ring.kind && track.distance_m.back() == ring.distance_m) {
      return track.distance_m.size();
    }
  }
  return 0;
}

}  // namespace kantaro::navigation
