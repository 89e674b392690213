#include "tests/navigation/puppet.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::navigation {
namespace {

using perception::LaserWindow;

constexpr double kStep_s = 0.01;
constexpr double kPipeRadius_m = 0.15;
constexpr double kLaserThreshold_m = 0.175;  // thesis Table 5.3
constexpr double kInletRadius_m = 0.075;
/// Steering of this share of the speed means a turn, less is keeping straight.
constexpr double kTurning = 0.3;

/// From a shaft's wall to where a branch at right angles opens to the laser on the axis: the
/// branch's channel has an inner wall of radius ρ − D/2 about (R − ρ, ρ), which leaves the line 175
/// mm beside the axis there.
double BranchOpens_m(double shaft_radius_m) {
  const double rho_m = 0.66 * shaft_radius_m;
  const double inner_m = rho_m - kPipeRadius_m;
  const double offset_m = rho_m - kLaserThreshold_m;
  return shaft_radius_m - rho_m + std::sqrt(inner_m * inner_m - offset_m * offset_m);
}

std::array<bool, 2> Branches(const network::Network& network, const MapLeg& leg) {
  const network::Manhole& manhole = network.ManholeNamed(leg.end_manhole);
  const Eigen::Vector2d in = -network::DirectionFrom(network, network.PipeNamed(leg.pipe), manhole);
  std::array<bool, 2> branches{};
  for (const std::size_t i : network.PipesAt(manhole.name)) {
    if (network.pipes[i].name == leg.pipe) continue;
    const Eigen::Vector2d out = network::DirectionFrom(network, network.pipes[i], manhole);
    const double across = in.x() * out.y() - in.y() * out.x();
    if (across > 0.7) branches[0] = true;
    if (across < -0.7) branches[1] = true;
  }
  return branches;
}

}  // namespace

Parameters ShippedParameters() {
  return ReadParameters(KANTARO_SOURCE_DIR "/models/kantaro/navigation.yaml");
}

Puppet::Puppet(const network::Network& network, const std::vector<std::string>& manholes,
               const PuppetSetup& settings)
    : setup(settings),
      truth_(MakeRoute(network, manholes, {})),
      now_(settings.begin),
      distance_m_(settings.start_distance_m) {
  for (const MapLeg& leg : truth_.legs) branches_.push_back(Branches(network, leg));
}

bool Puppet::Was(Phase phase) const {
  return std::any_of(changes_.begin(), changes_.end(),
                     [&](const Change& change) { return change.phase == phase; });
}

const Puppet::Change& Puppet::First(Phase phase) const {
  for (const Change& change : changes_) {
    if (change.phase == phase) return change;
  }
  throw std::out_of_range("the executive was never " + ToString(phase) + ":\n" + story_);
}

double Puppet::Through_m() const {
  return turning_ ? Leg().ThroughManhole_m() : 2.0 * Leg().end_shaft_radius_m;
}

bool Puppet::TopOpen(double sensor_x_m) const {
  const double at_m = distance_m_ + sensor_x_m;
  const double before_m =
      leg_ == 0 ? 2.0 * kPipeRadius_m + 0.5 : truth_.legs[leg_ - 1].ThroughManhole_m();
  const bool in_start = at_m > -before_m && at_m < 0.0;
  const bool in_end = at_m > Leg().length_m && at_m < Leg().length_m + Through_m();
  const bool in_inlet = leg_ == 0 && std::abs(at_m - setup.crown_inlet_m) < kInletRadius_m;
  return (setup.tops_open && (in_start || in_end)) || in_inlet;
}

bool Puppet::SideOpen(double sensor_x_m, bool left) const {
  const double at_m = distance_m_ + sensor_x_m;
  for (const MapLandmark& landmark : Leg().landmarks) {
    if (landmark.kind == (left ? LandmarkKind::kInletLeft : LandmarkKind::kInletRight) &&
        std::abs(at_m - landmark.distance_m) < kInletRadius_m) {
      return true;
    }
  }
  const double opens_m = BranchOpens_m(Leg().end_shaft_radius_m);
  const double beyond = at_m - Leg().length_m;
  return setup.side_walls_open && !turning_ && branches_[leg_][left ? 0 : 1] && beyond > opens_m &&
         beyond < 2.0 * Leg().end_shaft_radius_m - opens_m;
}

double Puppet::Heading_rad() const {
  if (!turning_) return 0.0;
  const double bent_rad = (beyond_m() - Leg().StraightBeforeTurn_m()) / Leg().channel_radius_m;
  return std::copysign(std::clamp(bent_rad, 0.0, std::abs(Leg().turn_rad)), Leg().turn_rad);
}

void Puppet::Move(const robot::Command& command, double step_s) {
  const double radius_m = Kantaro().tyre_radius_m;
  const double speed_m_s = radius_m * (command.left_rad_s + command.right_rad_s) / 2.0;
  const double difference_m_s = radius_m * (command.right_rad_s - command.left_rad_s) / 2.0;
  fastest_m_s_ = std::max(fastest_m_s_, std::abs(speed_m_s));
  if (!turning_ && std::abs(difference_m_s) > kTurning * std::abs(speed_m_s)) {
    turns_.push_back({leg_, beyond_m(), difference_m_s > 0.0});
    // The front wheels find a channel's mouth from 15 cm before the bend to 5 cm into it.
    const double axle_m = beyond_m() + Kantaro().front_axle_x_m - Leg().StraightBeforeTurn_m();
    const bool found = Leg().turn_rad * difference_m_s > 0.0 && axle_m > -0.15 && axle_m < 0.05;
    turning_ = found;
    crashed_ = crashed_ || !found;
  }
  const double heading_rad = Heading_rad();
  distance_m_ += setup.scale * (speed_m_s < 0.0 ? setup.reverse_scale : 1.0) * speed_m_s * step_s;
  if (!Leg().straight_on && !turning_) {
    distance_m_ = std::min(distance_m_, Leg().length_m + setup.farthest_beyond_m);
  }
  wheel_travel_m_ += speed_m_s * step_s;
  yaw_rate_rad_s_ = (Heading_rad() - heading_rad) / step_s;
  reversed_m_ = speed_m_s < 0.0 ? reversed_m_ - setup.scale * speed_m_s * step_s : 0.0;
  longest_reverse_m_ = std::max(longest_reverse_m_, reversed_m_);
  if (leg_ + 1 < truth_.legs.size() && (turning_ || Leg().turn_rad == 0.0) &&
      beyond_m() > Through_m()) {
    distance_m_ = beyond_m() - Through_m();
    turning_ = false;
    ++leg_;
  }
}

perception::LaserObservation Puppet::Laser() {
  const double x_m = Kantaro().laser_x_m;
  perception::LaserObservation laser;
  laser.captured_at = now_;
  laser.top_open = TopOpen(x_m);
  laser.left_open = SideOpen(x_m, true);
  laser.right_open = SideOpen(x_m, false);
  laser.edges = tracker_.Update(laser);
  return laser;
}

perception::RingObservation Puppet::Rings() const {
  perception::RingObservation rings;
  rings.captured_at = now_;
  const auto add = [&](perception::RingKind kind, double at_m) {
    const double ahead_m = at_m - distance_m_ - Kantaro().camera_x_m;
    if (ahead_m < 0.3 || ahead_m > 1.6) return;
    perception::RingSighting ring;
    ring.kind = kind;
    ring.distance_m = ahead_m + setup.camera_bias_m;
    rings.rings.push_back(ring);
  };
  for (const MapLandmark& landmark : Leg().landmarks) {
    if (landmark.kind == LandmarkKind::kJoint)
      add(perception::RingKind::kJoint, landmark.distance_m);
  }
  add(perception::RingKind::kManholeMouth, Leg().length_m);
  return rings;
}

void Puppet::Tell(Executive& executive, perception::Observation observation,
                  robot::Command& command) {
  if (meddle) meddle(observation, *this);
  command = executive.Step(observation);
  for (const Event& event : executive.TakeEvents()) story_ += event.text + "\n";
  if (executive.phase() == phase_) return;
  phase_ = executive.phase();
  changes_.push_back({phase_, leg_, beyond_m()});
}

void Puppet::Drive(Executive& executive, double limit_s) {
  robot::Command command;
  const int ticks = static_cast<int>(limit_s / kStep_s);
  for (int tick = 0; tick < ticks && !executive.finished() && !crashed_; ++tick) {
    now_ += std::chrono::milliseconds(10);
    Move(command, kStep_s);
    if (setup.gyro) {
      Tell(executive,
           perception::AttitudeObservation{now_, 0.0, 0.0, yaw_rate_rad_s_ + setup.yaw_bias_rad_s},
           command);
    }
    if (tick % 2 == 0) {
      Tell(executive,
           perception::OdometryObservation{now_, wheel_travel_m_, wheel_travel_m_, wheel_travel_m_},
           command);
      const double x_m = Kantaro().infrared_x_m;
      if (setup.infrared) {
        Tell(executive,
             perception::IrObservation{now_, TopOpen(x_m), SideOpen(x_m, true),
                                       SideOpen(x_m, false)},
             command);
      }
    }
    if (setup.laser && tick % 3 == 0) Tell(executive, Laser(), command);
    if (setup.camera && tick % 20 == 0) Tell(executive, Rings(), command);
  }
}

}  // namespace kantaro::navigation
