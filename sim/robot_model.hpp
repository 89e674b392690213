#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <optional>
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

/// What the physics is told beside the robot's description. What is absent follows from the place
/// where the robot stands (SewerGround), or is as on dry plastic where there is no such map.
struct PhysicsOptions {
  double timestep_s{0.002};
  std::optional<double> wheel_friction;        ///< tyre on wall, Coulomb, everywhere the same
  std::optional<double> hull_friction;         ///< box on wall
  std::optional<double> rolling_resistance_m;  ///< of a wheel: lever arm of the wall's force [m]
  double friction_factor{1.0};                 ///< times both frictions of the ground
  double mast_height_m{};                      ///< travel of the laser's mast
};
/// Tyre and hull friction and rolling resistance where nothing else is known: dry plastic.
inline constexpr double kUsualWheelFriction = 0.7;
inline constexpr double kUsualHullFriction = 0.3;
inline constexpr double kUsualRollingResistance_m = 0.0005;

/// MuJoCo's model of the robot alone in an endless wall (one ellipsoid, see ContactBinding),
/// written from the description. Bodies and joints keep their names. @throws std::runtime_error
/// with MuJoCo's words if it refuses.
[[nodiscard]] ModelPointer BuildRobotModel(const robot::Description& description,
                                           const PhysicsOptions& options);
/// The MJCF text itself.
[[nodiscard]] std::string RobotMjcf(const robot::Description& description,
                                    const PhysicsOptions& options);

/// Friction loss of a wheel's axle that stands for this rolling resistance under the robot's
/// weight, shared evenly [Nm].
[[nodiscard]] double RollingLoss_Nm(const robot::Description& description,
                                    double rolling_resistance_m);

/// Pose of a link in the base with springs at rest position zero and the mast at its height.
[[nodiscard]] Eigen::Isometry3d MountPose(const robot::Description& description,
                                          const std::string& link, double mast_height_m);

}  // namespace kantaro::sim
