#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "robot/description.hpp"
#include "robot/hardware.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {

/// Where the robot stands when a run begins: on its wheels at a place in a pipe.
struct StartPose {
  std::string pipe;
  double chainage_m{};        ///< of the base's origin
  bool facing_downstream{true};
  double roll_rad{};          ///< turned around the pipe's axis
  double yaw_rad{};           ///< turned to the left
};

/// What a run's seed decides about the world.
struct Conditions {
  StartPose start;
  std::uint64_t seed{};              ///< of every noise and of the texture
  double wheel_friction{0.7};        ///< tyre on wall
  double left_right_mismatch{};      ///< left motors turn this share faster than told, right ones slower
  double light{1.0};                 ///< LED brightness, 1 nominal
  double mast_diameter_m{0.300};     ///< the pipe the mast was set for
  double time_limit_s{600.0};        ///< Read() ends the run here
  bool cameras{true};                ///< false: no images are rendered or delivered (physics alone)
  int render_threads{2};             ///< beside the physics; decides speed, never a result
};

/// What is really so, for the judge alone.
struct GroundTruth {
  robot::RunTime time{};
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};
  std::optional<std::size_t> pipe;       ///< index into the network's pipes if the base is in one, else
  std::optional<std::size_t> manhole;    ///< the manhole it is in
  double chainage_m{};                   ///< of the base's origin along `pipe`; 0 in a manhole
  double speed_m_s{};                    ///< along the pipe's axis (in a manhole: along the robot), positive forward of the robot
  bool upper_box_touches{};              ///< the upper box has touched the wall since the last call of Truth()
};

/// The simulated robot in a simulated sewer, behind the robot's own interface.
///
/// Physics runs in steps of 2 ms; cameras are rendered on worker threads between capture and delivery. One caller.
/// @throws RenderingUnavailable from the constructor if cameras are wanted and no off-screen OpenGL can be had.
class Twin : public robot::Hardware {
 public:
  Twin(std::shared_ptr<const Sewer> sewer, const robot::Description& description, const Conditions& conditions);
  ~Twin() override;

  [[nodiscard]] std::optional<robot::Reading> Read() override;
  void Apply(const robot::Command& command) override;
  [[nodiscard]] robot::RunTime Now() const override;

  [[nodiscard]] GroundTruth Truth();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::sim
