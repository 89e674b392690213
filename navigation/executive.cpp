#include "navigation/executive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kantaro::navigation {
namespace {

using perception::LaserWindow;
using robot::RunTime;
using robot::Seconds;

constexpr RunTime kTravelMemory = std::chrono::seconds(2);
/// A mouth is believed once it came nearer as the robot did over so many images, 0.1 m of way.
constexpr std::size_t kMouthSightings = 5;
/// The robot stands in its goal once the laser is so far inside.
constexpr double kArrivalMargin_m = 0.02;
/// An inlet is passed within so much; a window open for longer belongs to a junction.
constexpr double kLongestInlet_m = 0.35;

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
                 start_distance_m, parameters) {}

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
  if (!finished()) Decide();
  const Drive drive = Act();
  const double wheel_rad_s = drive.speed_m_s / geometry_.tyre_radius_m;
  return {wheel_rad_s * (1.0 - drive.steer), wheel_rad_s * (1.0 + drive.steer), 1.0};
}

// ---- what the sensors say ----

void Executive::See(const perception::OdometryObservation& odometry) {
  if (!travel_.empty()) {
    const double rolled_m = odometry.travel_m - travel_.back().second;
    localiser_.Advance(phase_ == Phase::kTurning ? ProgressInTurn_m() : rolled_m);
  }
  travel_.emplace_back(odometry.captured_at, odometry.travel_m);
  while (travel_.front().first + kTravelMemory < odometry.captured_at) travel_.pop_front();
}

double Executive::ProgressInTurn_m() const {
  const double way_m = geometry_.front_axle_x_m + parameters_.turn_lead_m +
                       Leg().channel_radius_m * std::abs(Leg().turn_rad);
  const double share = std::clamp(heading_rad_ / Leg().turn_rad, 0.0, 1.0);
  return std::max(0.0, turn_began_m_ + share * way_m - localiser_.distance_m()) /
         localiser_.scale();
}

void Executive::See(const perception::AttitudeObservation& attitude) {
  if (attitude_)
    heading_rad_ +=
        attitude.yaw_rate_rad_s * Seconds(attitude.captured_at - attitude_->captured_at);
  attitude_ = attitude;
}

void Executive::See(const perception::LaserObservation& laser) {
  laser_heard_ = laser.captured_at;
  // The top first: whether a side belongs to a junction depends on it.
  for (const perception::WindowEdge& edge : laser.edges) {
    if (edge.window == LaserWindow::kTop) SeeTop(edge);
  }
  for (const perception::WindowEdge& edge : laser.edges) {
    if (edge.window != LaserWindow::kTop) SeeSide(edge);
  }
}

void Executive::SeeTop(const perception::WindowEdge& edge) {
  const double since_m = TravelSince(edge.at);
  top_open_ = edge.open;
  if (edge.open) {
    SeeEndWall(geometry_.laser_x_m, since_m, "laser");
  } else if (localiser_.SeeStartWall(-geometry_.laser_x_m + since_m, parameters_.wall_error_m)) {
    Report(Event::Kind::kLandmark, fmt::format("laser: entered pipe {}", Leg().pipe));
  } else if (!TurnsHere() && !OnLastLeg() && end_wall_seen_ &&
             geometry_.laser_x_m - since_m - localiser_.to_end_m() > Leg().end_shaft_radius_m) {
    // Straight across: the top closes where the next pipe begins. Short of the middle it has only
    // flickered.
    BeginNextLeg(-geometry_.laser_x_m + since_m, parameters_.wall_error_m);
    Report(Event::Kind::kLandmark, fmt::format("laser: entered pipe {}", Leg().pipe));
  }
}

void Executive::SeeSide(const perception::WindowEdge& edge) {
  const double since_m = TravelSince(edge.at);
  const bool left = edge.window == LaserWindow::kLeft;
  auto& opened = left ? side_opened_left_ : side_opened_right_;
  if (edge.open) {
    opened = WheelTravelAt(edge.at);
    // Before the end wall was passed an open top is that of the manhole where the leg began.
    if (top_open_ && end_wall_seen_) {
      Report(Event::Kind::kLandmark,
             fmt::format("laser: junction to the {}", left ? "left" : "right"));
      if (TurnsHere() && left == (Leg().turn_rad > 0.0)) junction_seen_ = true;
    }
  } else if (opened) {
    // The middle of the opening passed the laser halfway between its edges.
    const double width_m = localiser_.scale() * (WheelTravelAt(edge.at) - *opened);
    if (!top_open_ && width_m < kLongestInlet_m) SeeInlet(left, since_m + 0.5 * width_m);
    opened.reset();
  }
}

void Executive::SeeInlet(bool left, double passed_m) {
  const LandmarkKind kind = left ? LandmarkKind::kInletLeft : LandmarkKind::kInletRight;
  for (const MapLandmark& landmark : Leg().landmarks) {
    if (landmark.kind == kind &&
        localiser_.SeeLandmark(landmark.distance_m, geometry_.laser_x_m - passed_m,
                               parameters_.inlet_error_m)) {
      Report(Event::Kind::kLandmark,
             fmt::format("laser: inlet on the {}", left ? "left" : "right"));
      return;
    }
  }
}

void Executive::See(const perception::IrObservation& infrared) {
  infrared_heard_ = infrared.captured_at;
  if (infrared.manhole && !infrared_up_) {
    SeeEndWall(geometry_.infrared_x_m, TravelSince(infrared.captured_at), "IR");
  }
  infrared_up_ = infrared.manhole;
  // The laser, where there is one, decides about junctions (thesis 5.6), unless the robot meets the
  // far wall before the laser at its rear can reach them.
  const bool side = Leg().turn_rad > 0.0 ? infrared.junction_left : infrared.junction_right;
  const bool decides = Silent(laser_heard_) || !Leg().straight_on;
  if (TurnsHere() && end_wall_seen_ && infrared.manhole && side && decides) junction_seen_ = true;
}

void Executive::SeeEndWall(double sensor_x_m, double travelled_since_m, const char* sensor) {
  if (phase_ == Phase::kTurning || phase_ == Phase::kBackingUp) return;
  if (!localiser_.SeeEndWall(sensor_x_m - travelled_since_m, parameters_.wall_error_m)) return;
  if (!end_wall_seen_) heading_rad_ = 0.0;
  end_wall_seen_ = true;
  Report(Event::Kind::kLandmark, fmt::format("{}: manhole {}", sensor, Leg().end_manhole));
}

void Executive::See(const perception::RingObservation& rings) {
  if (phase_ != Phase::kDriving || travel_.empty()) return;
  const double since_m = TravelSince(rings.captured_at);
  for (const ScaleSighting& scale : rings_.Follow(rings.rings, WheelTravelAt(rings.captured_at))) {
    localiser_.SeeScale(scale.scale, scale.deviation);
  }
  for (const perception::RingSighting& ring : rings.rings) {
    const double ahead_m = geometry_.camera_x_m + ring.distance_m - since_m;
    // The images of one ring err alike: many of them tell no more than one does, or a wall that
    // laser and IR touch would no longer be believed against the camera.
    const double error_m =
        parameters_.ring_error_m * std::max(1.0, ring.distance_m * ring.distance_m);
    if (ring.kind == perception::RingKind::kManholeMouth) {
      if (!end_wall_seen_ && !mouths_deceive_ && rings_.TimesSeen(ring) >= kMouthSightings &&
          localiser_.to_end_deviation_m() > error_m) {
        mouth_believed_ = localiser_.SeeEndWall(ahead_m, error_m) || mouth_believed_;
      }
      continue;
    }
    if (const MapLandmark* joint = JointAt(localiser_.distance_m() + ahead_m)) {
      if (localiser_.to_landmark_deviation_m(joint->distance_m) > error_m) {
        localiser_.SeeLandmark(joint->distance_m, ahead_m, error_m);
      }
    }
  }
}

const MapLandmark* Executive::JointAt(double distance_m) const {
  const MapLandmark* nearest = nullptr;
  double least_m = std::numeric_limits<double>::infinity();
  double second_m = least_m;
  for (const MapLandmark& landmark : Leg().landmarks) {
    if (landmark.kind != LandmarkKind::kJoint) continue;
    const double expected_m = landmark.distance_m / Leg().length_m * localiser_.length_m();
    const double error_m = std::abs(distance_m - expected_m);
    second_m = std::min(second_m, std::max(error_m, least_m));
    if (error_m >= least_m) continue;
    least_m = error_m;
    nearest = &landmark;
  }
  if (nearest == nullptr) return nullptr;
  // One joint looks like the next: beyond half their spacing it could be either.
  const double half_spacing_m = 0.5 * (least_m + second_m);
  const double deviation_m = localiser_.to_landmark_deviation_m(nearest->distance_m);
  return Gate(deviation_m) < half_spacing_m ? nearest : nullptr;
}

// ---- what follows from it ----

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

bool Executive::Silent(const std::optional<RunTime>& heard) const {
  return Seconds(now_ - heard.value_or(RunTime{})) > parameters_.silence_s;
}

bool Executive::Blind() const { return Silent(laser_heard_) && Silent(infrared_heard_); }

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
  side_opened_left_.reset();
  side_opened_right_.reset();
}

void Executive::Decide() {
  switch (phase_) {
    case Phase::kDriving:
      DecideDriving();
      break;
    case Phase::kBackingUp:
      if (localiser_.distance_m() <= TurnStart_m()) Steer();
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
    if (beyond_m > -geometry_.laser_x_m + kArrivalMargin_m) {
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
    Enter(Phase::kBackingUp,
          fmt::format("{} manhole {}: back up by {:.2f} m",
                      junction_seen_ ? "junction confirmed in" : "past the bend in",
                      Leg().end_manhole, back_m));
  } else if (back_m >= 0.0) {
    Steer();
  }
}

void Executive::Steer() {
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
  const double roll = attitude_ ? attitude_->roll_rad : 0.0;
  const double roll_rate = attitude_ ? attitude_->roll_rate_rad_s : 0.0;
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
      const double steer = inside ? Clamp(-parameters_.heading_gain * heading_rad_, 0.5) : upright;
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
