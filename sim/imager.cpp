#include "sim/imager.hpp"

#include <opencv2/imgproc.hpp>

namespace kantaro::sim {
namespace {

/// A shift between the two fields by less than this is not seen [px].
constexpr double kUnseenComb_px = 0.5;

void Remap(const cv::Mat& ideal, const RemapMaps& maps, cv::Mat& image) {
  cv::remap(ideal, image, maps.whole, maps.fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

}  // namespace

Imager::Imager(const robot::Camera& camera, const std::vector<LensDrop>& drops)
    : settings_(camera.sensor), lens_(camera, drops), sensor_(camera.sensor, lens_.transmission()) {
  FillMaps(lens_, {}, 0.0, still_);
}

cv::Mat Imager::Expose(const cv::Mat& ideal, const MotionField& field, RandomStream& noise,
                       Scratch& scratch) const {
  const cv::Mat& seen = scratch.blur.Apply(ideal, field, settings_.exposure_s);
  cv::Mat image;
  if (settings_.interlaced && field.Fastest() * kField_s > kUnseenComb_px) {
    FillMaps(lens_, field, -kField_s, scratch.maps);
    Remap(seen, scratch.maps, image);
  } else {
    Remap(seen, still_, image);
  }
  sensor_.Expose(image, noise);
  return image;
}

}  // namespace kantaro::sim
