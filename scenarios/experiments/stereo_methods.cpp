#include "scenarios/experiments/stereo_methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <stdexcept>

#include "base/input_error.hpp"

namespace kantaro::scenarios {
namespace {

using perception::stereo::Method;
using perception::stereo::Parameters;

StereoMethod OpenCvMethod(const std::string& name, const cv::Ptr<cv::StereoMatcher>& matcher) {
  return {name, "", {}, [matcher](const cv::Mat& left, const cv::Mat& right) {
            cv::Mat sixteenths, disparity;
            matcher->compute(left, right, sixteenths);
            sixteenths.convertTo(disparity, CV_32F, 1.0 / int{cv::StereoMatcher::DISP_SCALE});
            disparity.setTo(
                std::numeric_limits<float>::quiet_NaN(),
                sixteenths < matcher->getMinDisparity() * cv::StereoMatcher::DISP_SCALE);
            return disparity;
          }};
}

}  // namespace

StereoMethod OneStereoMethod(Parameters parameters, Method method, const std::string& variant) {
  parameters.method = method;
  return {ToString(method), variant, {}, [parameters](const cv::Mat& left, const cv::Mat& right) {
            return Match(left, right, parameters).disparity_px;
          }};
}

std::vector<StereoMethod> StereoMethods(const Parameters& parameters) {
  std::vector<StereoMethod> methods;
  for (const auto& [name, method] : perception::stereo::Methods())
    methods.push_back(OneStereoMethod(parameters, method, ""));
  const cv::Ptr<cv::StereoBM> block = cv::StereoBM::create(parameters.disparities);
  block->setMinDisparity(parameters.min_disparity_px);
  methods.push_back(OpenCvMethod("stereobm", block));
  constexpr int kArea = 5 * 5;
  methods.push_back(OpenCvMethod(
      "stereosgbm", cv::StereoSGBM::create(parameters.min_disparity_px, parameters.disparities, 5,
                                           8 * kArea, 32 * kArea, 1, 63, 10, 100, 32)));
  return methods;
}

std::vector<StereoMethod> ChosenMethods(std::vector<StereoMethod> methods,
                                        const std::vector<std::string>& only) {
  const auto named = [&](const std::string& name) {
    return std::any_of(methods.begin(), methods.end(),
                       [&](const StereoMethod& method) { return method.name == name; });
  };
  for (const std::string& name : only) {
    if (named(name)) continue;
    std::string known;
    for (const StereoMethod& method : methods) {
      if (method.variant.empty()) known += (known.empty() ? "" : ", ") + method.name;
    }
    throw InputError("--only", {}, "",
                     fmt::format("\"{}\" is no method; known are {}", name, known));
  }
  if (only.empty()) return methods;
  std::erase_if(methods, [&](const StereoMethod& method) {
    return std::find(only.begin(), only.end(), method.name) == only.end();
  });
  return methods;
}

OneThread::OneThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
OneThread::~OneThread() { cv::setNumThreads(before_); }

BadPixels CountBadPixels(const cv::Mat& disparity, const cv::Mat& truth, const cv::Mat& region) {
  if (disparity.type() != CV_32FC1 || truth.type() != CV_32FC1 || region.type() != CV_8UC1 ||
      disparity.size() != truth.size() || disparity.size() != region.size())
    throw std::invalid_argument("bad pixels: the maps do not fit each other");
  BadPixels bad;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      const float real = truth.at<float>(y, x), found = disparity.at<float>(y, x);
      if (region.at<std::uint8_t>(y, x) == 0 || std::isnan(real)) continue;
      ++bad.pixels;
      const double error_px = std::abs(found - real);
      bad.off_1px += error_px <= 1.0 ? 0 : 1;
      bad.off_2px += error_px <= 2.0 ? 0 : 1;
      if (std::isnan(found)) continue;
      ++bad.answered;
      bad.error_px += error_px;
    }
  }
  if (bad.answered > 0) bad.error_px /= static_cast<double>(bad.answered);
  return bad;
}

}  // namespace kantaro::scenarios
