#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/sewer.hpp"

namespace kantaro::sim {

/// A piece of water surface with what stands round it: enough to draw what the water mirrors and
/// what shows through it. A strip of pairs of vertices, left and right, along the way.
struct WaterSheet {
  struct Vertex {
    Eigen::Vector3f p_OV;          ///< in W's axes [m]
    Eigen::Vector3f normal;        ///< unit, upward, in W's axes
    Eigen::Vector3f wall_axis;     ///< unit, in W's axes: direction of the axis of the wall around
    Eigen::Vector3f p_VAxis;       ///< to a point of that axis, in W's axes [m]
    Eigen::Vector2f along_left_m;  ///< where the ripples are
  };
  Eigen::Vector3d p_WO{Eigen::Vector3d::Zero()};
  std::vector<Vertex> vertices;
  double wall_radius_m{};  ///< of the round wall that the water mirrors: the pipe's or the shaft's
  double bed_radius_m{};   ///< of the invert under it
  double depth_m{};        ///< over the invert
  Eigen::Vector3d p_WCentre{Eigen::Vector3d::Zero()};  ///< of a sphere around it
  double radius_m{};
};

/// The surfaces of all standing water, level across, in pieces of up to `longest_m`. In a manhole
/// they run through its channels, and over the whole floor where that lies lower.
[[nodiscard]] std::vector<WaterSheet> BuildWaterSheets(const Sewer& sewer, double longest_m);

}  // namespace kantaro::sim
