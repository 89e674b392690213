#include "perception/brightness.hpp"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <stdexcept>

namespace kantaro::perception {

cv::Mat Brightness(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("the image is empty");
  if (image.type() != CV_8UC3) {
    throw std::invalid_argument(fmt::format("an 8-bit BGR image is wanted, this one is {}",
                                            cv::typeToString(image.type())));
  }
  cv::Mat brightness;
  cv::transform(image, brightness, cv::Matx13f(0.1F, 0.6F, 0.3F));
  return brightness;
}

void RequireBrightness(const cv::Mat& image, const char* what) {
  if (image.empty()) throw std::invalid_argument(fmt::format("{}: the image is empty", what));
  if (image.type() != CV_8UC1) {
    throw std::invalid_argument(fmt::format("{}: an 8-bit image of one channel is wanted, not {}",
                                            what, cv::typeToString(image.type())));
  }
}

}  // namespace kantaro::perception
