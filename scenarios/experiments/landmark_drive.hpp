#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "network/network.hpp"
#include "perception/observations.hpp"
#include "robot/description.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {

/// What a straight drive passes: the kinds of Table 5.3, and what the table does not know.
enum class PassedKind {
  kJoints,     ///< no landmark: a pipe with its joints
  kManhole,    ///< benched to the crown, the pipe goes straight on
  kInletLeft,  ///< of 100 or 150 mm, as the robot drives
  kInletRight,
  kJunctionLeft,  ///< a manhole with a branch of the pipe's own diameter
  kJunctionRight,
  kCross,  ///< branches on both sides: status 5
};

/// One way past one landmark. The line driven runs along +Wx and the landmark's middle is at x = 0.
struct LandmarkCourse {
  PassedKind kind{};
  perception::LaserStatus status{};  ///< what Table 5.3 calls it
  network::Network network;
  sim::StartPose start;
  double half_length_m{};  ///< of the landmark: an inlet's or a shaft's radius
  double end_x_m{};        ///< of the laser: all is passed there
};

/// @param downstream  whether the robot drives the way the pipes are drawn
/// @param inlet_m  diameter of an inlet, and where it enters as the robot drives [clock hours from
/// 3 or 9 up, positive]
[[nodiscard]] LandmarkCourse MakeLandmarkCourse(PassedKind kind, double diameter_m, bool downstream,
                                                double inlet_m = 0.100, double inlet_up_h = 0.0);

/// What is drawn for one drive.
struct LandmarkDriveConditions {
  std::uint64_t seed{};
  double roll_rad{};  ///< the robot is started, and steers to stay, so far up the wall
  double yaw_rad{};   ///< at the start
  double laser_right_m{}, laser_up_m{};  ///< the scanner's place off its own: mast and mount askew
  double wheel_friction{0.5};
};

/// Where the robot truly was.
struct RobotPlace {
  double time_s{};
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};
};

/// One drive, as it truly was: where the robot stood at every reading.
struct LandmarkDrive {
  std::vector<RobotPlace> places;
  bool arrived{};  ///< the laser came past `end_x_m` in time
  /// Of the laser's mirror in the base, as it was mounted.
  Eigen::Vector3d p_BL{Eigen::Vector3d::Zero()};

  /// World x of a point of the base, linear between readings; the ends hold beyond them.
  /// @throws std::invalid_argument if there are no places
  [[nodiscard]] double XAt(const Eigen::Vector3d& p_BP, double time_s) const;
};

/// Drives past at 15 cm/s on the twin, physics, wheels and sensors and all, without cameras.
/// Steering keeps the roll that was asked for by what the inertial unit says, as the executive
/// does, and across a manhole the heading: which of both, the robot's true place tells.
/// @param hear  gets every reading in its order
/// @param grips  what walls of each material are like; without it all are dry plastic to infrared
/// sensors. Wheels find `conditions.wheel_friction` on any.
[[nodiscard]] LandmarkDrive DrivePast(const robot::Description& description,
                                      const LandmarkCourse& course,
                                      const LandmarkDriveConditions& conditions,
                                      const std::function<void(const robot::Reading&)>& hear,
                                      const std::optional<sim::GripTable>& grips = {});

}  // namespace kantaro::scenarios
