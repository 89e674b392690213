#include "perception/stereo/linear_computation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>

#include "perception/brightness.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr int kLanes = 16;

int RoundedUp(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

}  // namespace

cv::Mat FeaturePixels(const cv::Mat& image, int threshold) {
  RequireBrightness(image, "group classification");
  cv::Mat features(image.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* const in = image.ptr(y);
    std::uint8_t* const out = features.ptr(y);
    for (int x = 1; x < image.cols; ++x)
      out[x] = std::abs(in[x] - in[x - 1]) >= threshold ? 255 : 0;
  }
  return features;
}

LinearComputation::LinearComputation(const Frame& frame)
    : frame_(frame),
      left_(frame.left.cols),
      falling_(frame.left.cols),
      right_rise_(frame.left.cols + RoundedUp(frame.parameters.disparities)),
      right_fall_(right_rise_.size()),
      in_range_(RoundedUp(frame.parameters.disparities)),
      keys_(in_range_.size()) {
  std::fill_n(in_range_.begin(), frame.parameters.disparities, std::uint8_t{255});
}

void LinearComputation::StartRow(int y) {
  const std::uint8_t* const left = frame_.left.ptr(y);
  const std::uint8_t* const right = frame_.right.ptr(y);
  const int width = frame_.left.cols;
  for (int x = 1; x < width; ++x) {
    const int difference = left[x] - left[x - 1];
    left_[x] = static_cast<std::uint8_t>(std::abs(difference));
    falling_[x] = difference < 0;
  }
  for (int x = 1; x < width; ++x) {
    const int difference = right[x] - right[x - 1];
    right_rise_[width - 1 - x] = static_cast<std::uint8_t>(std::max(difference, 0));
    right_fall_[width - 1 - x] = static_cast<std::uint8_t>(std::max(-difference, 0));
  }
}

float LinearComputation::Disparity(int x, float neighbour) {
  const std::vector<std::uint8_t>& right = falling_[x] != 0 ? right_fall_ : right_rise_;
  const int first = frame_.left.cols - 1 - x + frame_.parameters.min_disparity_px;
  const int padded = static_cast<int>(keys_.size());
  const cv::v_uint8x16 steepness = cv::v_setall_u8(left_[x]);
  const cv::v_uint8x16 most = cv::v_setall_u8(255);
  // One key orders by E_d, then by |D_L − D_R|: as steep as the left pixel or more, E_d is
  // 2 |D_L| and the key falls from 255 with the excess; less steep, E_d and key grow with |D_R|.
  cv::v_uint8x16 best = cv::v_setzero_u8();
  for (int i = 0; i < padded; i += kLanes) {
    const cv::v_uint8x16 candidate = cv::v_load(right.data() + first + i);
    const cv::v_uint8x16 key =
        cv::v_select(candidate >= steepness, most - (candidate - steepness), candidate) &
        cv::v_load(in_range_.data() + i);
    cv::v_store(keys_.data() + i, key);
    best = cv::v_max(best, key);
  }
  const std::uint8_t best_key = cv::v_reduce_max(best);
  if (best_key == 0 || left_[x] == 0) return kNone;

  const float from = std::isnan(neighbour) ? 0.0F : neighbour;
  float nearest = kNone;
  const cv::v_uint8x16 wanted = cv::v_setall_u8(best_key);
  for (int i = 0; i < padded; i += kLanes) {
    auto ties = static_cast<unsigned>(cv::v_signmask(cv::v_load(keys_.data() + i) == wanted));
    for (; ties != 0; ties &= ties - 1) {
      const auto disparity =
          static_cast<float>(frame_.parameters.min_disparity_px + i + std::countr_zero(ties));
      if (!(std::abs(disparity - from) >= std::abs(nearest - from))) nearest = disparity;
    }
  }
  return nearest;
}

cv::Mat MatchLc(const Frame& frame) {
  cv::Mat disparities = frame.NoDisparities();
  LinearComputation lc(frame);
  for (int y = 0; y < frame.left.rows; ++y) {
    lc.StartRow(y);
    auto* const out = disparities.ptr<float>(y);
    for (int x = frame.max_disparity + 1; x < frame.left.cols; ++x) {
      if (lc.Difference(x) != 0) out[x] = lc.Disparity(x, out[x - 1]);
    }
  }
  return disparities;
}

}  // namespace kantaro::perception::stereo
