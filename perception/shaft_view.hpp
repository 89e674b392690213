#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/ring_contrast.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// What lies beyond a manhole's mouth, benching to the crown (thesis 5.2): what tells a mouth from
/// all other rings.
class ShaftView {
 public:
  ShaftView(const robot::Camera& camera, std::vector<Eigen::Vector3d> p_CLamp, double pipe_radius_m,
            double shaft_diameter_m);

  /// A picture, smoothed for this, and how the pipe lies in it.
  struct Sight {
    cv::Mat smooth;  ///< log brightness
    WallPose pose;
    Eigen::Vector2d light{0.0, 1.0};  ///< log brightness of the wall: level, and slope by log light
  };
  [[nodiscard]] Sight Take(const cv::Mat& log_brightness, const WallPose& pose) const;

  /// By how much the far wall of the shaft stands out [log brightness] if the mouth is at this
  /// distance: where the channel goes straight on or ends, its upright sides meet that wall, which
  /// the lamps light squarely, at the width of the pipe and up to its crown.
  struct EndWall {
    double top{}, left{}, right{};
    [[nodiscard]] double Sides() const { return std::min(left, right); }
    [[nodiscard]] double All() const;
  };
  [[nodiscard]] EndWall EndWallAt(const Sight& sight, double distance_m) const;

  /// Likewise for a channel that turns by a right angle, to the side where it stands out more: the
  /// upper edge of its outer wall, and the upright edge where its inner wall turns away.
  struct Turn {
    double outer{}, inner{};
  };
  [[nodiscard]] Turn TurnAt(const Sight& sight, double distance_m) const;

  /// By how much brighter [log] the picture is than a wall would be there; NaN where nothing is
  /// seen.
  [[nodiscard]] double Excess(const Sight& sight, const PipeWall& wall, double distance_m,
                              const Eigen::Vector2d& direction) const {
    return Look(sight, wall, distance_m, direction) - Expected(sight, distance_m, direction);
  }

  /// By how much brighter [log] it gets across a ring inwards than along a wall.
  [[nodiscard]] double Jump(const Sight& sight, double distance_m) const;

 private:
  [[nodiscard]] double WallLight(const WallPose& pose, double distance_m,
                                 const Eigen::Vector2d& direction) const;
  [[nodiscard]] double Expected(const Sight& sight, double distance_m,
                                const Eigen::Vector2d& direction) const;
  [[nodiscard]] double Look(const Sight& sight, const PipeWall& wall, double distance_m,
                            const Eigen::Vector2d& direction) const;

  robot::Camera camera_;
  std::vector<Eigen::Vector3d> p_CLamp_;
  double pipe_radius_m_, shaft_diameter_m_, ring_px_m_;
};

}  // namespace kantaro::perception
