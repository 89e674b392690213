#pragma once

#include <deque>
#include <string>
#include <vector>

#include "navigation/map.hpp"
#include "navigation/parameters.hpp"
#include "perception/observations.hpp"
#include "robot/readings.hpp"

namespace kantaro::navigation {

/// Where the robot believes to be: on a leg of its route.
struct Estimate {
  std::size_t leg{};              ///< index into the route's legs
  double distance_m{};            ///< of the base's origin from the wall of the manhole where the leg begins
  double deviation_m{};           ///< standard deviation of the distance
  double leg_length_m{};          ///< as believed now: from the map, or as driven once the end was seen
};

/// What the executive is doing.
enum class Phase { kStarting, kDriving, kApproaching, kBackingUp, kTurning, kLeaving, kArrived, kFailed };
[[nodiscard]] std::string ToString(Phase phase);

/// Something worth telling: a landmark passed, a turn begun, a reason for stopping.
struct Event {
  robot::RunTime time{};
  enum class Kind { kLandmark, kManoeuvre, kTrouble, kArrival } kind{Kind::kLandmark};
  std::string text;
};

/// Follows a route by landmarks: a pure step from observation to command. It never calls a clock and knows no truth.
///
/// Localisation: wheel travel, corrected where the laser passes manhole walls and inlets and where joints come up in
/// the camera (thesis 4.3, 5.5). Turning: the laser at the rear sees a junction only when the robot has entered it; it
/// then backs up as far as the geometry needs and turns through the channel (thesis 5.6). Without laser, IR and
/// cameras it can only trust wheels and map, and acts at the map's distances.
class Executive {
 public:
  Executive(MapRoute route, double goal_distance_m, RobotGeometry geometry, Parameters parameters);

  /// Takes one observation; the command holds until the next.
  [[nodiscard]] robot::Command Step(const perception::Observation& observation);

  [[nodiscard]] const Estimate& estimate() const { return estimate_; }
  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] bool finished() const { return phase_ == Phase::kArrived || phase_ == Phase::kFailed; }
  /// Diameter of the pipe the robot believes to be in [m], for perception.
  [[nodiscard]] double pipe_diameter_m() const;
  /// Events since the last call, in order.
  [[nodiscard]] std::vector<Event> TakeEvents();

 private:
  MapRoute route_;
  Estimate estimate_;
  Phase phase_{Phase::kStarting};
};

}  // namespace kantaro::navigation
