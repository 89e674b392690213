#include "navigation/executive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "perception/attitude.hpp"

namespace kantaro::navigation {
namespace {

using perception::LaserWindow;
using robot::RunTime;
using robot::Seconds;
using robot::Sensor;

/// The robot stands in its goal once the laser is so far inside.
constexpr double kArrivalMargin_m = 0.02;
/// The laser sees that it has left a manhole within so much.
constexpr double kLeavingMargin_m = 0.05;
/// Between the wall of a shaft and the laser, at the rear, as far inside as the robot may go: its
/// front would touch the far wall.
constexpr double kBehindFarWall_m = 0.45;

double Clamp(double value, double limit) { return std::clamp(value, -limit, limit); }

}  // namespace

std::string ToString(Phase phase) {
  switch (phase) {
    case Phase::kDriving:
      return "driving";
    case Phase::kBackingUp:
      return "backing up";
    case Phase::kTurning:
      return "turning";
    case Phase::kLeaving:
      return "leaving the manhole";
    case Phase::kArrived:
      return "arrived";
    case Phase::kFailed:
      return "failed";
  }
  throw std::invalid_argument("no such phase");
}

Executive::Executive(MapRoute route, double start_distance_m, const RobotGeometry& geometry,
                     const Parameters& parameters)
    : route_(std::move(route)),
      geometry_(geometry),
      parameters_(parameters),
      localiser_(route_.legs.empty() ? throw std::invalid_argument("a route needs at least one leg")
                                     : route_.legs.front(),
                 start_distance_m, parameters),
      wheels_(parameters.wheel_window_s, parameters.least_wheel_share) {}

Estimate Executive::estimate() const {
  return {leg_, localiser_.distance_m(), localiser_.deviation_m(), localiser_.length_m()};
}

std::vector<Event> Executive::TakeEvents() { return std::exchange(events_, {}); }

robot::Command Executive::Step(const perception::Observation& observation) {
  std::visit(
      [this](const auto& seen) {
        now_ = std::max(now_, seen.captured_at);
        See(seen);
      },
      observation);
  if (!finished()) CheckSensors();
  if (!finished()) Decide();
  const Drive drive = Act();
  wheels_.Tell(drive.speed_m_s);
  const double wheel_rad_s = drive.speed_m_s / geometry_.tyre_radius_m;
  return {wheel_rad_s * (1.0 - drive.steer), wheel_rad_s * (1.0 + drive.steer), 1.0};
}

bool Executive::IsJunction() const {
  return Leg().end_kind != network::ManholeKind::kCurve &&
         Leg().end_kind != network::ManholeKind::kStraight;
}

double Executive::TurnStart_m() const {
  return localiser_.length_m() + Leg().StraightBeforeTurn_m() - geometry_.front_axle_x_m -
         parameters_.turn_lead_m;
}

double Executive::WheelTravelAt(RunTime time) const {
  if (travel_.empty()) return 0.0;
  const auto after = std::find_if(travel_.begin(), travel_.end(),
                                  [&](const auto& entry) { return entry.first >= time; });
  return after == travel_.end() ? travel_.back().second : after->second;
}

double Executive::TravelSince(RunTime time) const {
  return travel_.empty() ? 0.0 : localiser_.scale() * (travel_.back().second - WheelTravelAt(time));
}

bool Executive::Silent(Sensor sensor) const {
  const auto& open_since_m =
      sensor == Sensor::kLaser ? laser_open_since_m_ : infrared_open_since_m_;
  const bool sees_nothing = open_since_m && std::abs(travel_.back().second - *open_since_m) >
                                                parameters_.longest_opening_m;
  return sees_nothing || health_.Silent(sensor, now_, parameters_.silence_s);
}

bool Executive::Blind() const { return Silent(Sensor::kLaser) && Silent(Sensor::kInfrared); }

bool Executive::GyroFit() const {
  return !health_.Silent(Sensor::kInertial, now_, parameters_.gyro_silence_s) &&
         std::abs(yaw_bias_.rad_s()) <= parameters_.gyro_bias_rad_s;
}

bool Executive::CertainOfEndWall() const {
  if (!uncertain_wall_ || travel_.empty()) return true;
  const double longest_m =
      std::min(parameters_.longest_inlet_m, 2.0 * Leg().end_shaft_radius_m - kBehindFarWall_m);
  return localiser_.scale() * (travel_.back().second - uncertain_wall_->wheel_travel_m) > longest_m;
}

void Executive::Report(Event::Kind kind, const std::string& text) {
  events_.push_back({now_, kind, text});
}

void Executive::Enter(Phase phase, const std::string& why) {
  phase_ = phase;
  const Event::Kind kind = phase == Phase::kFailed    ? Event::Kind::kTrouble
                           : phase == Phase::kArrived ? Event::Kind::kArrival
                                                      : Event::Kind::kManoeuvre;
  Report(kind, why);
}

void Executive::BeginNextLeg(double distance_m, double deviation_m) {
  ++leg_;
  localiser_.Begin(Leg(), distance_m, deviation_m);
  rings_.Forget();
  end_wall_seen_ = junction_seen_ = mouth_believed_ = mouths_deceive_ = false;
  uncertain_wall_.reset();
  side_opened_left_.reset();
  side_opened_right_.reset();
}

void Executive::CheckSensors() {
  if (health_.PowerLost()) {
    Enter(Phase::kFailed, "the power has failed");
  } else if (health_.Silent(Sensor::kEncoders, now_, parameters_.wheel_silence_s)) {
    Enter(Phase::kFailed, "no word from the encoders: it does not know how far it drives");
  } else if (phase_ == Phase::kTurning && !GyroFit()) {
    Enter(Phase::kFailed, "no word from the gyro in a turn");
  }
}

void Executive::Decide() {
  switch (phase_) {
    case Phase::kDriving:
      DecideDriving();
      break;
    case Phase::kBackingUp:
      DecideBackingUp();
      break;
    case Phase::kTurning:
      DecideTurning();
      break;
    case Phase::kLeaving:
      if (localiser_.distance_m() > -geometry_.laser_x_m + Gate(parameters_.wall_error_m))
        phase_ = Phase::kDriving;
      break;
    case Phase::kArrived:
    case Phase::kFailed:
      break;
  }
}

void Executive::DecideDriving() {
  const double beyond_m = -localiser_.to_end_m();
  if (!end_wall_seen_ && !Blind()) {
    if (beyond_m > Gate(localiser_.to_end_deviation_m()) + 2.0 * Leg().end_shaft_radius_m) {
      LookForEndWallAgain();
    }
  } else if (OnLastLeg()) {
    if (beyond_m > -geometry_.laser_x_m + kArrivalMargin_m && CertainOfEndWall()) {
      Enter(Phase::kArrived, fmt::format("reached manhole {}", Leg().end_manhole));
    }
  } else if (!TurnsHere()) {
    // The laser usually begins the next leg before this.
    const double through_m = Leg().ThroughManhole_m();
    if (beyond_m > through_m - geometry_.laser_x_m + Gate(parameters_.wall_error_m)) {
      BeginNextLeg(beyond_m - through_m,
                   std::max(localiser_.to_end_deviation_m(), parameters_.wall_error_m));
    }
  } else if (junction_seen_ || !IsJunction() || Blind()) {
    BeginTurn();
  } else if (beyond_m > 2.0 * Leg().end_shaft_radius_m) {
    Enter(Phase::kFailed, fmt::format("no junction was found in manhole {}", Leg().end_manhole));
  }
}

void Executive::DecideBackingUp() {
  const double short_m = localiser_.distance_m() - TurnStart_m();
  if (short_m > 0.0) return;
  const bool should_be_out =
      TurnStart_m() + geometry_.laser_x_m < localiser_.length_m() - kLeavingMargin_m;
  if (!should_be_out || !top_open_ || Silent(Sensor::kLaser)) return Steer();
  if (short_m < -parameters_.spinning_m) {
    Enter(Phase::kFailed,
          fmt::format("backing up in manhole {}, the wheels spin: the laser is still inside",
                      Leg().end_manhole));
  }
}

void Executive::LookForEndWallAgain() {
  if (mouth_believed_ && !mouths_deceive_) {
    mouths_deceive_ = true;
    localiser_.ForgetLength();
    Report(Event::Kind::kTrouble, "camera: what looked like a manhole was none");
  } else {
    Enter(Phase::kFailed,
          fmt::format("manhole {} was not found where the map has it", Leg().end_manhole));
  }
}

void Executive::BeginTurn() {
  const double back_m = localiser_.distance_m() - TurnStart_m();
  if (back_m > Gate(parameters_.wall_error_m)) {
    rolled_before_backing_m_ = travel_.empty() ? 0.0 : travel_.back().second;
    Enter(Phase::kBackingUp,
          fmt::format("{} manhole {}: back up by {:.2f} m",
                      junction_seen_ ? "junction confirmed in" : "past the bend in",
                      Leg().end_manhole, back_m));
  } else if (back_m >= 0.0) {
    Steer();
  }
}

void Executive::Steer() {
  if (!GyroFit()) {
    return Enter(Phase::kFailed,
                 fmt::format("it cannot turn in manhole {} without a gyro", Leg().end_manhole));
  }
  heading_rad_ = 0.0;
  turn_began_m_ = localiser_.distance_m();
  rolled_before_turn_m_ = travel_.empty() ? 0.0 : travel_.back().second;
  Enter(Phase::kTurning, fmt::format("turn into the channel of manhole {}", Leg().end_manhole));
}

void Executive::DecideTurning() {
  const double turned_rad = std::copysign(1.0, Leg().turn_rad) * heading_rad_;
  const double rolled_m = travel_.empty() ? 0.0 : travel_.back().second - rolled_before_turn_m_;
  const double bend_m = Leg().channel_radius_m * std::abs(Leg().turn_rad);
  if (turned_rad < std::abs(Leg().turn_rad) - parameters_.turn_tolerance_rad) {
    // Wheels that spin far beyond the way through the manhole do not turn the robot.
    if (rolled_m > 4.0 * (Leg().ThroughManhole_m() + bend_m)) {
      Enter(Phase::kFailed, fmt::format("stuck in the turn of manhole {}", Leg().end_manhole));
    }
    return;
  }
  // Now the base's middle is about where the bend ends.
  BeginNextLeg(-Leg().StraightBeforeTurn_m(), 0.1);
  Enter(Phase::kLeaving, fmt::format("turned by {:.0f} degrees into pipe {}",
                                     turned_rad * 180.0 / std::numbers::pi, Leg().pipe));
}

Executive::Drive Executive::Act() const {
  const bool gyro =
      attitude_ && !health_.Silent(Sensor::kInertial, now_, parameters_.gyro_silence_s);
  const bool pendulum =
      inclined_rad_ && !health_.Silent(Sensor::kInclinometer, now_, parameters_.gyro_silence_s);
  // A rate that is off shifts the filter's roll by as much as it turns in its time constant.
  const double shift_rad = roll_bias_.rad_s() * perception::AttitudeFilter::kTimeConstant_s;
  const double roll = gyro ? attitude_->roll_rad - shift_rad : pendulum ? *inclined_rad_ : 0.0;
  const double roll_rate = gyro ? attitude_->roll_rate_rad_s - roll_bias_.rad_s() : 0.0;
  // Steering downhill brings the robot back to the invert; the rate term keeps it from swinging.
  const double upright =
      Clamp(-parameters_.upright_gain * roll - parameters_.upright_damping_s * roll_rate, 0.5);
  switch (phase_) {
    case Phase::kDriving: {
      const double margin_m = parameters_.approach_distance_m + localiser_.to_end_deviation_m();
      const bool near =
          !end_wall_seen_ && (TurnsHere() || OnLastLeg()) && localiser_.to_end_m() < margin_m;
      const bool inside = end_wall_seen_ && localiser_.to_end_m() < 0.1;
      // Across a manhole there is no round wall to lean on: hold the heading of its entry.
      const double hold = GyroFit() ? Clamp(-parameters_.heading_gain * heading_rad_, 0.5) : 0.0;
      const double steer = inside ? hold : upright;
      return {near || (inside && (TurnsHere() || OnLastLeg())) ? parameters_.approach_m_s
                                                               : parameters_.cruise_m_s,
              steer};
    }
    case Phase::kBackingUp:
      return {-parameters_.reverse_m_s, 0.0};
    case Phase::kTurning: {
      const double left_rad = Leg().turn_rad - heading_rad_;
      return {parameters_.turn_m_s,
              parameters_.turn_ratio * Clamp(left_rad / parameters_.turn_easing_rad, 1.0)};
    }
    case Phase::kLeaving:
      return {parameters_.approach_m_s, upright};
    case Phase::kArrived:
    case Phase::kFailed:
      break;
  }
  return {};
}

}  // namespace kantaro::navigation
