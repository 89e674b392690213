#pragma once

#include <functional>
#include <vector>

#include "sim/grip.hpp"
#include "sim/void_field.hpp"
#include "sim/water.hpp"

namespace kantaro::sim {

/// What lies under a point of the wall.
struct Footing {
  Grip grip;
  double water_m{};  ///< depth of the water over the point
};

/// What lies under a point on the wall, or a few millimetres off it.
using GroundAt = std::function<Footing(const Eigen::Vector3d& p_W)>;

/// The ground of a sewer: pipes as their material and condition say, manholes concrete in the worst
/// condition of the pipes that end in them; beds are sediment, and all else that stands in a pipe
/// is like concrete, in the pipe's condition. Under water everything is wet at least.
class SewerGround {
 public:
  /// @param field  of this sewer. Both must outlive the ground.
  SewerGround(const Sewer& sewer, const VoidField& field, const GripTable& grips);

  /// As GroundAt.
  [[nodiscard]] Footing operator()(const Eigen::Vector3d& p_W) const;

 private:
  struct Surface {
    Ground ground{};
    network::WallCondition condition{};
  };
  static Surface PartSurface(const network::Network& network, const Part& part);

  const VoidField& field_;
  /// What is underfoot where this void's wall would be.
  [[nodiscard]] Ground GroundIn(const VoidPrimitive& primitive, const Nearby& nearby,
                                const Eigen::Vector3d& p_W) const;

  const Sewer& sewer_;
  GripTable grips_;
  Water water_;
  std::vector<Surface> surfaces_;  ///< by part
};

}  // namespace kantaro::sim
