#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "perception/stereo/stereo.hpp"

namespace kantaro::scenarios {

/// A stereo matcher under test.
struct StereoMethod {
  std::string name;     ///< as perception.yaml names it, or stereobm, stereosgbm
  std::string variant;  ///< what departs from the parameters, "" for nothing
  enum class Pictures {
    kFlat,     ///< as the robot's code has them
    kFalloff,  ///< as the lens gives them, darker off its axis
    kIdeal,    ///< without lens and sensor
  } pictures{Pictures::kFlat};
  /// 8-bit images to disparities [px], CV_32F, NaN where there is none.
  std::function<cv::Mat(const cv::Mat& left, const cv::Mat& right)> match;
};

/// Every method of perception/stereo with these parameters, in order, then OpenCV's two over the
/// same disparities: StereoBM as it comes (windows of 21), StereoSGBM with windows of 5, penalties
/// 8 · 25 and 32 · 25 and the checks of OpenCV's own example. They do their own filtering.
/// @param parameters  a number of disparities that 16 divides, as OpenCV asks.
[[nodiscard]] std::vector<StereoMethod> StereoMethods(
    const perception::stereo::Parameters& parameters);
/// One method with these parameters.
[[nodiscard]] StereoMethod OneStereoMethod(perception::stereo::Parameters parameters,
                                           perception::stereo::Method method,
                                           const std::string& variant);

/// Those that `only` names; all if it names none. @throws InputError naming --only
[[nodiscard]] std::vector<StereoMethod> ChosenMethods(std::vector<StereoMethod> methods,
                                                      const std::vector<std::string>& only);

/// OpenCV on one thread for as long as this lives.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

/// How far disparities are from the true ones.
struct BadPixels {
  std::size_t pixels{};  ///< with a true disparity, that a match can have
  std::size_t answered{};
  std::size_t off_1px{}, off_2px{};  ///< by more than this, or not answered
  double error_px{};                 ///< mean over the answered
};
/// @param disparity, truth  CV_32F, NaN where there is none; of one size.
/// @param region  8-bit, 0 where a pixel does not count.
/// @throws std::invalid_argument for other types or sizes
[[nodiscard]] BadPixels CountBadPixels(const cv::Mat& disparity, const cv::Mat& truth,
                                       const cv::Mat& region);

}  // namespace kantaro::scenarios
