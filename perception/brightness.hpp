#pragma once

#include <opencv2/core/mat.hpp>

namespace kantaro::perception {

/// Brightness of a colour image, Y = 0.3 R + 0.6 G + 0.1 B (thesis eq. 3.2), rounded.
/// @param image  8-bit BGR, not empty.
/// @returns 8-bit, one channel, the same size.
/// @throws std::invalid_argument for any other type, or an empty image.
[[nodiscard]] cv::Mat Brightness(const cv::Mat& image);

/// @throws std::invalid_argument naming `what`, unless the image is 8-bit, one channel and not
/// empty.
void RequireBrightness(const cv::Mat& image, const char* what);

}  // namespace kantaro::perception
