#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "robot/description.hpp"

namespace kantaro::perception {

/// A joint: a band of the wall around this distance along the pipe, its brightness scaled.
struct ViewedJoint {
  double distance_m{};
  double width_m{0.008};
  double brightness{0.4};
};

/// A dark crack along the pipe.
struct ViewedCrack {
  double clock_h{};
  double near_m{}, far_m{};
  double width_m{0.005};  ///< around the wall
};

/// What a reference ray tracer draws: a straight pipe seen from inside, the light at the camera.
/// All along pipe coordinates Q: x right, y down, z along the axis, origin beside the camera on the
/// axis.
struct PipeView {
  double radius_m{0.150};
  double camera_right_m{}, camera_down_m{};  ///< camera off the axis
  double camera_ahead_m{};                   ///< camera beyond the origin
  double yaw_rad{}, pitch_rad{};             ///< camera turned to the right, and up
  std::vector<ViewedJoint> joints{};
  std::optional<double> mouth_m{};  ///< pipe ends here in a manhole of 0.8 m, benching to the crown
  std::vector<ViewedCrack> cracks{};
  double texture{0.05};  ///< relative speckle of the wall, patches of 8 mm
  double noise{1.0};     ///< grey levels, standard deviation
  std::uint64_t noise_seed{1};
};

/// The robot's front camera: 704 x 480, 60° across.
[[nodiscard]] robot::Camera FrontCamera();

/// Draws it as 8-bit BGR grey. The wall at 0.5 m gets about 80 grey levels.
[[nodiscard]] cv::Mat Draw(const PipeView& view);

}  // namespace kantaro::perception
