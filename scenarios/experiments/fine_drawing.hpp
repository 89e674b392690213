#pragma once

#include <opencv2/core/mat.hpp>

#include "sim/renderer.hpp"

namespace kantaro::scenarios {

/// The renderer looks at one point of each pixel. A joint's groove 1.4 m ahead is 0.3 px wide: it
/// would be drawn as dots, or not at all, where a camera sees a faint ring. Pictures that are
/// measured in are therefore drawn this many times as large, and the light averaged over pixels.
inline constexpr int kFineness = 3;

/// The renderer's options for FineDrawing of views up to this size.
[[nodiscard]] sim::RendererOptions FineOptions(const sim::RendererOptions& options);

/// As Renderer::Render, each pixel the mean light of kFineness² points.
/// @throws std::invalid_argument as Renderer::Render does
[[nodiscard]] cv::Mat FineDrawing(sim::Renderer& renderer, const sim::CameraView& view,
                                  const sim::Lamps& lamps);

/// Mean light of squares of `times` by `times` pixels, levels being those of sim::Response.
/// @param image  8-bit BGR, width and height multiples of times. @throws std::invalid_argument
[[nodiscard]] cv::Mat MeanLight(const cv::Mat& image, int times);

}  // namespace kantaro::scenarios
