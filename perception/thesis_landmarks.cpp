#include "perception/thesis_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "perception/brightness.hpp"

namespace kantaro::perception {
namespace {

/// Of a ring's centre from the principal point: a camera 30 mm off the axis of a 250 mm pipe sees
/// it a quarter of the ring's radius away, and one that leans by 0.5 degrees 5 px.
constexpr double kCenterShare = 0.3;
constexpr int kCenterReach_px = 80, kLean_px = 6;
constexpr int kInletStep_px = 4;
constexpr double kFarthestInlet_m = 0.8;  ///< beyond, its mouth is a few pixels wide

HoughBounds BoundsFor(const robot::Camera& camera, const LandmarkParameters& parameters,
                      LandmarkKind kind, const KnownSizes& sizes, const cv::Rect& region) {
  HoughBounds bounds;
  if (ClassOf(kind) == LandmarkClass::kInlet) {
    // The mouth is seen aslant, as a crescent: its outer arc is that of a circle about one and a
    // half times as large as the mouth's.
    bounds.centers = region;
    bounds.step_px = kInletStep_px;
    const double px_m = camera.focal_px * sizes.inlet_diameter_m / 2.0;
    bounds.smallest_px = std::max(4, static_cast<int>(0.9 * px_m / kFarthestInlet_m));
    bounds.largest_px = static_cast<int>(1.8 * px_m / parameters.near_m);
    return bounds;
  }
  const cv::Point middle(static_cast<int>(camera.center_x_px),
                         static_cast<int>(camera.center_y_px));
  bounds.centers = cv::Rect(middle.x - kCenterReach_px, middle.y - kCenterReach_px,
                            2 * kCenterReach_px + 1, 2 * kCenterReach_px + 1);
  bounds.reach_px = kLean_px;
  bounds.reach_share = kCenterShare;
  const double px_m = camera.focal_px * sizes.pipe_diameter_m / 2.0;
  bounds.smallest_px = std::max(4, static_cast<int>(px_m / parameters.far_m));
  bounds.largest_px = static_cast<int>(px_m / parameters.near_m);
  return bounds;
}

}  // namespace

cv::Rect RegionOfInterest(LandmarkKind kind, cv::Size size) {
  const auto part = [&](double left, double top, double right, double bottom) {
    return cv::Rect(
        cv::Point(static_cast<int>(left * size.width), static_cast<int>(top * size.height)),
        cv::Point(static_cast<int>(right * size.width), static_cast<int>(bottom * size.height)));
  };
  switch (kind) {
    case LandmarkKind::kManhole:
      return part(0.0, 0.0, 1.0, 0.5);
    case LandmarkKind::kJoint:
      return part(0.1, 0.0, 0.9, 0.8);
    case LandmarkKind::kInletLeft:
      return part(0.0, 0.0, 0.5, 0.6);
    case LandmarkKind::kInletRight:
      return part(0.5, 0.0, 1.0, 0.6);
  }
  throw std::invalid_argument("no such kind of landmark");
}

int HoughBounds::SmallestAt(cv::Point center) const {
  if (reach_share <= 0.0) return smallest_px;
  const cv::Point off = center - (centers.tl() + centers.br()) / 2;
  const double away_px = std::max(std::abs(off.x), std::abs(off.y)) - reach_px;
  return std::max(smallest_px, static_cast<int>(std::ceil(away_px / reach_share)));
}

HoughCircle FindCircle(const cv::Mat& edges, const HoughBounds& bounds) {
  RequireBrightness(edges, "circle finder");
  std::vector<cv::Point> points;
  cv::findNonZero(edges, points);
  HoughCircle best;
  double most = 0.0;
  std::vector<int> votes(static_cast<std::size_t>(bounds.largest_px) + 1);
  const int largest2 = bounds.largest_px * bounds.largest_px;
  for (int b = bounds.centers.y; b < bounds.centers.br().y; b += bounds.step_px) {
    for (int a = bounds.centers.x; a < bounds.centers.br().x; a += bounds.step_px) {
      std::fill(votes.begin(), votes.end(), 0);
      for (const cv::Point& point : points) {
        const int dx = point.x - a, dy = point.y - b, square = dx * dx + dy * dy;
        if (square > largest2) continue;
        ++votes[static_cast<std::size_t>(std::sqrt(static_cast<float>(square)) + 0.5F)];
      }
      for (int r = bounds.SmallestAt({a, b}); r <= bounds.largest_px; ++r) {
        const double weight = votes[r] / std::sqrt(static_cast<double>(r));
        if (weight <= most) continue;
        most = weight;
        best = {cv::Point2d(a, b), static_cast<double>(r), votes[r]};
      }
    }
  }
  return best;
}

HoughCircle ThesisCircle(const cv::Mat& image, const robot::Camera& camera,
                         const LandmarkParameters& parameters, LandmarkKind kind,
                         const KnownSizes& sizes) {
  const cv::Rect region = RegionOfInterest(kind, image.size());
  cv::Mat edges = cv::Mat::zeros(image.size(), CV_8U), within = edges(region);
  cv::Canny(image(region), within, parameters.circle_low, parameters.circle_high);
  return FindCircle(edges, BoundsFor(camera, parameters, kind, sizes, region));
}

double RadiusScale(LandmarkKind kind, const KnownSizes& sizes) {
  return ClassOf(kind) == LandmarkClass::kInlet ? kReferenceInlet_m / sizes.inlet_diameter_m
                                                : kReferencePipe_m / sizes.pipe_diameter_m;
}

EdgeCounts CountEdges(const cv::Mat& image, const LandmarkParameters& parameters,
                      LandmarkKind kind) {
  const cv::Rect region = RegionOfInterest(kind, image.size());
  const auto edges_at = [&](int high) {
    cv::Mat edges;
    cv::Canny(image(region), edges, parameters.canny_low, high);
    return edges;
  };
  EdgeCounts counts;
  counts.edges = cv::Mat::zeros(image.size(), CV_8U);
  edges_at(parameters.canny_high).copyTo(counts.edges(region));
  counts.shorter = cv::countNonZero(edges_at(parameters.shorter_high));
  counts.longer = cv::countNonZero(edges_at(parameters.longer_high));
  return counts;
}

StereoSight SeeByStereo(const cv::Mat& left, const cv::Mat& right, double px_m,
                        const LandmarkParameters& parameters, LandmarkKind kind) {
  stereo::Parameters lc;
  lc.method = stereo::Method::kLc;
  lc.min_disparity_px = static_cast<int>(px_m / parameters.far_m);
  lc.disparities = std::min(static_cast<int>(px_m / parameters.near_m) - lc.min_disparity_px + 1,
                            stereo::kMostDisparities);
  const EdgeCounts counts = CountEdges(left, parameters, kind);
  const cv::Mat disparity = stereo::Match(left, right, lc).disparity_px;
  const ClassCalibration& calibration = parameters.calibration.Of(kind);
  StereoSight sight;
  const auto tau_m = [&](const EdgeFit& fit, int edges) {
    return std::clamp(fit.DistanceAt(edges), parameters.near_m, parameters.far_m);
  };
  sight.tau1_m = tau_m(calibration.shorter, counts.shorter);
  sight.tau2_m = tau_m(calibration.longer, counts.longer);
  for (int y = 0; y < disparity.rows; ++y) {
    for (int x = 0; x < disparity.cols; ++x) {
      const float d = disparity.at<float>(y, x);
      if (counts.edges.at<std::uint8_t>(y, x) != 0 && d > 0.0F)
        sight.distances_m.push_back(px_m / d);
    }
  }
  return sight;
}

double RefineDistances(const std::vector<double>& distances_m, double tau1_m, double tau2_m) {
  if (distances_m.empty()) throw std::invalid_argument("no distances to refine");
  const auto [low_m, high_m] = std::minmax(tau1_m, tau2_m);
  double sum_m = 0.0;
  for (const double distance_m : distances_m) sum_m += std::clamp(distance_m, low_m, high_m);
  return sum_m / static_cast<double>(distances_m.size());
}

}  // namespace kantaro::perception
