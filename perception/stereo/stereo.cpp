#include "perception/stereo/stereo.hpp"

#include <fmt/format.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "perception/stereo/cooperative.hpp"
#include "perception/stereo/fast.hpp"
#include "perception/stereo/frame.hpp"
#include "perception/stereo/linear_computation.hpp"
#include "perception/stereo/semi_global.hpp"
#include "perception/stereo/window_matching.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr std::array<std::pair<const char*, Method>, 10> kMethods{
    {{"ssd-plain", Method::kSsdPlain},
     {"ssd", Method::kSsd},
     {"gradient", Method::kGradient},
     {"ncc", Method::kNcc},
     {"lc", Method::kLc},
     {"cooperative", Method::kCooperative},
     {"fast-nearest", Method::kFastNearest},
     {"fast-linear", Method::kFastLinear},
     {"fast-cubic", Method::kFastCubic},
     {"ours", Method::kOurs}}};

void Require(bool holds, const char* demand) {
  if (!holds) throw std::invalid_argument(fmt::format("stereo matching: {}", demand));
}

void RequireRanges(const Parameters& p) {
  // Written so that a NaN fails.
  Require(p.min_disparity_px >= 0 && p.min_disparity_px <= 4096,
          "min_disparity_px must be 0 to 4096");
  Require(p.disparities >= 1 && p.disparities <= kMostDisparities, "disparities must be 1 to 256");
  Require(p.window_px % 2 == 1 && p.window_px >= 3 && p.window_px <= kMaxWindow_px,
          "window_px must be odd, 3 to 11");
  Require(p.gaussian_window_px % 2 == 1 && p.gaussian_window_px >= 1 && p.gaussian_window_px <= 31,
          "gaussian_window_px must be odd, 1 to 31");
  Require(p.gaussian_px > 0 && p.gaussian_px <= 100, "gaussian_px must be above 0, at most 100");
  Require(p.least_deviation >= 0 && p.least_deviation <= 255, "least_deviation must be 0 to 255");
  Require(p.feature_threshold >= 1 && p.feature_threshold <= 255,
          "feature_threshold must be 1 to 255");
  Require(p.peak_ratio >= 0 && p.peak_ratio <= 1e6, "peak_ratio must be 0 to 1e6");
  Require(p.neighbour_threshold_px >= 0 && p.neighbour_threshold_px <= 1e6,
          "neighbour_threshold_px must be 0 to 1e6");
  Require(p.ssd_scale > 0 && p.ssd_scale <= 1e6, "ssd_scale must be above 0, at most 1e6");
  Require(p.gradient_scale > 0 && p.gradient_scale <= 1e6,
          "gradient_scale must be above 0, at most 1e6");
  Require(p.corner_support >= 0 && p.corner_support <= 8, "corner_support must be 0 to 8");
  Require(p.steepest_wall >= 0 && p.steepest_wall <= 1e3, "steepest_wall must be 0 to 1000");
}

std::string TypeOf(const cv::Mat& image) {
  static constexpr std::array<const char*, 8> kDepths{
      "8-bit unsigned", "8-bit signed",    "16-bit unsigned", "16-bit signed",
      "32-bit whole",   "32-bit floating", "64-bit floating", "16-bit floating"};
  return fmt::format("{} numbers in {} channel{}", kDepths[static_cast<std::size_t>(image.depth())],
                     image.channels(), image.channels() == 1 ? "" : "s");
}

void RequireImage(const cv::Mat& image, const char* which) {
  if (image.empty())
    throw std::invalid_argument(fmt::format("stereo matching: the {} image is empty", which));
  if (image.dims != 2 || image.type() != CV_8UC1) {
    throw std::invalid_argument(
        fmt::format("stereo matching: the {} image holds {}; it must hold 8-bit unsigned numbers "
                    "in 1 channel",
                    which, TypeOf(image)));
  }
}

void RequirePair(const cv::Mat& left, const cv::Mat& right, const Parameters& p) {
  RequireImage(left, "left");
  RequireImage(right, "right");
  if (left.size() != right.size()) {
    throw std::invalid_argument(
        fmt::format("stereo matching: the left image has {} x {} pixels, the right one {} x {}; "
                    "they must have the same",
                    left.cols, left.rows, right.cols, right.rows));
  }
  const int width = p.window_px + p.min_disparity_px + p.disparities - 1;
  if (left.cols < width || left.rows < p.window_px) {
    throw std::invalid_argument(fmt::format(
        "stereo matching: images of {} x {} pixels are too small; {} disparities from "
        "{} and a window of {} need {} x {}",
        left.cols, left.rows, p.disparities, p.min_disparity_px, p.window_px, width, p.window_px));
  }
}

/// The thesis' Gaussian; 8-bit fixed point in OpenCV, so the same on every machine.
cv::Mat Smoothed(const cv::Mat& image, const Parameters& p) {
  if (p.gaussian_window_px == 1) return image;
  cv::Mat smoothed;
  cv::GaussianBlur(image, smoothed, {p.gaussian_window_px, p.gaussian_window_px}, p.gaussian_px,
                   p.gaussian_px, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  return smoothed;
}

}  // namespace

std::span<const std::pair<const char*, Method>> Methods() { return kMethods; }

const char* ToString(Method method) {
  for (const auto& [name, value] : kMethods) {
    if (value == method) return name;
  }
  throw std::invalid_argument("stereo matching: no such method");
}

std::optional<Method> MethodNamed(std::string_view name) {
  for (const auto& [known, value] : kMethods) {
    if (name == known) return value;
  }
  return {};
}

DisparityMap Match(const cv::Mat& left, const cv::Mat& right, const Parameters& parameters) {
  RequireRanges(parameters);
  RequirePair(left, right, parameters);
  const cv::Mat smooth_left = Smoothed(left, parameters);
  const cv::Mat smooth_right = Smoothed(right, parameters);
  const Frame frame(smooth_left, smooth_right, parameters);
  switch (parameters.method) {
    case Method::kSsdPlain:
      return {MatchPlainSsd(frame)};
    case Method::kSsd:
      return {MatchSsd(frame)};
    case Method::kGradient:
      return {MatchGradient(frame)};
    case Method::kNcc:
      return {MatchNcc(frame)};
    case Method::kLc:
      return {MatchLc(frame)};
    case Method::kCooperative:
      return {MatchCooperative(frame)};
    case Method::kFastNearest:
      return {MatchFast(frame, Interpolation::kNearest)};
    case Method::kFastLinear:
      return {MatchFast(frame, Interpolation::kLinear)};
    case Method::kFastCubic:
      return {MatchFast(frame, Interpolation::kCubic)};
    case Method::kOurs:
      return {MatchSemiGlobal(Frame(left, right, parameters))};
  }
  throw std::invalid_argument("stereo matching: no such method");
}

}  // namespace kantaro::perception::stereo
