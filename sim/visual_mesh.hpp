#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace kantaro::sim {

/// Triangles that a camera sees, counter-clockwise from the side they are seen from. Vertices are
/// single precision about an origin near them: a real network's coordinates run to hundreds of
/// kilometres.
struct VisualMesh {
  Eigen::Vector3d p_WO{Eigen::Vector3d::Zero()};  ///< origin [m]
  std::vector<Eigen::Vector3f> positions;         ///< p_OV, in W's axes [m]
  std::vector<Eigen::Vector3f> normals;           ///< unit, in W's axes
  std::vector<Eigen::Vector2f> texture;  ///< texture coordinates, in periods of the texture
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Normals as the area-weighted mean of the triangles at each vertex.
void ComputeNormals(VisualMesh& mesh);

}  // namespace kantaro::sim
