#pragma once

#include "robot/description.hpp"

namespace kantaro::robot {

/// The body a URDF describes. A subset of URDF is accepted, and nothing else: links with one
/// inertial and boxes, cylinders and spheres; joints fixed, continuous or prismatic; no meshes,
/// materials or transmissions.
struct UrdfBody {
  std::string name;
  std::vector<Link> links;    ///< depth first, parents before children
  std::vector<Joint> joints;  ///< joints[i] moves links[i + 1]
};

/// @throws InputError
[[nodiscard]] UrdfBody ParseUrdf(const SourceText& urdf);

}  // namespace kantaro::robot
