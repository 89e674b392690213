#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "perception/ring_votes.hpp"

namespace kantaro::perception {

/// The step's stencil looks so far along the radius [px].
inline constexpr int kStepReach_px = 12;
/// Contrast at which a vote saturates.
inline constexpr float kLargestVote = 0.40F;

/// A joint's line: one sign all round.
[[nodiscard]] const Groups& AllRound();
/// A mouth's step: crown (±45°) and both shoulders (to 85°). Beyond a mouth a ray over the crown
/// meets the far wall of the shaft, one over a shoulder the upright side of the channel: one may be
/// brighter than the pipe's wall and the other darker. Lower down the channel goes on like the
/// pipe.
[[nodiscard]] const Groups& CrownAndShoulders();

/// Logarithm of brightness, CV_32F; tamed in the dark.
[[nodiscard]] cv::Mat LogBrightness(const cv::Mat& brightness);

/// Log brightness around a centre: row = direction, column k = radius first_px + k.
struct Polar {
  cv::Mat value;    ///< CV_32F
  cv::Mat visible;  ///< CV_8U, 0 outside the image
  int first_px{};

  [[nodiscard]] int columns() const { return value.cols; }
  [[nodiscard]] bool Visible(int t, int k) const { return visible.at<std::uint8_t>(t, k) != 0; }
};

/// Sizes that follow from the camera and the pipe.
struct Optics {
  cv::Point2d center_px;
  double ring_px_m{};  ///< radius times distance
  double groove_m{};

  [[nodiscard]] double LineWidth(double radius_px) const {
    return groove_m * radius_px * radius_px / ring_px_m;
  }
  /// Distance from a line's middle to the wall beside it.
  [[nodiscard]] int LineFlank(double radius_px) const {
    return std::clamp(static_cast<int>(std::lround(1.5 + LineWidth(radius_px) / 2)), 2, 10);
  }
};

/// Signed contrast of a line and of a step at each polar pixel, 0 where the stencil or the image
/// ends.
struct Contrasts {
  cv::Mat line, step;  ///< CV_32F, like the polar picture
};

/// Contrasts are cut at the largest: no pixel has more than one vote.
[[nodiscard]] Contrasts Measure(const Polar& polar, const Optics& optics, float largest_line,
                                float largest_step);

/// Visible directions at each column.
[[nodiscard]] std::vector<int> CountVisible(const Polar& polar, const Groups& groups);

}  // namespace kantaro::perception
