#pragma once

#include <optional>
#include <vector>

#include "perception/landmark_distance.hpp"
#include "perception/ring_scan.hpp"
#include "perception/wall_pose.hpp"

namespace kantaro::perception {

/// A distance and how far it may be off, before calibration.
struct RangedLandmark {
  double distance_m{};
  double deviation_m{};
  double significance{};
};

/// Follows an approach to one landmark with one camera (`ours`, docs/localisation.md). The wall's
/// pose is found in each picture; what speaks for the landmark at each distance is added up over
/// the pictures, which odometry lays over each other; what is found is measured in each of them.
class LandmarkTracker {
 public:
  LandmarkTracker(const robot::Description& description, const robot::Camera& camera,
                  const LandmarkParameters& parameters, LandmarkKind kind, const KnownSizes& sizes);

  /// @param brightness  rectified, of the camera's size. @returns nothing if nothing is seen
  [[nodiscard]] std::optional<RangedLandmark> Update(const cv::Mat& brightness, double travel_m);

  /// Pose of the wall in the last picture.
  [[nodiscard]] const WallPose& pose() const { return pose_; }

 private:
  struct Sight {
    double travel_m{};
    WallPose pose;
    RingScan::Scanned rings;  ///< unless an inlet is looked for
    cv::Mat log_brightness;   ///< for inlets
  };

  /// A side inlet's mouth: where the pipe's wall and a branch of known diameter meet.
  struct InletFit {
    double distance_m{}, angle_rad{};  ///< about the axis: 0 to the right, a quarter turn downwards
    Eigen::Vector2d off_m{Eigen::Vector2d::Zero()};  ///< of the axis from where the pose puts it
    double score{};
  };

  [[nodiscard]] double ScoreOf(const InletFit& fit) const;
  [[nodiscard]] std::optional<RangedLandmark> FindRing() const;
  [[nodiscard]] std::optional<RangedLandmark> FindInlet() const;
  [[nodiscard]] double StepOverLine(double distance_m) const;
  [[nodiscard]] double ScoreAt(double distance_m, bool mouth) const;

  robot::Camera camera_;
  LandmarkParameters parameters_;
  LandmarkKind kind_;
  KnownSizes sizes_;
  double camera_height_m_;
  std::vector<Eigen::Vector3d> lamps_;
  std::optional<RingScan> scan_;
  std::vector<Sight> sights_;
  WallPose pose_;
};

}  // namespace kantaro::perception
