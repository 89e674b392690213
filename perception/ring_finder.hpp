#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "perception/observations.hpp"
#include "perception/ring_votes.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// How rings ahead are found. Contrasts are differences of log brightness: 0.1 is ten per cent.
struct RingParameters {
  double near_m{0.30}, far_m{1.60};  ///< rings are looked for between these distances
  int center_search_px{28};  ///< how far a ring's centre may lie from the principal point, per axis
  double groove_m{0.016};    ///< width of a joint's line, the gap and the dirt about it
  double joint_contrast{0.05};     ///< least mean contrast of the line all round
  double mouth_contrast{0.10};     ///< least mean contrast of the step in the upper sector
  double min_significance{6.0};    ///< least contrast over its standard error; noise reaches 5
  double support_contrast{0.03};   ///< a direction with more than this lies on the ring
  double joint_min_support{0.65};  ///< least share of a joint's directions on the ring
  double mouth_min_support{0.80};  ///< least share of a mouth's, crown and shoulders
};

/// Finds joints and manhole mouths ahead (thesis 4.3: the circle's radius gives the distance).
///
/// A circle Hough transform on a polar picture of log brightness about the principal point: each
/// pixel votes with its signed contrast, across a thin line (joint) or a step (mouth), for the
/// circles through it whose centre lies within center_search_px. Log brightness is brightness
/// divided by its scale, so near and far wall count alike; signed votes let texture cancel and a
/// faint ring add up, which single Canny edges do not. Maxima along the radius that no stronger one
/// is near are refined to a fraction of a pixel and judged. A joint is a thin line all round, dark
/// or bright; a mouth is a step in the upper sector, where the crown ends.
///
/// distance = focal length * pipe_radius_m / radius. The radius alone cannot tell a 250 mm ring
/// from a 300 mm one, so pipe_radius_m must come from the laser or the map.
///
/// What follows from camera, pipe and parameters is worked out once, for any number of images.
class RingFinder {
 public:
  /// @throws std::invalid_argument for a radius that is not above 0.
  RingFinder(const robot::Camera& camera, double pipe_radius_m, const RingParameters& parameters);

  /// @param brightness  8-bit, one channel, of the camera's size.
  /// @returns rings, nearest first; none in a black image.
  /// @throws std::invalid_argument for another type or size.
  [[nodiscard]] std::vector<RingSighting> Find(const cv::Mat& brightness) const;

 private:
  robot::Camera camera_;
  RingParameters parameters_;
  double ring_px_m_{};  ///< radius of a ring in the image times its distance
  int smallest_px_{}, largest_px_{}, pad_px_{};
  std::optional<RingVotes> joints_, mouths_;  ///< absent where the image has no room for a ring
};

/// The rings in a single image. @see RingFinder
[[nodiscard]] std::vector<RingSighting> FindRings(const cv::Mat& brightness,
                                                  const robot::Camera& camera, double pipe_radius_m,
                                                  const RingParameters& parameters);

}  // namespace kantaro::perception
