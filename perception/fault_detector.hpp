#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/observations.hpp"
#include "perception/panorama.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// Edge operators that the thesis compares (section 3.3).
enum class EdgeOperator { kSobel, kPrewitt, kLaplacian };

/// The fault detector of thesis chapter 3. Lengths w1, h1, w2, h2 and steps are the thesis' and
/// fixed in the code.
struct FaultParameters {
  double near_m{0.554}, far_m{0.831};  ///< wall between these distances is looked at
  EdgeOperator edge_operator{EdgeOperator::kSobel};
  double gaussian_px{1.0};  ///< σ of the smoothing
  double edge_gain{1.0};  ///< edge strength, grey levels a pixel, to grey levels of the edge image
  bool equalize_brightness{
      true};  ///< scale each panorama row to one mean brightness; the thesis does not
  double horizontal_threshold{0.97};  ///< th_h
  double vertical_threshold{0.96};    ///< th_v
  bool ignore_joints{true};           ///< leave out known rings and manholes; the thesis does not
  double joint_margin_px{5.0};        ///< half width of what is left out, in image pixels
};

/// Panorama size (thesis 3.3).
inline constexpr int kPanoramaWidth = 942, kPanoramaHeight = 50;

/// The ring of the image where the wall lies between near_m and far_m: radius = focal length * pipe
/// radius / distance. At the thesis' 640 x 480 in a 300 mm pipe, with the defaults, 150 and 100 px:
/// 942 = 2π·150. Centred on `center_px` as nearly as the image allows.
/// @throws std::invalid_argument if the ring does not fit into the image.
[[nodiscard]] Ring FaultRing(const robot::Camera& camera, double pipe_diameter_m,
                             cv::Point2d center_px, const FaultParameters& parameters);

/// Edge strength of a panorama, its left and right ends joined: [equalised brightness,] Gaussian,
/// operator, gain. Sobel and Prewitt give the gradient's length, Laplacian its absolute value, each
/// as grey levels per pixel.
/// @param panorama  8-bit, one channel. @returns 8-bit, same size, saturated.
/// @throws std::invalid_argument for any other type.
[[nodiscard]] cv::Mat EdgeImage(const cv::Mat& panorama, const FaultParameters& parameters);

/// Eq. 3.3 on an edge image, for x = 0, 25, …, 925. I is read as the edge image; the panorama is a
/// circle, so windows wrap and the last columns are looked at too (the thesis stops at 875). The
/// average image is the mean of the N1 = 892 windows of eq. 3.4.
/// @param edges  8-bit, 942 x 50.
/// @param used   8-bit, same size, 0 where a pixel is left out; empty: all are used.
/// @returns C(x), one for each window; 1 for a window that is left out whole.
[[nodiscard]] std::vector<double> HorizontalSimilarity(const cv::Mat& edges, const cv::Mat& used);

/// Eq. 3.5 on the 50 columns from x of an edge image (wrapping), for y = 0, 5, …, 40: how like the
/// strip of height 10 at y is to the nine strips at 0, 5, …, 40, itself among them. Divided by
/// nine, which the thesis leaves out, so that it lies between 0 and 1 like its thresholds.
[[nodiscard]] std::vector<double> VerticalSimilarity(const cv::Mat& edges, const cv::Mat& used,
                                                     int x);

/// Finds parts of the wall that do not look like the rest (thesis 3.3): windows with C(x) < th_h
/// that hold a strip with C(y) < th_v. Overlapping windows are one candidate, placed at the lowest
/// C(x) and C(y) among them.
/// @param brightness     8-bit, one channel: the front image, not yet unrolled.
/// @param ring           from FaultRing.
/// @param focal_px, pipe_diameter_m  turn radii into distances.
/// @param passing_rings  joints and mouths in this image. With ignore_joints their neighbourhood,
/// and all that lies
///                       beyond a mouth, is left out.
/// @throws std::invalid_argument for another image type, or a ring that leaves the image.
[[nodiscard]] std::vector<FaultCandidate> FindFaults(const cv::Mat& brightness, const Ring& ring,
                                                     double focal_px, double pipe_diameter_m,
                                                     const std::vector<RingSighting>& passing_rings,
                                                     const FaultParameters& parameters);

}  // namespace kantaro::perception
