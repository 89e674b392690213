#include "perception/inlet_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace kantaro::perception {
namespace {

constexpr double kFarthest_m = 1.0, kStep = 0.02;
constexpr double kLowest_rad = -0.25, kHighest_rad = 0.65, kAngleStep_rad = 0.09;  ///< of the axis
constexpr int kMargin_px = 8;
constexpr double kSmooth_px = 0.8;

/// Samples: rings about the mouth's middle, in its radii, and how much each sample there weighs.
constexpr int kDirections = 16;
struct Ring {
  double radius, weight;
};
constexpr std::array<Ring, 4> kInside{{{0.25, 0.25}, {0.5, 0.5}, {0.7, 0.7}, {0.88, 0.7}}};
constexpr std::array<double, 3> kOutside{1.12, 1.28, 1.45};
constexpr std::size_t kFewest = 8;  ///< samples of the wall in a picture
constexpr double kLeastSeen = 0.2;

/// Deviations [log light]: inside an inlet from what is expected there, of one edge's contrast, and
/// of the wall's noise at least.
constexpr double kInsideDeviation = 0.08, kEdgeDeviation = 0.12, kLeastDeviation = 0.06;
constexpr double kMostStain = 0.5;
/// An inlet's paint against the wall's [log]: from as dark as mould to the same.
constexpr double kDarkest = -2.5, kBrightest = 0.0;

/// How much each sign says [log odds]: logistic regression among all places, on single pictures of
/// 400 training views (`stress`, seeds 31, 32, 35 and 36), of which two in a hundred misled it.
constexpr double kFitWeight = 6.7, kSmoothWeight = 1.4, kEdgeWeight = 8.7;
constexpr double kPoseError_m = 0.006;
constexpr double kDeviation_m = 0.006;  ///< where the outline is plain: errors of such views
constexpr std::size_t kRefined = 6;

/// Minus the log likelihood of so many deviations, with Student's tails.
double Surprise(double deviations) { return 2.0 * std::log1p(deviations * deviations / 4.0); }

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Log light at a place of a picture of log brightness: the cameras' curve (docs/cameras.md),
/// backwards. NaN where the picture shows nothing.
double LightAt(const cv::Mat& picture, const cv::Point2d& at) {
  constexpr double kDarkFloor = 4.0, kBlack = 0.03, kWhite = 0.97;  // floor: as LogBrightness adds
  const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
  if (x < kMargin_px || y < kMargin_px || x >= picture.cols - kMargin_px ||
      y >= picture.rows - kMargin_px)
    return NAN;
  const double fx = at.x - x, fy = at.y - y;
  const float* const row = picture.ptr<float>(y) + x;
  const float* const next = picture.ptr<float>(y + 1) + x;
  const double value =
      (row[0] * (1.0 - fx) + row[1] * fx) * (1.0 - fy) + (next[0] * (1.0 - fx) + next[1] * fx) * fy;
  const double grey = (std::exp(value) - kDarkFloor) / 255.0;
  const double root = std::clamp((grey - kBlack) / kWhite, 0.004, 0.995);
  return std::log(-std::log(1.0 - root * root));
}

/// The wall about a mouth in one picture: by how much brighter than an even one, and its scatter.
struct WallLevel {
  double level{}, deviation{};
};
WallLevel LevelOf(const std::vector<double>& excess) {
  const double median = Median(excess);
  double sum = 0.0, squares = 0.0;
  for (const double one : excess) {
    const double off = std::clamp(one - median, -kMostStain, kMostStain);
    sum += off;
    squares += off * off;
  }
  const double mean = sum / static_cast<double>(excess.size());
  const double variance = squares / static_cast<double>(excess.size()) - mean * mean;
  return {median + mean, std::hypot(std::sqrt(std::max(0.0, variance)), kLeastDeviation)};
}

}  // namespace

/// What the pictures show where a mouth would be, less the level of the wall about it [log light].
struct InletSearch::Samples {
  struct One {
    double seen{}, wall{}, branch{};  ///< and what is expected without an inlet, and with one
    double weight{}, deviation{};     ///< the latter of the wall
  };
  struct Edge {
    One inside;
    double seen{}, wall{};  ///< outside
  };
  std::vector<One> inside;
  std::vector<Edge> edges;
  double weight{};  ///< of all samples inside that there are
};

InletSearch::InletSearch(const robot::Camera& camera, const std::vector<Eigen::Vector3d>& p_CLamp,
                         const KnownSizes& sizes, bool left, double near_m, double far_m)
    : camera_(camera),
      pipe_{sizes.pipe_diameter_m / 2.0, sizes.inlet_diameter_m / 2.0, p_CLamp},
      left_(left),
      near_m_(near_m),
      far_m_(std::max(near_m, std::min(far_m, kFarthest_m))) {}

RangedLandmark InletSearch::Find(const std::vector<InletSight>& sights) const {
  std::vector<InletSight> smooth = sights;
  for (InletSight& sight : smooth) {
    cv::Mat blurred;
    cv::GaussianBlur(sight.log_brightness, blurred, {}, kSmooth_px);
    sight.log_brightness = blurred;
  }
  const std::vector<Place> places = SearchAll(smooth);
  std::vector<TriedDistance> tried;
  for (const Place& place : places) tried.push_back({place.distance_m, place.log_odds});
  // The best ones again, each with the axis where it suits them: narrow far ones gain most.
  const auto judge = [&](Place& place) {
    Judge(smooth, place);
    return place.log_odds;
  };
  Place best{0.0, 0.0, Eigen::Vector2d::Zero(), -HUGE_VAL};
  for (const Place& place : BestApart(places)) {
    const Place refined = Refine(place, judge);
    tried.push_back({refined.distance_m, refined.log_odds});
    if (refined.log_odds > best.log_odds) best = refined;
  }
  best = Refine(best, [&](const Place& place) { return Outline(smooth, place); });
  const RangedLandmark likeliest = Likeliest(tried);
  return {best.distance_m,
          std::hypot(kDeviation_m, likeliest.deviation_m, best.distance_m - likeliest.distance_m)};
}

std::vector<InletSearch::Place> InletSearch::BestApart(std::vector<Place> places) {
  std::ranges::stable_sort(places, std::greater{}, &Place::log_odds);
  std::vector<Place> best;
  for (const Place& place : places) {
    const bool near = std::ranges::any_of(best, [&](const Place& other) {
      return std::abs(other.distance_m - place.distance_m) < 2.0 * kStep * place.distance_m;
    });
    if (!near) best.push_back(place);
    if (best.size() == kRefined) break;
  }
  return best;
}

/// The best one at each distance.
std::vector<InletSearch::Place> InletSearch::SearchAll(
    const std::vector<InletSight>& smooth) const {
  std::vector<Place> places;
  for (double d = near_m_; d <= far_m_; d *= 1.0 + kStep) {
    Place here{d, 0.0, Eigen::Vector2d::Zero(), -HUGE_VAL};
    for (double up = kLowest_rad; up <= kHighest_rad; up += kAngleStep_rad) {
      Place place{d, left_ ? std::numbers::pi + up : -up};
      Judge(smooth, place);
      if (place.log_odds > here.log_odds) here = place;
    }
    places.push_back(here);
  }
  return places;
}

InletSearch::Place InletSearch::Refine(Place best,
                                       const std::function<double(Place&)>& score) const {
  double most = score(best);
  const auto try_it = [&](Place place) {
    const double here = score(place);
    if (here <= most) return;
    most = here;
    best = place;
  };
  double step = 1.0;
  for (int pass = 0; pass < 7; ++pass, step *= 0.6) {
    for (int repeat = 0; repeat < 2; ++repeat) {
      for (const double by : {-step, step}) {
        Place place = best;
        place.distance_m *= 1.0 + 0.02 * by;
        try_it(place);
        // Along the line of sight: farther, and the wall as much farther off.
        place = best;
        place.distance_m *= 1.0 + 0.03 * by;
        const double out_m = 0.03 * by * pipe_.pipe_radius_m;
        place.off_m += out_m * Eigen::Vector2d(std::cos(best.angle_rad), std::sin(best.angle_rad));
        try_it(place);
        place = best;
        place.angle_rad += 0.05 * by;
        try_it(place);
        place = best;
        place.off_m.x() += 0.004 * by;
        try_it(place);
        place = best;
        place.off_m.y() += 0.004 * by;
        try_it(place);
      }
    }
  }
  return best;
}

/// How plainly the mouth's outline shows: how much there is of the step that is expected all along
/// it; less what speaks against moving the axis.
double InletSearch::Outline(const std::vector<InletSight>& smooth, const Place& place) const {
  constexpr int kPoints = 32;
  constexpr double kBeside = 0.06;   // of the mouth's radius
  constexpr double kMostStep = 0.8;  // log light
  constexpr double kAgainst = 0.05;  // moving by one deviation
  double sum = 0.0, squares = 0.0;
  for (const InletSight& sight : smooth) {
    const BranchMouth mouth = MouthIn(sight, place);
    for (int i = 0; i < kPoints; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kPoints;
      const Eigen::Vector2d to(std::cos(a), std::sin(a));
      const auto outer = mouth.At((1.0 + kBeside) * to.x(), (1.0 + kBeside) * to.y());
      const auto inner = mouth.At((1.0 - kBeside) * to.x(), (1.0 - kBeside) * to.y());
      if (!outer || !inner) continue;
      const double step = LightAt(sight.log_brightness, inner->pixel) - inner->wall -
                          LightAt(sight.log_brightness, outer->pixel) + outer->wall;
      if (std::isnan(step)) continue;
      const double expected =
          std::clamp(inner->branch + place.paint - inner->wall, -kMostStep, kMostStep);
      sum += expected * std::clamp(step, -kMostStep, kMostStep);
      squares += expected * expected;
    }
  }
  if (squares <= 0.0) return -HUGE_VAL;
  return sum / std::sqrt(squares * kPoints * static_cast<double>(smooth.size())) -
         kAgainst * place.off_m.squaredNorm() / (kPoseError_m * kPoseError_m);
}

BranchMouth InletSearch::MouthIn(const InletSight& sight, const Place& place) const {
  return {camera_,
          pipe_,
          {sight.pose.off_m + place.off_m, sight.pose.lean},
          sight.right_m,
          place.distance_m + sight.ahead_m,
          place.angle_rad + sight.roll_rad};
}

InletSearch::Samples InletSearch::Take(const std::vector<InletSight>& smooth,
                                       const Place& place) const {
  static const auto kTurns = [] {
    std::array<Eigen::Vector2d, kDirections> turns;
    for (int i = 0; i < kDirections; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kDirections;
      turns[i] = {std::cos(a), std::sin(a)};
    }
    return turns;
  }();
  Samples samples;
  for (const Ring& ring : kInside) samples.weight += ring.weight * kDirections;
  samples.weight *= static_cast<double>(smooth.size());
  std::vector<double> excess;
  for (const InletSight& sight : smooth) {
    const BranchMouth mouth = MouthIn(sight, place);
    struct Look {
      double seen{NAN}, wall{}, branch{};
    };
    const auto look = [&](double radius, int direction) -> Look {
      const auto spot = mouth.At(radius * kTurns[direction].x(), radius * kTurns[direction].y());
      if (!spot) return {};
      return {LightAt(sight.log_brightness, spot->pixel), spot->wall, spot->branch};
    };
    excess.clear();
    std::array<Look, kDirections> beside;
    for (const double radius : kOutside) {
      for (int i = 0; i < kDirections; ++i) {
        const Look one = look(radius, i);
        if (radius == kOutside.front()) beside[i] = one;
        if (!std::isnan(one.seen)) excess.push_back(one.seen - one.wall);
      }
    }
    if (excess.size() < kFewest) continue;
    const WallLevel level = LevelOf(excess);
    for (const Ring& ring : kInside) {
      for (int i = 0; i < kDirections; ++i) {
        const Look one = look(ring.radius, i);
        if (std::isnan(one.seen)) continue;
        samples.inside.push_back(
            {one.seen - level.level, one.wall, one.branch, ring.weight, level.deviation});
        if (&ring != &kInside.back() || std::isnan(beside[i].seen)) continue;
        samples.edges.push_back(
            {samples.inside.back(), beside[i].seen - level.level, beside[i].wall});
      }
    }
  }
  return samples;
}

/// Of a mouth here against a whole wall, by all pictures: by how much better the light inside fits,
/// how much smoother it is, and how much better its edge fits. What is not seen says nothing.
void InletSearch::Judge(const std::vector<InletSight>& smooth, Place& place) const {
  place.log_odds = -0.5 * place.off_m.squaredNorm() / (kPoseError_m * kPoseError_m);
  const Samples samples = Take(smooth, place);
  double seen = 0.0, paint = 0.0;
  for (const Samples::One& one : samples.inside) {
    seen += one.weight;
    paint += one.weight * std::clamp(one.seen - one.branch, kDarkest, kBrightest);
  }
  if (seen < kLeastSeen * samples.weight) return;
  paint /= seen;
  place.paint = paint;
  double fit = 0.0, smoother = 0.0, edges = 0.0;
  for (const Samples::One& one : samples.inside) {
    smoother += one.weight * std::log(one.deviation / kInsideDeviation);
    fit += one.weight * (Surprise((one.seen - one.wall) / one.deviation) -
                         Surprise((one.seen - one.branch - paint) / kInsideDeviation));
  }
  for (const Samples::Edge& edge : samples.edges) {
    const Samples::One& inside = edge.inside;
    const double step = inside.seen - edge.seen;
    const double deviation = std::hypot(kEdgeDeviation, 0.7 * inside.deviation);
    edges += std::log(inside.deviation / deviation) +
             Surprise((step - inside.wall + edge.wall) / inside.deviation) -
             Surprise((step - inside.branch - paint + edge.wall) / deviation);
  }
  place.log_odds += (kFitWeight * fit + kSmoothWeight * smoother) / samples.weight +
                    kEdgeWeight * edges / (kDirections * static_cast<double>(smooth.size()));
}

}  // namespace kantaro::perception
