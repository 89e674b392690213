#include "sim/imager.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kantaro::sim {
namespace {

/// Motion by less than this is not seen [px]: in an exposure, where 1.5 spread an edge less than
/// lens and pixel do (1.5²/12 is 0.19 px², theirs 0.25 and more), and between two fields.
constexpr double kUnseenBlur_px = 1.5;
constexpr double kUnseenComb_px = 0.5;
constexpr int kMostTaps = 8;

void Remap(const cv::Mat& ideal, const RemapMaps& maps, cv::Mat& image) {
  cv::remap(ideal, image, maps.whole, maps.fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

void Add(const cv::Mat& tap, std::vector<std::uint16_t>& sum) {
  const auto* from = tap.ptr<std::uint8_t>();
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] = static_cast<std::uint16_t>(sum[i] + from[i]);
}

void Divide(const std::vector<std::uint16_t>& sum, int count, cv::Mat& image) {
  auto* to = image.ptr<std::uint8_t>();
  const auto inverse = static_cast<std::uint32_t>(65536 / count);
  for (std::size_t i = 0; i < sum.size(); ++i)
    to[i] = static_cast<std::uint8_t>((sum[i] * inverse + 32768U) >> 16U);
}

}  // namespace

Imager::Imager(const robot::Camera& camera, const std::vector<LensDrop>& drops)
    : settings_(camera.sensor), lens_(camera, drops), sensor_(camera.sensor, lens_.transmission()) {
  FillMaps(lens_, {}, 0.0, 0.0, still_);
}

cv::Mat Imager::Expose(const cv::Mat& ideal, const MotionField& field, RandomStream& noise,
                       Scratch& scratch) const {
  cv::Mat image;
  const double between_s = settings_.interlaced ? kField_s : 0.0;
  if (field.Fastest() * settings_.exposure_s <= kUnseenBlur_px &&
      field.Fastest() * between_s <= kUnseenComb_px) {
    Remap(ideal, still_, image);
  } else {
    Blur(ideal, field, image, scratch);
  }
  sensor_.Expose(image, noise);
  return image;
}

void Imager::Blur(const cv::Mat& ideal, const MotionField& field, cv::Mat& image,
                  Scratch& scratch) const {
  const double way_px = field.Fastest() * settings_.exposure_s;
  const int taps =
      way_px <= kUnseenBlur_px ? 1 : std::clamp(static_cast<int>(std::ceil(way_px)), 2, kMostTaps);
  const double odd_rows_s = settings_.interlaced ? -kField_s : 0.0;
  // As far apart as gives their times the variance of the exposure's, T²/12.
  const double apart_s =
      taps == 1 ? 0.0 : settings_.exposure_s / std::sqrt(static_cast<double>(taps * taps - 1));
  const auto expose = [&](int tap, cv::Mat& to) {
    const double time_s = apart_s * (tap - 0.5 * (taps - 1));
    FillMaps(lens_, field, time_s, odd_rows_s, scratch.maps);
    Remap(ideal, scratch.maps, to);
  };
  expose(0, image);
  if (taps == 1) return;
  scratch.sum.assign(3 * image.total(), 0);
  Add(image, scratch.sum);
  for (int tap = 1; tap < taps; ++tap) {
    expose(tap, scratch.tap);
    Add(scratch.tap, scratch.sum);
  }
  Divide(scratch.sum, taps, image);
}

}  // namespace kantaro::sim
