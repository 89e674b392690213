#pragma once

#include <array>
#include <memory>
#include <string>

#include "robot/description.hpp"
#include "sim/contact.hpp"
#include "sim/ground.hpp"
#include "sim/robot_model.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {

/// Where the robot stands when a run begins: on its wheels at a place in a pipe.
struct StartPose {
  std::string pipe;
  double chainage_m{};  ///< of the base's origin
  bool facing_downstream{true};
  double roll_rad{};  ///< turned around the pipe's axis
  double yaw_rad{};   ///< turned to the left
};

/// The robot's body in the sewer: dynamics and contact, no sensors.
class Physics {
 public:
  /// The field must outlive the physics. Without a ground, it is the same everywhere: as the
  /// options say, or dry plastic.
  Physics(const VoidField& field, const robot::Description& description,
          const PhysicsOptions& options, GroundAt ground = {});

  /// Puts the robot on its wheels, lets the springs settle for a second with braked wheels, and
  /// sets time to zero.
  /// @throws std::out_of_range for an unknown pipe; std::invalid_argument where the robot does not
  /// fit.
  void Place(const Sewer& sewer, const StartPose& start);

  /// Wheel speeds to reach [rad/s]; limited by the motors.
  void Drive(double left_rad_s, double right_rad_s);
  /// One time step. @throws MujocoError if MuJoCo warns, of an instability say.
  void Step();

  [[nodiscard]] double time_s() const { return data_->time; }
  [[nodiscard]] double timestep_s() const { return model_->opt.timestep; }
  [[nodiscard]] Eigen::Isometry3d PoseOfBase() const;       ///< X_WB
  [[nodiscard]] Eigen::Vector3d VelocityOfBase() const;     ///< of B's origin, in W
  [[nodiscard]] std::array<double, 4> WheelAngles() const;  ///< in the order of Description::wheels
  /// What the motors give, at the wheels [Nm], and how fast these turn [rad/s]; same order.
  [[nodiscard]] std::array<double, 4> MotorTorques() const;
  [[nodiscard]] std::array<double, 4> WheelSpeeds() const;
  [[nodiscard]] Eigen::Vector3d AngularVelocity() const;  ///< of B in W, in B (the gyro's truth)
  [[nodiscard]] Eigen::Vector3d SpecificForce() const;    ///< in B (the accelerometer's truth)
  /// Whether a box of this link (by name) overlaps the wall now.
  [[nodiscard]] bool Touches(const std::string& link) const;
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }

 private:
  /// Least distance of the wheels' treads to the wall in the present pose, negative if one
  /// overlaps.
  [[nodiscard]] double WheelClearance();
  /// Gives each wheel and box the friction of what it touches, and wheels the resistance and the
  /// lift of the water they stand in.
  void FeelGround();
  void StandOn(int geom, const Footing& footing);
  void ForgetGround();

  struct Wheel {
    int geom{}, body{}, joint{};
    WadingWheel wading;
  };

  const VoidField& field_;
  const robot::Description description_;
  const PhysicsOptions options_;
  const GroundAt ground_;
  ModelPointer model_;
  DataPointer data_;
  ContactBinding binding_;
  std::array<Wheel, 4> wheels_{};
  int steps_until_ground_{};
};

}  // namespace kantaro::sim
