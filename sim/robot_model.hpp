#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <string>

#include "robot/description.hpp"

namespace kantaro::sim {

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPointer = std::unique_ptr<mjModel, DeleteModel>;
using DataPointer = std::unique_ptr<mjData, DeleteData>;

/// What the physics is told beside the robot's description.
struct PhysicsOptions {
  double timestep_s{0.002};
  double wheel_friction{0.7};           ///< tyre on wall, Coulomb
  double hull_friction{0.3};            ///< box on wall
  double rolling_resistance_m{0.0005};  ///< of a wheel: lever arm of the wall's force [m]
  double mast_height_m{};               ///< travel of the laser's mast
};

/// MuJoCo's model of the robot alone in an endless wall (one ellipsoid, see ContactBinding),
/// written from the description. Bodies and joints keep their names. @throws std::runtime_error
/// with MuJoCo's words if it refuses.
[[nodiscard]] ModelPointer BuildRobotModel(const robot::Description& description,
                                           const PhysicsOptions& options);
/// The MJCF text itself.
[[nodiscard]] std::string RobotMjcf(const robot::Description& description,
                                    const PhysicsOptions& options);

/// Pose of a link in the base with springs at rest position zero and the mast at its height.
[[nodiscard]] Eigen::Isometry3d MountPose(const robot::Description& description,
                                          const std::string& link, double mast_height_m);

}  // namespace kantaro::sim
