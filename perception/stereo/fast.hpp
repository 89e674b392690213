#pragma once

#include <opencv2/core/mat.hpp>

#include "perception/stereo/frame.hpp"
#include "perception/stereo/interpolation.hpp"

namespace kantaro::perception::stereo {

/// Fast stereo matching by interpolation (thesis section 5.4): MatchCorners, KeepSupported,
/// Bridge, Interpolate.
/// @returns CV_32F, NaN where there is none.
[[nodiscard]] cv::Mat MatchFast(const Frame& frame, Interpolation interpolation);

/// Disparities at the corners of 8 x 8 blocks (eq. 5.13), CornersAlong(height) x
/// CornersAlong(width), by
///   Com_d = (SSD′_d + ω Cor_d) / (1 + ω),  SSD′_d = 1 − SSD_d / pa  (eq. 5.12, 5.7, 5.9),
///   ω = G_h / G0 (eq. 5.11), G_h = |I(x, y) − I(x − 1, y)| of the left image:
/// with the gradient's sign, 1 + ω could vanish.
/// A corner so near the border that its window leaves the image is matched at the nearest place
/// where it fits.
[[nodiscard]] cv::Mat MatchCorners(const Frame& frame);

/// The corners whose disparity has Parameters::corner_support, the others with none. A corner
/// without disparity supports no neighbour; at the border the neighbours there are count twice.
[[nodiscard]] cv::Mat KeepSupported(const cv::Mat& corners, const Parameters& parameters);

/// The corners, those without disparity between two opposite neighbours of one wall (that differ by
/// no more than Parameters::steepest_wall) with the mean of all such.
[[nodiscard]] cv::Mat Bridge(const cv::Mat& corners, const Parameters& parameters);

}  // namespace kantaro::perception::stereo
