#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "perception/chamber_model.hpp"
#include "perception/wall_pose.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// Holds what is seen of a manhole ahead against what its geometry and the robot's lamps would show
/// if the mouth were at a given distance. Lamps throw no shadows there: they sit about the camera.
class MouthFit {
 public:
  MouthFit(const robot::Camera& camera, const std::vector<Eigen::Vector3d>& p_CLamp,
           double pipe_radius_m, double shaft_diameter_m);

  [[nodiscard]] double shaft_diameter_m() const { return shaft_diameter_m_; }

  /// What is tried.
  struct Mouth {
    double distance_m{};  ///< along the axis, from the camera
    ChamberModel::Channel channel{};
    double roll_rad{};  ///< of the manhole against the camera, clockwise as it is seen
  };

  /// Where to look: between two places of an endless pipe's wall, equally dense in the logarithm of
  /// their distance and round the wall above the water.
  struct Grid {
    double near_m{}, far_m{};
    double step{};  ///< share
    int directions{};
  };

  /// A picture's light, smoothed for points close together, and for such as are far apart.
  struct Picture {
    cv::Mat fine, coarse;
  };
  /// @param log_brightness  as LogBrightness makes it
  [[nodiscard]] static Picture Smooth(const cv::Mat& log_brightness);

  /// How bright the wall is.
  struct Light {
    Eigen::Vector2d line;  ///< log brightness: level, and slope by the logarithm of light
    double usual{};        ///< deviation from there
  };
  /// @param right_m  of the camera from the left one, whose lamps are known
  [[nodiscard]] Light Measure(const Picture& picture, const WallPose& pose, double right_m) const;

  /// Pixels, and what they would show of an endless pipe. Cells of the grid: one row for each
  /// direction, one column for each distance.
  struct Points {
    Light light;
    double right_m{};                       ///< of the camera from the left one
    Eigen::Vector3d camera_P, lamp_P;       ///< as in ChamberModel; lamp: the middle of all
    std::vector<Eigen::Vector3d> ray_C;     ///< of each point
    std::vector<Eigen::Vector3d> wall_P;    ///< there
    std::vector<Eigen::Index> cell;         ///< column times directions, and direction
    Eigen::ArrayXf seen;                    ///< log brightness
    Eigen::ArrayXf lens;                    ///< share of light that the lens passes
    Eigen::ArrayXf log_along;               ///< logarithm of the distance along the axis
    Eigen::ArrayXf arriving, brightness;    ///< the light that comes from there; what it makes
    Eigen::ArrayX4f along, around;          ///< of each column: shares of neighbours that it mixes
    Eigen::ArrayXXf all_along, all_around;  ///< sum of shares, by cell; 0 where there is no point
  };
  [[nodiscard]] Points Take(const Picture& picture, const WallPose& pose, double right_m,
                            const Light& light, const Grid& grid) const;
  /// The same pixels with a pose a little off from where it was: edges move, while what the wall
  /// shows stays, for its shades would draw the pose to where they fit better.
  void Stand(Points& points, const WallPose& pose) const;

  /// By how many usual deviations each point is brighter than expected, but for a level and slopes
  /// of each surface's own; and how likely these are.
  struct Rest {
    Eigen::ArrayXf off;
    double against{};  ///< half a sum of squares
    /// Mean over all points of how much less likely they are than if they were as expected.
    [[nodiscard]] double Misfit() const;
  };
  /// @param sharp  without what lens, motion and smoothing mix: quicker
  [[nodiscard]] Rest Compare(const Points& points, const Mouth& mouth, bool sharp) const;

 private:
  robot::Camera camera_;
  Eigen::Vector3d p_CLamp_;
  double pipe_radius_m_, shaft_diameter_m_;
  ChamberModel model_;
};

}  // namespace kantaro::perception
