#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "perception/wall_pose.hpp"

namespace kantaro::perception {

/// A place on a pipe's wall: how far along the axis, and in which direction (right, down) from it.
struct WallPlace {
  double distance_m{};
  Eigen::Vector2d direction{Eigen::Vector2d::Zero()};
};

/// How a camera sees wall whose places are counted from elsewhere.
struct WallSighting {
  PipeWall wall;
  Eigen::Rotation2Dd turn;  ///< of the wall in the picture
  double ahead_m{};         ///< how much farther from the camera a place is than it counts
  double shift_px{};        ///< by which the picture is shifted to the right

  [[nodiscard]] Eigen::Vector3d PointAt(const WallPlace& place) const {
    return wall.PointAt(place.distance_m + ahead_m, turn * place.direction);
  }
  [[nodiscard]] cv::Point2d PixelOf(const Eigen::Vector3d& p_C) const {
    return wall.PixelOf(p_C) + cv::Point2d(shift_px, 0.0);
  }
  [[nodiscard]] WallPlace PlaceAt(const cv::Point2d& pixel) const;
};

/// How fine a texture is.
struct TextureScale {
  int shrink{1};          ///< pixels of the picture taken farthest off in one of the texture's
  double smooth_px{1.0};  ///< of the texture's
};

/// The same stretch of wall unrolled from any picture, as fine as the one that was taken farthest
/// off shows it. A column is a ring of wall; columns lie as rings do in that picture.
class WallGrid {
 public:
  /// Distances count along the axis from the foot of the nearest picture's camera.
  /// @param ring_px_m  focal length times the pipe's radius
  /// @param behind_m   how much farther from the wall the farthest picture was taken
  /// @pre 0 < near_m < far_m, 0 <= behind_m
  WallGrid(double ring_px_m, double behind_m, double near_m, double far_m,
           const TextureScale& scale);

  /// Places between near and far, this many of the texture's pixels apart.
  [[nodiscard]] std::vector<WallPlace> Places(int apart_px) const;
  /// What a picture shows of the wall, without the fall of light, over its scatter nearby.
  /// @param log_brightness  as LogBrightness makes it
  [[nodiscard]] cv::Mat Texture(const cv::Mat& log_brightness, const WallSighting& sighting) const;

  struct Sample {
    double value{};
    double along{}, around{};  ///< its slopes on the wall, per metre along and per radian
  };
  /// From a texture that this grid made; nothing beyond its rim.
  [[nodiscard]] std::optional<Sample> Take(const cv::Mat& texture, const WallPlace& place) const;

 private:
  [[nodiscard]] double DistanceAt(double column) const;
  [[nodiscard]] double AngleAt(double row) const;
  [[nodiscard]] cv::Mat Unroll(const cv::Mat& log_brightness, const WallSighting& sighting) const;

  TextureScale scale_;
  double ring_px_m_;  ///< in the texture's pixels
  double behind_m_;
  int pad_px_;  ///< beside what is asked for, on all sides: what means reach over
  double first_px_;
  int columns_, rows_;  ///< without what is padded above and below
};

}  // namespace kantaro::perception
