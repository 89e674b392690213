#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace kantaro::perception {

/// The part of an image between two circles of one centre.
struct Ring {
  cv::Point2d center_px;
  double inner_px{}, outer_px{};  ///< radii, 0 < inner < outer
};

/// Unrolls a ring into a panorama (thesis eq. 3.1, about the ring's centre, which the thesis leaves
/// out). Row 0 is the outer circle and the last row lies one row's height outside the inner one;
/// column 0 is the crown (12 o'clock), columns run clockwise as the camera sees it and the last one
/// meets the first.
/// @param image  8-bit, one channel, any size.
/// @param size   panorama size; the thesis uses 942 x 50.
/// @returns 8-bit panorama, bilinear.
/// @throws std::invalid_argument if the ring leaves the image, or its radii are not in order.
[[nodiscard]] cv::Mat UnrollRing(const cv::Mat& image, const Ring& ring, cv::Size size);

/// Moves a ring by the least amount that brings it inside an image of this size.
/// @throws std::invalid_argument if no move does.
[[nodiscard]] Ring FitInside(Ring ring, cv::Size image);

}  // namespace kantaro::perception
