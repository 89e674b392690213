#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "robot/description.hpp"
#include "robot/hardware.hpp"
#include "sim/physics.hpp"
#include "sim/ray_caster.hpp"
#include "sim/scenery.hpp"
#include "sim/sewer.hpp"
#include "sim/void_field.hpp"

namespace kantaro::sim {

/// A sewer ready to be driven, scanned and seen: contact, rays and looks, all from the same voids.
struct World {
  std::shared_ptr<const Sewer> sewer;
  std::shared_ptr<const VoidField> field;
  std::shared_ptr<const RayCaster> rays;
  std::shared_ptr<const Scenery> scenery;  ///< null in a world without cameras
  /// Null in a world that is dry plastic everywhere.
  std::shared_ptr<const SewerGround> ground;
};

/// @param texture_seed  of the walls' look. @param cameras  whether the world will be seen.
/// @param grips  what its walls offer; absent: dry plastic everywhere.
[[nodiscard]] World BuildWorld(const network::Network& network, std::uint64_t texture_seed,
                               bool cameras, const std::optional<GripTable>& grips = {});

/// What is not in the cameras' files: what calibration missed, and what happens to pictures.
struct CameraConditions {
  /// How far the right camera is truly turned about its own y axis beyond what its calibration
  /// says: positive to the right.
  double stereo_yaw_error_rad{};
  int drops_on_lens{};          ///< of water, on each; the seed scatters them
  double dropped_share{};       ///< of the frames never arrive: a Loss comes instead
  double exposure_factor{1.0};  ///< times each sensor's exposure
  double gain_factor{1.0};
};

/// What a run's seed decides about the robot and its contact with the world.
struct Conditions {
  StartPose start;
  std::uint64_t seed{};                  ///< of every sensor's noise
  std::optional<double> wheel_friction;  ///< tyre on wall, whatever the ground
  double friction_factor{1.0};           ///< times the ground's friction
  double
      left_right_mismatch{};  ///< left motors turn this share faster than told, right ones slower
  double light{1.0};          ///< LED brightness against the nominal
  CameraConditions cameras;
  double mast_diameter_m{0.300};  ///< the mast was set for this pipe
  double battery_charge{1.0};     ///< at the start, 0 to 1
  double time_limit_s{600.0};     ///< Read() ends the run here
  int render_threads{2};  ///< beside the physics, or 0: in its own; decides speed, never a result
};

/// What is really so, for the judge alone.
struct GroundTruth {
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};
  std::optional<std::size_t> pipe;  ///< index into the network's pipes if the base is in one, else
  std::optional<std::size_t> manhole;  ///< the manhole it is in
  double chainage_m{};                 ///< of the base's origin along `pipe`; 0 in a manhole
  double speed_m_s{};  ///< along the pipe's axis (in a manhole: along the robot), positive forward
                       ///< of the robot
  bool upper_box_touched{};  ///< the upper box has touched the wall since the last call of Truth()
};

/// The simulated robot in a simulated sewer, behind the robot's own interface.
///
/// Physics runs in steps of 2 ms; cameras are rendered on worker threads between capture and
/// delivery. When the battery is empty the motors stand, commands are refused and every sensor is
/// reported lost; then the run is over. One caller. Every sensor's noise has its own random stream,
/// so nothing depends on threads or on who reads what.
class Twin : public robot::Hardware {
 public:
  /// @throws RenderingUnavailable if the world has a scenery and no off-screen OpenGL can be had.
  /// @throws std::invalid_argument for sensor rates that are no whole number of physics steps.
  Twin(World world, const robot::Description& description, const Conditions& conditions);
  ~Twin() override;

  [[nodiscard]] std::optional<robot::Reading> Read() override;
  robot::CommandOutcome Apply(const robot::Command& command) override;
  void Stop() override;
  [[nodiscard]] robot::RunTime Now() const override;

  [[nodiscard]] GroundTruth Truth();
  /// Where a camera of the description, named by its link, truly is in the base: X_BC, with what
  /// its calibration missed.
  [[nodiscard]] Eigen::Isometry3d TruePoseOf(const robot::Camera& camera) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::sim
