#include "perception/panorama.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "perception/brightness.hpp"

namespace kantaro::perception {

cv::Mat UnrollRing(const cv::Mat& image, const Ring& ring, cv::Size size) {
  RequireBrightness(image, "panorama");
  if (!(ring.inner_px > 0 && ring.inner_px < ring.outer_px)) {
    throw std::invalid_argument("panorama: the radii must satisfy 0 < inner < outer");
  }
  if (size.width < 1 || size.height < 1) throw std::invalid_argument("panorama: the size is empty");
  const cv::Point2d c = ring.center_px;
  const double reach_px = ring.outer_px - 1e-6;  // rounding in FitInside
  if (!(c.x - reach_px >= 0 && c.y - reach_px >= 0 && c.x + reach_px <= image.cols - 1 &&
        c.y + reach_px <= image.rows - 1)) {
    throw std::invalid_argument("panorama: the ring leaves the image");
  }
  cv::Mat map_x(size, CV_32F), map_y(size, CV_32F);
  for (int column = 0; column < size.width; ++column) {
    const double clock_rad = 2 * std::numbers::pi * column / size.width;
    for (int row = 0; row < size.height; ++row) {
      const double radius_px = ring.outer_px - (ring.outer_px - ring.inner_px) * row / size.height;
      map_x.at<float>(row, column) = static_cast<float>(c.x + radius_px * std::sin(clock_rad));
      map_y.at<float>(row, column) = static_cast<float>(c.y - radius_px * std::cos(clock_rad));
    }
  }
  cv::Mat panorama;
  cv::remap(image, panorama, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return panorama;
}

Ring FitInside(Ring ring, cv::Size image) {
  const double high_x = image.width - 1 - ring.outer_px, high_y = image.height - 1 - ring.outer_px;
  if (!(ring.outer_px <= high_x && ring.outer_px <= high_y)) {
    throw std::invalid_argument("panorama: the ring is larger than the image");
  }
  ring.center_px.x = std::clamp(ring.center_px.x, ring.outer_px, high_x);
  ring.center_px.y = std::clamp(ring.center_px.y, ring.outer_px, high_y);
  return ring;
}

}  // namespace kantaro::perception
