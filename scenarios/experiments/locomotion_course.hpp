#pragma once

#include <string>
#include <vector>

#include "network/network.hpp"
#include "sim/physics.hpp"

namespace kantaro::scenarios {

/// A stretch of a driving profile: both sides' tread speeds, held for a while.
struct ProfileStep {
  double duration_s{};
  double left_m_s{}, right_m_s{};
};
/// Open loop: a function of time alone.
using Profile = std::vector<ProfileStep>;
[[nodiscard]] double Duration_s(const Profile& profile);

/// One case of the locomotion experiment in one diameter: a small sewer and the way through it.
struct Course {
  network::Network network;
  sim::StartPose start;
  std::string goal_pipe;     ///< where the robot is to arrive …
  double goal_chainage_m{};  ///< … its base's origin beyond this, driving downstream
};

/// A case: its profile is the same in every diameter and condition.
struct LocomotionCase {
  std::string name;
  std::string what;  ///< one line for the page of results
  Profile profile;
  std::vector<double> diameters_m;  ///< of the pipe where it starts
  Course (*course)(double diameter_m);
  bool required{true};  ///< up to 300 mm; others are reported
};

/// All cases, in the order of the table.
[[nodiscard]] const std::vector<LocomotionCase>& LocomotionCases();

}  // namespace kantaro::scenarios
