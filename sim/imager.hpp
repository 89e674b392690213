#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "base/random.hpp"
#include "robot/description.hpp"
#include "sim/image_motion.hpp"
#include "sim/image_sensor.hpp"
#include "sim/lens_map.hpp"
#include "sim/motion_blur.hpp"

namespace kantaro::sim {

/// Makes of the renderer's sharp pinhole picture what the camera delivers: the lens' distortion,
/// vignetting and drops, the blur of its own motion, two fields if it is interlaced, shot and read
/// noise. Immutable; any thread may use it.
class Imager {
 public:
  explicit Imager(const robot::Camera& camera, const std::vector<LensDrop>& drops = {});

  /// Time from an interlaced picture's first field, its odd rows, to the second (NTSC).
  static constexpr double kField_s = 1.001 / 60.0;

  [[nodiscard]] const LensMap& lens() const { return lens_; }

  /// Memory that a thread keeps from one picture to the next.
  struct Scratch {
    RemapMaps maps;
    MotionBlur blur;
  };

  /// @param ideal  the picture of lens().ideal(), moved to where the camera is in the middle of the
  /// exposure (of the second field).
  [[nodiscard]] cv::Mat Expose(const cv::Mat& ideal, const MotionField& field, RandomStream& noise,
                               Scratch& scratch) const;

 private:
  robot::ImageSensor settings_;
  LensMap lens_;
  RemapMaps still_;
  ImageSensorModel sensor_;
};

}  // namespace kantaro::sim
