#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

/// Stereo matching (thesis chapter 5) on rectified 8-bit pairs. A point at column x of the left
/// image lies at column x − d of the right one; d >= 0 is its disparity [px], and its depth along
/// the optical axis is focal length * baseline / d. (The thesis writes I_R(x + d), with d <= 0.)
namespace kantaro::perception::stereo {

enum class Method {
  kSsdPlain,     ///< sum of squared differences, each window summed anew
  kSsd,          ///< the same result by a sliding window
  kGradient,     ///< Scharstein's gradient measure, the thesis' [41]
  kNcc,          ///< normalised cross-correlation (eq. 5.9, 5.10)
  kLc,           ///< linear computation (eq. 5.2), pixel by pixel
  kCooperative,  ///< section 5.3: LC on feature pixels, constrained SSD on the others
  kFastNearest,  ///< section 5.4: matched at the corners of blocks only, interpolated between them
  kFastLinear,
  kFastCubic,
  kOurs,  ///< semi-global, of unsmoothed images, refined below the pixel whatever `subpixel` says
};

/// Every method with its name in files and reports.
[[nodiscard]] std::span<const std::pair<const char*, Method>> Methods();
[[nodiscard]] const char* ToString(Method method);
[[nodiscard]] std::optional<Method> MethodNamed(std::string_view name);

/// What becomes of a minimum of the SSD by its peak ratio (E2 − E1) / E1 (eq. 5.5; the thesis calls
/// it E_d again), E2 being the least cost at disparities not adjacent to the minimum's.
enum class FunctionValueConstraint {
  kAsWritten,  ///< above the threshold, E2's disparity is taken in its place
  kOff,        ///< nothing
  kInverted,   ///< at or below the threshold the minimum is ambiguous: no disparity
};

/// How a corner's disparity comes from SSD′ and correlation: eq. 5.12 defines it twice.
enum class CornerDisparity {
  kCombined,  ///< where Com_d is greatest
  kAverage,   ///< weighted mean of the disparities where SSD′ and where correlation is greatest
};

inline constexpr int kMostDisparities = 256;

struct Parameters {
  Method method{Method::kFastCubic};
  int min_disparity_px{0};
  int disparities{64};        ///< candidates: min_disparity_px and upwards, 1 to kMostDisparities
  bool subpixel{false};       ///< refines by a parabola through the measure; the thesis does not
  int gaussian_window_px{7};  ///< smoothing of both images (sections 5.3.2, 5.4.2); odd, 1: none
  double gaussian_px{3.0};    ///< its standard deviation
  int window_px{7};           ///< side of the square window; odd, 3 to 11
  /// A window whose brightness deviates by less [grey levels, after smoothing] is blank, saturated
  /// or mere noise, and has no disparity. Ours; 0 asks only that it be not perfectly flat.
  double least_deviation{0.5};

  int feature_threshold{10};  ///< T0, section 5.3.1
  FunctionValueConstraint function_value_constraint{FunctionValueConstraint::kAsWritten};
  double peak_ratio{0.2};             ///< Te, eq. 5.5
  double neighbour_threshold_px{10};  ///< T, eq. 5.3

  /// Root-mean-square difference [grey levels] at which SSD′ is 0: the thesis' pa, which has no
  /// value there, is window_px² ssd_scale².
  double ssd_scale{16};
  double gradient_scale{32};  ///< G0, eq. 5.11
  CornerDisparity corner_disparity{CornerDisparity::kCombined};
  /// A corner's disparity stands if those of so many of its eight neighbours differ from it by no
  /// more than steepest_wall times their distance [px/px]. Ours, by what the thesis builds on, that
  /// disparities change continuously (section 5.4); one between two that stand takes their mean. 0
  /// lets all stand, as the thesis does. A pipe's wall changes by baseline / radius.
  int corner_support{4};
  double steepest_wall{0.6};
};

/// What a matcher found, of the left image's size.
struct DisparityMap {
  cv::Mat disparity_px;  ///< CV_32F; NaN where there is none
};

/// Disparities of the left image by `parameters.method`, smoothing included. A function of its
/// arguments alone, on one thread.
///
/// There is none where the window or any candidate's leaves its image, so none in the first
/// min_disparity_px + disparities − 1 columns, and none where the left image shows nothing to match
/// (`least_deviation`; for LC, no difference to the left neighbour). The lowest of equally good
/// disparities wins.
/// @param left, right  rectified, 8-bit, one channel, of one size.
/// @throws std::invalid_argument for other images, for images too small to hold a window at every
/// disparity, and for parameters out of their ranges.
[[nodiscard]] DisparityMap Match(const cv::Mat& left, const cv::Mat& right,
                                 const Parameters& parameters);

}  // namespace kantaro::perception::stereo
