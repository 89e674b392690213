#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "perception/landmark_distance.hpp"
#include "perception/stereo/stereo.hpp"

namespace kantaro::perception {

/// Where in the picture the thesis looks for a kind of landmark (4.2, 5.5): manholes above the
/// middle, joints in its centre, inlets in the upper half of their side. The thesis gives no sizes.
[[nodiscard]] cv::Rect RegionOfInterest(LandmarkKind kind, cv::Size size);

/// A circle and how many edge pixels lie on it.
struct HoughCircle {
  cv::Point2d center;
  double radius_px{};
  int votes{};
};

/// What circles are looked for: centres on a grid, and radii of whole pixels.
struct HoughBounds {
  cv::Rect centers;
  int step_px{2};
  int smallest_px{}, largest_px{};
  /// A centre lies no farther from the middle of `centers` than reach_px and this share of its
  /// radius; 0: anywhere.
  double reach_share{};
  int reach_px{};

  /// The smallest radius that a circle about this centre may have.
  [[nodiscard]] int SmallestAt(cv::Point center) const;
};

/// Hough transform for circles (thesis 4.3) with three unknowns (a, b, r) and a bounded range of r:
/// each edge pixel votes once for every centre. Votes count by the square root of the radius, which
/// is how much those of mere texture scatter; the thesis does not say. The first of equal maxima;
/// no votes without edges.
/// @param edges  8-bit, 0 where there is none. @throws std::invalid_argument for another type
[[nodiscard]] HoughCircle FindCircle(const cv::Mat& edges, const HoughBounds& bounds);

/// The circle that the thesis' method finds for a landmark: region of interest, Canny, Hough.
[[nodiscard]] HoughCircle ThesisCircle(const cv::Mat& image, const robot::Camera& camera,
                                       const LandmarkParameters& parameters, LandmarkKind kind,
                                       const KnownSizes& sizes);
/// By how much radii are to be multiplied to look up RadiusTable.
[[nodiscard]] double RadiusScale(LandmarkKind kind, const KnownSizes& sizes);

/// Edge pixels in a region of interest at three upper thresholds of Canny's operator.
struct EdgeCounts {
  cv::Mat edges;  ///< 8-bit, of the whole picture, at canny_high; 0 outside the region
  int shorter{}, longer{};
};
[[nodiscard]] EdgeCounts CountEdges(const cv::Mat& image, const LandmarkParameters& parameters,
                                    LandmarkKind kind);

/// What the two images tell by LC at the edges of a region of interest (thesis 5.5), and what the
/// two linear fits of edge counts say.
struct StereoSight {
  std::vector<double> distances_m;  ///< of all edge pixels that LC matches
  double tau1_m{}, tau2_m{};        ///< kept to where landmarks are looked for
};
/// @param px_m  focal length times baseline
[[nodiscard]] StereoSight SeeByStereo(const cv::Mat& left, const cv::Mat& right, double px_m,
                                      const LandmarkParameters& parameters, LandmarkKind kind);

/// Thesis eq. 5.18 and 5.19: distances are clamped to [tau1, tau2], put in order if they are not,
/// and averaged. @throws std::invalid_argument for no distances
[[nodiscard]] double RefineDistances(const std::vector<double>& distances_m, double tau1_m,
                                     double tau2_m);

}  // namespace kantaro::perception
