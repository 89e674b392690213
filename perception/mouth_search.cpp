#include "perception/mouth_search.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::perception {
namespace {

constexpr double kStep = 0.003;  ///< of the distances tried, as a share

/// How much each sign says [log odds]: logistic regression among all distances, on training views.
constexpr double kStepWeight = 0.42, kLeastStep = -4.0, kMostStep = 6.0;
constexpr double kSidesWeight = 33.8, kMostSides = 0.5, kEndWallWeight = 5.4;
constexpr double kOuterWeight = 17.1, kInnerWeight = 32.8, kJumpWeight = 3.3;
constexpr double kMouthPixels = 0.7;  ///< deviation of a ring's radius

/// What all pictures together say of a step round this distance.
double StepAt(const std::vector<MouthSight>& sights, double distance_m) {
  double sum = 0.0;
  int seen = 0;
  for (const MouthSight& sight : sights) {
    const double score = sight.rings.At(sight.rings.mouth, distance_m + sight.ahead_m);
    if (score < RingScan::kUnseen / 2.0) continue;
    sum += score;
    ++seen;
  }
  return seen == 0 ? RingScan::kUnseen : sum / std::sqrt(seen);
}

}  // namespace

/// A step shows at the mouth, unless a channel's wall goes on smoothly; behind it, the picture is
/// brighter than a pipe's wall would be, and where the channel goes straight on or ends the far
/// wall of the shaft stands out, or where it turns its walls' edges.
RangedLandmark FindMouth(const ShaftView& shaft, const std::vector<MouthSight>& sights,
                         double near_m, double far_m, double ring_px_m) {
  std::vector<TriedDistance> tried;
  for (double d = near_m; d <= far_m; d *= 1.0 + kStep) {
    double behind = 0.0;
    for (const MouthSight& sight : sights) {
      const double there_m = d + sight.ahead_m;
      const ShaftView::EndWall end = shaft.EndWallAt(sight.shaft, there_m);
      const ShaftView::Turn turn = shaft.TurnAt(sight.shaft, there_m);
      behind += kSidesWeight * std::min(end.Sides(), kMostSides) + kEndWallWeight * end.All() +
                kOuterWeight * turn.outer + kInnerWeight * turn.inner +
                kJumpWeight * shaft.Jump(sight.shaft, there_m);
    }
    tried.push_back({d, kStepWeight * std::clamp(StepAt(sights, d), kLeastStep, kMostStep) +
                            behind / static_cast<double>(sights.size())});
  }
  const RangedLandmark found = Likeliest(tried);
  const double off_m = kMouthPixels * found.distance_m * found.distance_m / ring_px_m;
  return {found.distance_m, std::hypot(found.deviation_m, off_m)};
}

}  // namespace kantaro::perception
