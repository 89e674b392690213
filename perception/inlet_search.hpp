#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/landmark_distance.hpp"
#include "perception/shaft_view.hpp"
#include "perception/tried_distance.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// A picture in which an inlet is looked for.
struct InletSight {
  cv::Mat log_brightness;  ///< as LogBrightness makes it
  WallPose pose;           ///< before this camera
  double ahead_m{};        ///< of where distances count from, along the axis
};

/// Finds a side inlet's mouth, the curve where the pipe's wall and a branch of known diameter meet
/// (docs/localisation.md).
class InletSearch {
 public:
  /// @param p_CLamp  lamps in the camera's frame (LampsBefore)
  /// @param left     the side on which the inlet lies
  InletSearch(const robot::Camera& camera, const std::vector<Eigen::Vector3d>& p_CLamp,
              const KnownSizes& sizes, bool left, double nearest_m);

  /// What speaks for each place is added up over all pictures.
  [[nodiscard]] RangedLandmark Find(const std::vector<InletSight>& sights) const;

 private:
  /// A mouth and how the pipe lies about it.
  struct Fit {
    double distance_m{}, angle_rad{};  ///< about the axis: 0 to the right, a quarter turn downwards
    Eigen::Vector2d off_m{Eigen::Vector2d::Zero()};  ///< of the axis from where the pose puts it
    double score{};
  };
  struct Sight {
    const InletSight& picture;
    ShaftView::Sight light;
  };

  [[nodiscard]] double Darkness(const std::vector<Sight>& sights, const Fit& fit) const;
  [[nodiscard]] double ScoreOf(const std::vector<Sight>& sights, const Fit& fit) const;
  [[nodiscard]] Fit Refine(const std::vector<Sight>& sights, Fit best) const;

  robot::Camera camera_;
  KnownSizes sizes_;
  bool left_;
  double nearest_m_;
  ShaftView light_;
};

}  // namespace kantaro::perception
