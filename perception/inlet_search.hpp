#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/branch_mouth.hpp"
#include "perception/landmark_distance.hpp"
#include "perception/tried_distance.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// A picture in which an inlet is looked for.
struct InletSight {
  cv::Mat log_brightness;  ///< as LogBrightness makes it
  WallPose pose;           ///< before this camera
  double roll_rad{};       ///< of the wall against the last picture's, clockwise
  double ahead_m{};        ///< of where distances count from, along the axis
  double right_m{};        ///< of the camera, from the one whose lamps are known
};

/// Finds a side inlet's mouth, of known diameter (docs/localisation.md): what each place would look
/// like is worked out from the lamps' places, and compared with a whole wall there.
class InletSearch {
 public:
  /// @param p_CLamp  lamps in the camera's frame (LampsBefore)
  /// @param left     the side on which the inlet lies
  /// @param far_m    beyond 1 m a mouth is a few pixels wide: none is looked for
  InletSearch(const robot::Camera& camera, const std::vector<Eigen::Vector3d>& p_CLamp,
              const KnownSizes& sizes, bool left, double near_m, double far_m);

  /// What speaks for each place is added up over all pictures.
  /// @pre at least one
  [[nodiscard]] RangedLandmark Find(const std::vector<InletSight>& sights) const;

 private:
  struct Place {
    double distance_m{}, angle_rad{};                ///< as BranchMouth has them
    Eigen::Vector2d off_m{Eigen::Vector2d::Zero()};  ///< of the axis from where the pose puts it
    double log_odds{};
    double paint{};  ///< of the branch against the wall's [log]
  };
  struct Samples;

  [[nodiscard]] Samples Take(const std::vector<InletSight>& smooth, const Place& place) const;
  [[nodiscard]] std::vector<Place> SearchAll(const std::vector<InletSight>& smooth) const;
  [[nodiscard]] static std::vector<Place> BestApart(std::vector<Place> places);
  [[nodiscard]] Place Refine(Place best, const std::function<double(Place&)>& score) const;
  void Judge(const std::vector<InletSight>& smooth, Place& place) const;
  [[nodiscard]] double Outline(const std::vector<InletSight>& smooth, const Place& place) const;
  [[nodiscard]] BranchMouth MouthIn(const InletSight& sight, const Place& place) const;

  robot::Camera camera_;
  BranchedPipe pipe_;
  bool left_;
  double near_m_, far_m_;
};

}  // namespace kantaro::perception
