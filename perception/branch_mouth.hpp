#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// A pipe with a branch that leaves it squarely, and the lamps that light both.
struct BranchedPipe {
  double pipe_radius_m{}, branch_radius_m{};
  std::vector<Eigen::Vector3d> p_CLamp;  ///< before a pair's left camera (LampsBefore)
};

/// What a pinhole sees of a branch's mouth: the curve where pipe and branch meet, and through it
/// the branch's far wall, which faces the camera where the pipe's own is seen at a flat angle.
class BranchMouth {
 public:
  /// @param right_m     of the camera, from the one for which the lamps are given
  /// @param distance_m  of the branch's axis, along the pipe's
  /// @param angle_rad   about the pipe's axis: 0 to the right, a quarter turn downwards
  /// @param pipe        outlives this
  BranchMouth(const robot::Camera& camera, const BranchedPipe& pipe, const WallPose& pose,
              double right_m, double distance_m, double angle_rad);

  /// A pixel, and the logarithms of light that even walls of one paint would send back to it.
  struct Spot {
    cv::Point2d pixel;
    double wall{};    ///< were the pipe whole
    double branch{};  ///< inside the mouth: of what is behind it
  };
  /// @param along, across  of the branch's axis, along the pipe and about it, in the branch's radii
  /// @returns nothing beside or behind the camera
  [[nodiscard]] std::optional<Spot> At(double along, double across) const;

 private:
  [[nodiscard]] double LogLight(const Eigen::Vector3d& p_C, const Eigen::Vector3d& normal) const;

  const BranchedPipe& pipe_;
  double focal_px_, right_m_;
  cv::Point2d center_px_;
  Eigen::Vector3d along_, out_, across_;  ///< of the pipe, of the branch, and square to both
  Eigen::Vector3d p_CM_;                  ///< where the two axes meet
};

}  // namespace kantaro::perception
