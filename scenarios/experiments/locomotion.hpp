#pragma once

#include <cstdint>
#include <string>

#include "robot/description.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/experiments/locomotion_course.hpp"

namespace kantaro::scenarios {

/// What a random start changes.
struct LocomotionStart {
  double chainage_m{};  ///< along the pipe, added
  double lateral_m{};   ///< along the wall, to the left
  double yaw_rad{};
  double friction_factor{1.0};
  double mismatch{};  ///< left wheels turn this share faster, right ones slower
};
/// Start number `run` of a row. Depends on nothing but its arguments.
[[nodiscard]] LocomotionStart DrawStart(std::uint64_t seed, const std::string& row,
                                        std::size_t run);

struct LocomotionOutcome {
  bool passed{};
  std::string
      reason;      ///< what stopped it: "stuck in manhole "M"", "rolled over at 1.2 m of "in"", …
  bool touched{};  ///< whether the upper box touched a wall on the way
};
/// Drives one course open loop until the goal, until the robot leans by 60° or until the
/// profile ends.
[[nodiscard]] LocomotionOutcome DriveCourse(const robot::Description& description,
                                            const Course& course, const Profile& profile,
                                            double tyre_friction, const LocomotionStart& start);

/// `kantaro experiment locomotion`: is the claim of thesis 2.7 true of the twin? The robot drives
/// open loop through every case, in 200, 250 and 300 mm (350 mm reported), wet and dry, from random
/// starts.
[[nodiscard]] Experiment LocomotionExperiment();

}  // namespace kantaro::scenarios
