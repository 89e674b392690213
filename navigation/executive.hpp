#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "navigation/localiser.hpp"
#include "navigation/map.hpp"
#include "navigation/parameters.hpp"
#include "navigation/rate_bias.hpp"
#include "navigation/ring_tracker.hpp"
#include "navigation/sensor_health.hpp"
#include "navigation/wheel_watch.hpp"
#include "perception/observations.hpp"
#include "robot/readings.hpp"

namespace kantaro::navigation {

/// Where the robot believes to be: on a leg of its route.
struct Estimate {
  std::size_t leg{};     ///< index into the route's legs
  double distance_m{};   ///< of the base's origin from the wall of the manhole where the leg begins
  double deviation_m{};  ///< standard deviation of the distance
  double leg_length_m{};  ///< wall to wall, as believed now; a larger distance means inside the end
                          ///< manhole
};

/// What the executive is doing.
enum class Phase { kDriving, kBackingUp, kTurning, kLeaving, kArrived, kFailed };
[[nodiscard]] std::string ToString(Phase phase);

/// Something worth telling: a landmark passed, a turn begun, a reason for stopping.
struct Event {
  enum class Kind { kLandmark, kManoeuvre, kTrouble, kArrival };
  robot::RunTime time{};
  Kind kind{Kind::kLandmark};
  std::string text;
};

/// Follows a route by landmarks: a pure step from observation to command. It calls no clock and
/// knows no truth.
///
/// Where it is: wheel travel, corrected where laser and IR pass the walls of manholes and inlets
/// and where joints and mouths come up in the camera (thesis 4.3, 5.5). How it turns at a junction:
/// the laser at the rear sees the junction only when the robot has entered it, so it backs up as
/// far as the geometry needs and then turns through the channel (thesis 5.6). At a curve, which
/// leaves no choice, it steers as soon as the front wheels reach the bend; it backs up only where
/// the manhole was found too late for that, as by the laser alone. In a pipe it keeps itself
/// upright by steering against its roll.
///
/// It makes a turn only where laser or IR confirms the manhole. With both silent nothing can; then
/// it trusts wheels and map and acts at the map's distances.
///
/// Sensors fail. Without encoders, or with encoders that do not do as the wheels are told, it
/// stops. It turns only with a gyro, whose bias it learns along the pipes; the inclinometer stands
/// in for its roll. Laser, IR and camera may go: what hangs, comes too late or sees no crown for
/// longer than any manhole is wide is not believed. Where it stops, it says why.
class Executive {
 public:
  /// @param start_distance_m  of the base's origin from the start manhole's wall along the first
  /// leg, as set down.
  /// @throws std::invalid_argument for a route without legs.
  Executive(MapRoute route, double start_distance_m, const RobotGeometry& geometry,
            const Parameters& parameters);

  /// Takes one observation, in order of arrival; the command holds until the next.
  [[nodiscard]] robot::Command Step(const perception::Observation& observation);

  [[nodiscard]] Estimate estimate() const;
  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] bool finished() const {
    return phase_ == Phase::kArrived || phase_ == Phase::kFailed;
  }
  [[nodiscard]] const MapRoute& route() const { return route_; }
  /// Diameter of the pipe the robot believes to be in [m], for perception.
  [[nodiscard]] double pipe_diameter_m() const { return Leg().diameter_m; }
  /// Events since the last call, in order.
  [[nodiscard]] std::vector<Event> TakeEvents();

 private:
  /// Steering as a share of the speed: the left wheels run at (1 − s) times it, the right at (1 +
  /// s).
  struct Drive {
    double speed_m_s{};
    double steer{};
  };

  void See(const perception::OdometryObservation& odometry);
  void See(const perception::LaserObservation& laser);
  void See(const perception::IrObservation& infrared);
  void See(const perception::RingObservation& rings);
  void See(const perception::FaultObservation&) {}
  void See(const perception::AttitudeObservation& attitude);
  void See(const perception::InclinationObservation& inclination);
  void See(const perception::BatteryObservation& battery);
  void See(const perception::LossObservation& loss);

  void SeeTop(const perception::WindowEdge& edge);
  void SeeSide(const perception::WindowEdge& edge);
  void SeeEndWall(double sensor_x_m, double travelled_since_m, robot::Sensor sensor);
  /// The crown is back behind an opening as long as an inlet: the end wall was none. @returns
  /// whether that is so
  bool TakeBackEndWall(robot::Sensor sensor);
  /// Keeps account of how long a sensor has seen no crown.
  void WatchOpening(robot::Sensor sensor, bool open);
  /// The mapped joint at a distance of the leg; null where the next one may as well be meant.
  [[nodiscard]] const MapLandmark* JointAt(double distance_m) const;
  void SeeInlet(bool left, double passed_m);

  /// Fails where it cannot go on.
  void CheckSensors();
  void Decide();
  void DecideDriving();
  void DecideBackingUp();
  void DecideTurning();
  /// Steers into the channel at its bend's start, and goes back there first if that lies behind.
  void BeginTurn();
  void Steer();
  /// The end wall is overdue. If the camera said where it is, the camera is no longer believed on
  /// this leg; else the mission has failed.
  void LookForEndWallAgain();
  [[nodiscard]] Drive Act() const;

  void Enter(Phase phase, const std::string& why);
  void Report(Event::Kind kind, const std::string& text);
  void BeginNextLeg(double distance_m, double deviation_m);

  [[nodiscard]] const MapLeg& Leg() const { return route_.legs[leg_]; }
  [[nodiscard]] bool OnLastLeg() const { return leg_ + 1 == route_.legs.size(); }
  [[nodiscard]] bool TurnsHere() const { return Leg().turn_rad != 0.0; }
  [[nodiscard]] bool IsJunction() const;
  /// Distance to drive, in the leg's coordinate, to where steering into the turn begins.
  [[nodiscard]] double TurnStart_m() const;
  /// Within the memory of `travel_`; the oldest before that.
  [[nodiscard]] double WheelTravelAt(robot::RunTime time) const;
  /// What to add to the distance while turning, as wheel travel. Wheels that skid round tell
  /// nothing of the way: it is taken in proportion to the heading, from the turn's start to the
  /// bend's end.
  [[nodiscard]] double ProgressInTurn_m() const;
  /// Wheel travel since an earlier time, times the learned scale.
  [[nodiscard]] double TravelSince(robot::RunTime time) const;
  /// No word from laser or IR that could be believed.
  [[nodiscard]] bool Silent(robot::Sensor sensor) const;
  [[nodiscard]] bool Stale(robot::RunTime captured_at) const {
    return robot::Seconds(now_ - captured_at) > parameters_.stale_s;
  }
  [[nodiscard]] bool GyroFit() const;
  /// The end wall has been seen by two, or the opening is too long for an inlet.
  [[nodiscard]] bool CertainOfEndWall() const;
  /// No sensor that could confirm a landmark is left.
  [[nodiscard]] bool Blind() const;
  [[nodiscard]] double Gate(double deviation_m) const {
    return parameters_.gate_deviations * deviation_m;
  }

  MapRoute route_;
  RobotGeometry geometry_;
  Parameters parameters_;

  std::size_t leg_{};
  Localiser localiser_;
  RingTracker rings_;
  Phase phase_{Phase::kDriving};
  robot::RunTime now_{};
  SensorHealth health_;
  WheelWatch wheels_;
  RateBias yaw_bias_, roll_bias_;
  std::optional<double> inclined_rad_;  ///< roll by the inclinometer
  /// Wheel travel at which laser and IR lost the crown; no value while they see it.
  std::optional<double> laser_open_since_m_, infrared_open_since_m_;
  /// Before the first sensor told of the end wall, to be taken back.
  struct UncertainWall {
    Localiser before;
    double wheel_travel_m{};
    robot::Sensor sensor{};
  };
  std::optional<UncertainWall> uncertain_wall_;
  std::deque<std::pair<robot::RunTime, double>>
      travel_;  ///< of the last two seconds: (time, wheel travel)
  std::optional<perception::AttitudeObservation> attitude_;

  bool end_wall_seen_{};   ///< by laser or IR, on this leg
  bool mouth_believed_{};  ///< the camera's word on where the leg ends, on this leg
  bool mouths_deceive_{};  ///< it was wrong, and is not taken again on this leg
  bool junction_seen_{};   ///< on the side of the turn
  bool top_open_{};        ///< to the laser, settled
  std::optional<double> side_opened_left_,
      side_opened_right_;  ///< wheel travel where the window opened
  bool infrared_up_{};
  double heading_rad_{};   ///< turned since the last manoeuvre began or, driving, since the manhole
                           ///< was entered
  double turn_began_m_{};  ///< distance at which the turn began
  double rolled_before_turn_m_{};  ///< wheel travel then
  double rolled_before_backing_m_{};
  std::vector<Event> events_;
};

}  // namespace kantaro::navigation
