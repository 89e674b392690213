#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/wall_pose.hpp"

namespace kantaro::perception {

/// A picture of a stretch of wall that others show too.
struct WallSight {
  cv::Mat log_brightness;  ///< as LogBrightness makes it
  double travel_m{};       ///< odometry along the pipe
  double right_m{};        ///< of the camera from the left one, along the pictures' rows
};

/// How a robot sways: by how much the pipe's pose before the left camera changes, and the wall
/// turns clockwise in its picture, on a power of a metre of odometry's travel.
struct WallSway {
  WallPose pose;
  double roll_rad{};
};

/// What the wall's texture tells when it passes.
struct WallMotion {
  WallPose pose;                 ///< before the left camera, when the last picture was taken
  double travel_scale{1.0};      ///< true travel by that of odometry
  double turned_px{};            ///< by which the right camera's pictures are shifted to the right
  std::array<WallSway, 2> sway;  ///< on a metre, and on its square
  PoseDoubt doubt;               ///< of the pose

  /// What has changed so much travel after the last picture: below 0 for those before it.
  [[nodiscard]] WallSway SwayAt(double travel_m) const;
  /// Before the left camera, likewise.
  [[nodiscard]] WallPose PoseAt(double travel_m) const;
};

/// Finds how the pipe lies from its texture: only with the right axis do all pictures put each
/// speck of the wall in one place. Levenberg and Marquardt's steps on brightness, from smooth to
/// sharp; what is no wall (a shaft, a landmark's hollow, reflections) is weighed down.
/// @param sights  in the order they were taken; the last one, of the left camera, is where the pose
///                is asked; the robot sways gently up to there
/// @param start   where to begin, and where to stay if the wall shows no texture
[[nodiscard]] WallMotion FollowWall(const robot::Camera& camera, double pipe_radius_m,
                                    const std::vector<WallSight>& sights, const WallPose& start);

/// The pose before a camera this far to the right of the one that it is known for.
[[nodiscard]] WallPose SeenFrom(const WallPose& pose, double right_m);

}  // namespace kantaro::perception
