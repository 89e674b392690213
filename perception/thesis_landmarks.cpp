#include "perception/thesis_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "perception/brightness.hpp"

namespace kantaro::perception {
namespace {

constexpr int kCenterReach_px = 40;  ///< of a ring's centre from the principal point
constexpr int kInletStep_px = 4;

HoughBounds BoundsFor(const robot::Camera& camera, const LandmarkParameters& parameters,
                      LandmarkKind kind, const KnownSizes& sizes, const cv::Rect& region) {
  HoughBounds bounds;
  if (ClassOf(kind) == LandmarkClass::kInlet) {
    // The mouth is seen aslant: no wider than its circle, and much less high from afar.
    bounds.centers = region;
    bounds.step_px = kInletStep_px;
    const double px_m = camera.focal_px * sizes.inlet_diameter_m / 2.0;
    bounds.smallest_px = std::max(4, static_cast<int>(0.5 * px_m / 0.9));
    bounds.largest_px = static_cast<int>(1.5 * px_m / parameters.near_m);
    return bounds;
  }
  const cv::Point middle(static_cast<int>(camera.center_x_px),
                         static_cast<int>(camera.center_y_px));
  bounds.centers = cv::Rect(middle.x - kCenterReach_px, middle.y - kCenterReach_px,
                            2 * kCenterReach_px + 1, 2 * kCenterReach_px + 1);
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

HoughCircle FindCircle(const cv::Mat& edges, const HoughBounds& bounds) {
  RequireBrightness(edges, "circle finder");
  std::vector<cv::Point> points;
  cv::findNonZero(edges, points);
  HoughCircle best;
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
      for (int r = bounds.smallest_px; r <= bounds.largest_px; ++r) {
        if (votes[r] <= best.votes) continue;
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
  return FindCircle(CountEdges(image, parameters, kind).edges,
                    BoundsFor(camera, parameters, kind, sizes, region));
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

double RefineDistances(const std::vector<double>& distances_m, double tau1_m, double tau2_m) {
  if (distances_m.empty()) throw std::invalid_argument("no distances to refine");
  const auto [low_m, high_m] = std::minmax(tau1_m, tau2_m);
  double sum_m = 0.0;
  for (const double distance_m : distances_m) sum_m += std::clamp(distance_m, low_m, high_m);
  return sum_m / static_cast<double>(distances_m.size());
}

}  // namespace kantaro::perception
