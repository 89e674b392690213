#include "sim/visual_mesh.hpp"

#include <Eigen/Geometry>

namespace kantaro::sim {

void ComputeNormals(VisualMesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f& p = mesh.positions[a];
    const Eigen::Vector3f area = (mesh.positions[b] - p).cross(mesh.positions[c] - p);
    for (const std::uint32_t corner : {a, b, c}) mesh.normals[corner] += area;
  }
  for (Eigen::Vector3f& normal : mesh.normals) {
    const float length = normal.norm();
    normal = length > 0.0f ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
}

}  // namespace kantaro::sim
