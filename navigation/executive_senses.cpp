// What the executive makes of each observation.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "navigation/executive.hpp"

namespace kantaro::navigation {
namespace {

using perception::LaserWindow;
using robot::RunTime;
using robot::Seconds;
using robot::Sensor;

constexpr RunTime kTravelMemory(static_cast<RunTime::rep>(kTravelMemory_s * 1e9));
/// A mouth is believed once it came nearer as the robot did over so many images, 0.1 m of way.
constexpr std::size_t kMouthSightings = 5;

}  // namespace

void Executive::See(const perception::OdometryObservation& odometry) {
  health_.Hear(Sensor::kEncoders, odometry.captured_at);
  if (finished()) return;
  if (const auto wrong = wheels_.Feel(odometry.captured_at, odometry.travel_m))
    return Enter(Phase::kFailed, *wrong);
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
  health_.Hear(Sensor::kInertial, attitude.captured_at);
  if (attitude_) {
    const double step_s = Seconds(attitude.captured_at - attitude_->captured_at);
    heading_rad_ += (attitude.yaw_rate_rad_s - yaw_bias_.rad_s()) * step_s;
  }
  attitude_ = attitude;
  // Well inside a pipe the walls keep the robot from turning.
  if (phase_ == Phase::kDriving && !end_wall_seen_ &&
      localiser_.distance_m() > -geometry_.laser_x_m) {
    yaw_bias_.Learn(attitude.captured_at, attitude.yaw_rate_rad_s);
    roll_bias_.Learn(attitude.captured_at, attitude.roll_rate_rad_s);
  }
}

void Executive::See(const perception::InclinationObservation& inclination) {
  health_.Hear(Sensor::kInclinometer, inclination.captured_at);
  inclined_rad_ = inclination.roll_rad;
}

void Executive::See(const perception::BatteryObservation& battery) {
  health_.Hear(Sensor::kBattery, battery.captured_at);
  if (finished() || battery.charge >= parameters_.battery_reserve) return;
  Enter(Phase::kFailed,
        fmt::format("the battery is down to {:.1f} % of its charge", 100.0 * battery.charge));
}

void Executive::See(const perception::LossObservation& loss) {
  using Cause = perception::LossObservation::Cause;
  // A reading that is missing or impossible now and then is no matter; a sensor that brings nothing
  // else falls silent.
  if (loss.cause != Cause::kLineDown && loss.cause != Cause::kStuck) return;
  if (!health_.Lose(loss.sensor, loss.captured_at) || finished()) return;
  Report(Event::Kind::kTrouble,
         fmt::format("{}: {}", robot::ToString(loss.sensor),
                     loss.cause == Cause::kStuck ? "says the same again and again" : "lost"));
}

void Executive::See(const perception::LaserObservation& laser) {
  if (Stale(laser.captured_at)) return;
  health_.Hear(Sensor::kLaser, laser.captured_at);
  // The top first: whether a side belongs to a junction depends on it.
  for (const perception::WindowEdge& edge : laser.edges) {
    if (edge.window == LaserWindow::kTop) SeeTop(edge);
  }
  for (const perception::WindowEdge& edge : laser.edges) {
    if (edge.window != LaserWindow::kTop) SeeSide(edge);
  }
  WatchOpening(Sensor::kLaser, top_open_);
}

void Executive::WatchOpening(Sensor sensor, bool open) {
  auto& since_m = sensor == Sensor::kLaser ? laser_open_since_m_ : infrared_open_since_m_;
  if (!open) since_m.reset();
  if (open && !since_m && !travel_.empty()) since_m = travel_.back().second;
}

void Executive::SeeTop(const perception::WindowEdge& edge) {
  const double since_m = TravelSince(edge.at);
  top_open_ = edge.open;
  if (edge.open) {
    SeeEndWall(geometry_.laser_x_m, since_m, Sensor::kLaser);
  } else if (phase_ == Phase::kBackingUp) {
    // Out of the manhole again, backwards: this is where the wall is, however the wheels slip.
    localiser_.Doubt(parameters_.reverse_slip *
                     std::abs(travel_.back().second - rolled_before_backing_m_));
    localiser_.SeeEndWall(geometry_.laser_x_m - since_m, parameters_.wall_error_m);
  } else if (TakeBackEndWall(Sensor::kLaser)) {
    // an inlet
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
    if (!top_open_ && width_m < parameters_.longest_inlet_m)
      SeeInlet(left, since_m + 0.5 * width_m);
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
  if (Stale(infrared.captured_at)) return;
  health_.Hear(Sensor::kInfrared, infrared.captured_at);
  if (infrared.manhole && !infrared_up_) {
    SeeEndWall(geometry_.infrared_x_m, TravelSince(infrared.captured_at), Sensor::kInfrared);
  } else if (!infrared.manhole && infrared_up_) {
    TakeBackEndWall(Sensor::kInfrared);
  }
  infrared_up_ = infrared.manhole;
  WatchOpening(Sensor::kInfrared, infrared_up_);
  // The laser, where there is one, decides about junctions (thesis 5.6), unless the robot meets the
  // far wall before the laser at its rear can reach them.
  const bool side = Leg().turn_rad > 0.0 ? infrared.junction_left : infrared.junction_right;
  const bool decides = Silent(Sensor::kLaser) || !Leg().straight_on;
  if (TurnsHere() && end_wall_seen_ && infrared.manhole && side && decides) junction_seen_ = true;
}

void Executive::SeeEndWall(double sensor_x_m, double travelled_since_m, Sensor sensor) {
  if (phase_ == Phase::kTurning || phase_ == Phase::kBackingUp) return;
  const Localiser before = localiser_;
  if (!localiser_.SeeEndWall(sensor_x_m - travelled_since_m, parameters_.wall_error_m)) return;
  if (!end_wall_seen_) {
    heading_rad_ = 0.0;
    uncertain_wall_ = {before, travel_.empty() ? 0.0 : travel_.back().second, sensor};
  } else if (uncertain_wall_ && uncertain_wall_->sensor != sensor) {
    uncertain_wall_.reset();
  }
  end_wall_seen_ = true;
  Report(
      Event::Kind::kLandmark,
      fmt::format("{}: manhole {}", sensor == Sensor::kLaser ? "laser" : "IR", Leg().end_manhole));
}

bool Executive::TakeBackEndWall(Sensor sensor) {
  if (!uncertain_wall_ || uncertain_wall_->sensor != sensor || phase_ != Phase::kDriving)
    return false;
  const double rolled_m = travel_.back().second - uncertain_wall_->wheel_travel_m;
  const bool inlet = localiser_.scale() * rolled_m < parameters_.longest_inlet_m;
  if (inlet) {
    localiser_ = uncertain_wall_->before;
    localiser_.Advance(rolled_m);
    end_wall_seen_ = false;
    Report(Event::Kind::kTrouble, fmt::format("no manhole: an opening of {:.2f} m in the crown",
                                              localiser_.scale() * rolled_m));
  }
  uncertain_wall_.reset();
  return inlet;
}

void Executive::See(const perception::RingObservation& rings) {
  if (phase_ != Phase::kDriving || travel_.empty() || Stale(rings.captured_at)) return;
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

}  // namespace kantaro::navigation
