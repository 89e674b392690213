#pragma once

#include <opencv2/core/mat.hpp>

#include "perception/stereo/frame.hpp"

namespace kantaro::perception::stereo {

/// Ours: census transforms of 7 x 7 pixels (R. Zabih and J. Woodfill, 1994), which no difference in
/// exposure or falloff changes, compared along eight paths through the image at a price for each
/// step of the disparity (H. Hirschmüller, "Stereo processing by semiglobal matching and mutual
/// information", 2008); refined below the pixel. A disparity stands where the right image's best
/// one agrees to a pixel, and where the censuses around differ in less than a third of their
/// places: of what has nothing in common they differ in half.
/// @param frame  of images that are not smoothed.
/// @returns CV_32F, NaN where there is none.
[[nodiscard]] cv::Mat MatchSemiGlobal(const Frame& frame);

}  // namespace kantaro::perception::stereo
