#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "robot/description.hpp"

namespace kantaro::perception {

/// How a round pipe lies before a camera (x right, y down, z forward): its axis passes the camera's
/// plane z = 0 at `off_m` and goes on in the direction (lean, 1).
struct WallPose {
  Eigen::Vector2d off_m{Eigen::Vector2d::Zero()};
  Eigen::Vector2d lean{Eigen::Vector2d::Zero()};  ///< tangents of the angles
};

/// What is in doubt of a pose.
struct PoseDoubt {
  Eigen::Matrix4d covariance{
      Eigen::Matrix4d::Zero()};  ///< of off (right, down) and lean (right, down)

  /// Covariance of where the axis is seen so far along it: tangents right and down.
  [[nodiscard]] Eigen::Matrix2d OfAxisAt(double distance_m) const;
};

/// A round pipe's wall as a pinhole sees it.
class PipeWall {
 public:
  PipeWall(const robot::Camera& camera, double pipe_radius_m, const WallPose& pose);

  /// Where the wall at a distance along the axis from the camera, in the direction (right, down)
  /// from the axis, is seen. @pre before the camera
  [[nodiscard]] cv::Point2d Project(double distance_m, const Eigen::Vector2d& direction) const;
  /// Likewise, in the camera's frame.
  [[nodiscard]] Eigen::Vector3d PointAt(double distance_m, const Eigen::Vector2d& direction) const;
  /// Where a point in the camera's frame is seen. @pre before the camera
  [[nodiscard]] cv::Point2d PixelOf(const Eigen::Vector3d& point_C) const {
    return center_px_ + focal_px_ / point_C.z() * cv::Point2d(point_C.x(), point_C.y());
  }
  /// The wall's point that a pixel sees, in the camera's frame; far away along the axis itself.
  [[nodiscard]] Eigen::Vector3d PointAt(const cv::Point2d& pixel) const;
  /// Unit vectors in the camera's frame: of the axis, and from it in a direction (right, down).
  [[nodiscard]] const Eigen::Vector3d& Along() const { return along_; }
  [[nodiscard]] Eigen::Vector3d Outward(const Eigen::Vector2d& direction) const {
    return direction.x() * right_ + direction.y() * down_;
  }
  /// The direction (right, down) from the axis in which a point of the wall lies.
  [[nodiscard]] Eigen::Vector2d DirectionOf(const Eigen::Vector3d& point_C) const;
  /// Unit vector from a point of the wall to the axis.
  [[nodiscard]] Eigen::Vector3d Inward(const Eigen::Vector3d& point_C) const;

 private:
  double focal_px_;
  cv::Point2d center_px_;
  double radius_m_;
  Eigen::Vector3d off_, along_;   ///< along: unit
  Eigen::Vector3d right_, down_;  ///< across the axis
};

/// Finds how the pipe lies from the fall of light along its wall, which lamps at known places of
/// the robot cast: no landmark is needed. Brightness is taken as an unknown smooth function (a
/// quadratic of logarithms) of the light that an even wall would send back; least squares over the
/// upper two thirds of the wall, outliers (landmarks, stains, what is no wall) weighed down.
/// @param brightness  rectified, 8-bit, one channel, of the camera's size
/// @param p_CLamp  lamps, in the camera's frame; they shine forward
/// @param camera_height_m  of the camera above the axis, where the robot usually drives
[[nodiscard]] WallPose FindWallPose(const cv::Mat& brightness, const robot::Camera& camera,
                                    const std::vector<Eigen::Vector3d>& p_CLamp,
                                    double pipe_radius_m, double camera_height_m);

/// How well that is known, on views for training: best where the axis is some way ahead.
[[nodiscard]] PoseDoubt DoubtOfLight();

/// The lamps of a robot in a camera's rectified frame.
[[nodiscard]] std::vector<Eigen::Vector3d> LampsBefore(const robot::Description& description,
                                                       const robot::Camera& camera);

}  // namespace kantaro::perception
