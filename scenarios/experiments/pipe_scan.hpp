#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace kantaro::scenarios {

/// What a depth camera's view of a pipe says of its wall. Camera frame D: x right, y up, and the
/// camera looks along −z, as in the scans.
struct PipeScan {
  Eigen::Isometry3d X_DP{Eigen::Isometry3d::Identity()};  ///< P: x along the axis, away from D
  double radius_m{};
  std::size_t points{};   ///< given, within kNearest_m … kFarthest_m
  double inlier_share{};  ///< of them within kInlier_m of the cylinder
  double residual_m{};    ///< of the inliers from the cylinder, robust standard deviation
  double roughness_m{};   ///< of inliers from a plane through their neighbours within 10 mm
  std::vector<Eigen::Vector3d> inliers;  ///< in D
};
inline constexpr double kNearest_m = 0.12, kFarthest_m = 0.60;
inline constexpr double kInlier_m = 0.010;

/// Points of a file in PLY format, binary little endian, of vertices of double x, y, z alone.
/// @throws InputError if it is no such file
[[nodiscard]] std::vector<Eigen::Vector3d> ReadPly(const std::filesystem::path& file);

/// Fits a cylinder that runs within 0.3 rad of −z, whatever else half of the points show: the best
/// of many circles through three points, refined by least squares with Tukey's weights (1974).
/// @throws std::invalid_argument for fewer than 100 points in reach
[[nodiscard]] PipeScan FitPipe(std::span<const Eigen::Vector3d> points, std::uint64_t seed);

/// 1.4826 times the median magnitude of the deviation from the median: the standard deviation, if
/// the values are normal. 0 of none.
[[nodiscard]] double RobustDeviation(std::vector<double> values);

}  // namespace kantaro::scenarios
