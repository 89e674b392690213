#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "robot/description.hpp"
#include "robot/readings.hpp"
#include "sim/renderer.hpp"

namespace kantaro::scenarios {

/// What the stereo cameras see of a manhole's mouth ahead, and what is really there.
struct StereoView {
  /// 8-bit brightness as the robot's code gets it: through lens and sensor, then rectified, and
  /// what it makes of that: as bright as on the lenses' axes.
  robot::StereoPair rectified, flat;
  /// What neither lens nor sensor has touched, at full light, drawn as if rectified.
  robot::StereoPair ideal;
  /// CV_32F, of the rectified left image along its optical axis; 0: nothing in reach
  cv::Mat depth_m;
  double mouth_m{};  ///< from the left camera to where the pipe ends, along the pipe
  double focal_px{}, baseline_m{};
};

/// A straight plastic pipe that ends in a manhole, with joints, dry, as in the thesis' test field;
/// the robot stands in it and looks downstream.
class StereoStage {
 public:
  /// @param texture_seed  of the wall's look
  /// @throws RenderingUnavailable
  StereoStage(const robot::Description& description, double diameter_m, std::uint64_t texture_seed);
  ~StereoStage();

  /// @param distance_m  from the left camera to the pipe's end, 0.2 to 2 m
  /// @param light       brightness of the robot's lights, 0 to 1
  /// @param stream      names the sensors' noise
  [[nodiscard]] StereoView See(double distance_m, double light, std::uint64_t seed,
                               const std::string& stream);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::scenarios
