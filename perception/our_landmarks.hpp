#pragma once

#include <optional>
#include <vector>

#include "perception/inlet_search.hpp"
#include "perception/landmark_distance.hpp"
#include "perception/mouth_fit.hpp"
#include "perception/ring_scan.hpp"
#include "perception/tried_distance.hpp"
#include "perception/wall_motion.hpp"
#include "perception/wall_pose.hpp"

namespace kantaro::perception {

/// Follows an approach to one landmark with one camera or a pair (`ours`, docs/localisation.md).
/// How the pipe lies is found from the fall of light in the first picture kept and from the
/// wall's texture as it passes in the next ones; what speaks for the landmark at each distance is
/// added up over all pictures of both cameras.
class LandmarkTracker {
 public:
  /// @param camera      the only one, or the left one of the pair
  /// @param baseline_m  of the pair; 0 for a single camera
  LandmarkTracker(const robot::Description& description, const robot::Camera& camera,
                  double baseline_m, const LandmarkParameters& parameters, LandmarkKind kind,
                  const KnownSizes& sizes);

  /// @param brightness  rectified, of the camera's size
  /// @param right       of the right camera; empty for a single one
  void Add(const cv::Mat& brightness, const cv::Mat& right, double travel_m);
  /// How far the landmark is before the last picture of those added: at least one.
  [[nodiscard]] RangedLandmark Answer();

 private:
  struct Sight {
    cv::Mat brightness;  ///< of a left one
    cv::Mat log_brightness;
    double travel_m{};
    double right_m{};         ///< of the camera from the left one
    WallPose pose;            ///< before this camera
    double roll_rad{};        ///< of the wall against the last picture's, clockwise
    RingScan::Scanned rings;  ///< if a joint is looked for
  };

  void Scan();
  [[nodiscard]] double Ahead(const Sight& sight, double distance_m) const;
  [[nodiscard]] RangedLandmark FindJoint() const;
  [[nodiscard]] RangedLandmark FindMouth() const;
  [[nodiscard]] RangedLandmark FindInlet() const;

  robot::Camera camera_;
  LandmarkParameters parameters_;
  KnownSizes sizes_;
  double baseline_m_, camera_height_m_;
  std::vector<Eigen::Vector3d> lamps_;
  std::optional<RingScan> scan_;
  std::optional<MouthFit> mouth_;
  std::optional<InletSearch> inlet_;
  std::vector<Sight> sights_;  ///< the left camera's last one is the last
  WallMotion motion_;
};

}  // namespace kantaro::perception
