#pragma once

#include <opencv2/core/mat.hpp>

#include "robot/device/frame.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// A live Matroska stream (RFC 9559) of raw BGR images with stamps to 1 µs: what VideoCapture reads
/// through a pipe without loss and hands on at once.
/// @param period  that the stream claims to have.
[[nodiscard]] wire::Bytes MatroskaHead(int width_px, int height_px, RunTime period);
/// @param image  8-bit BGR. @param stamp  ≥ 0
[[nodiscard]] wire::Bytes MatroskaImage(const cv::Mat& image, RunTime stamp);

}  // namespace kantaro::robot
