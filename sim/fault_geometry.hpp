#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "base/random.hpp"
#include "network/network.hpp"
#include "network/pipe_axis.hpp"
#include "sim/materials.hpp"
#include "sim/visual_mesh.hpp"

namespace kantaro::sim {

/// A thing in the pipe and its look.
struct Visual {
  VisualMesh mesh;
  Look look;
};

/// What a camera sees of a fault: a crack is a jagged dark strip on the wall, roots hang from it,
/// mortar and grease stand on it. Sizes are the fault's own; the rank decides how far it stands
/// out. Rank C is small and pale, as the thesis (Table 3.1) describes it: hardly visible.
[[nodiscard]] std::vector<Visual> BuildFault(const network::PipeAxis& axis, double pipe_radius_m,
                                             const network::Fault& fault, RandomStream& random);

/// The ragged mortar, scale or dirt on both sides of a joint's groove: what makes a joint a ring to
/// a camera whose line of sight passes over the groove itself.
/// @param in_groove  whether a point lies in the joint's groove: on the inside of a deflection it
///                   reaches further than the gap.
[[nodiscard]] std::vector<Visual> BuildJointRims(
    const network::PipeAxis& axis, double pipe_radius_m, const network::Joint& joint,
    RandomStream& random, const Look& look,
    const std::function<bool(const Eigen::Vector3d& p_W)>& in_groove);

}  // namespace kantaro::sim
