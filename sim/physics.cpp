#include "sim/physics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sim/mujoco_error.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kSettle_s = 1.0;
/// Steps from one look at the ground to the next: 10 ms, in which a wheel goes 1.5 mm.
constexpr int kGroundEvery = 5;

Vector3d ToEigen(const mjtNum* v) { return {v[0], v[1], v[2]}; }

}  // namespace

Physics::Physics(const VoidField& field, const robot::Description& description,
                 const PhysicsOptions& options, GroundAt ground)
    : field_(field),
      description_(description),
      options_(options),
      ground_(std::move(ground)),
      model_(BuildRobotModel(description, options)),
      data_(mj_makeData(model_.get())),
      binding_(model_.get(), &field) {
  ThrowOnMujocoErrors();
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const std::string& name = description.wheels[i];
    const robot::Tyre& tyre = description.tyres.at(name);
    Wheel& wheel = wheels_[i];
    wheel.joint = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
    wheel.body = model_->jnt_bodyid[wheel.joint];
    wheel.geom = model_->body_geomadr[wheel.body];
    wheel.wading = {tyre.radius_m, 2.0 * tyre.tread_radius_m};
  }
}

void Physics::StandOn(int geom, const Footing& footing) {
  const auto wheel = std::find_if(wheels_.begin(), wheels_.end(),
                                  [&](const Wheel& candidate) { return candidate.geom == geom; });
  const auto set_friction = [&](std::optional<double> everywhere, double here) {
    model_->geom_friction[3 * geom] = everywhere.value_or(options_.friction_factor * here);
  };
  if (wheel == wheels_.end()) {
    set_friction(options_.hull_friction, footing.grip.hull_friction);
    return;
  }
  set_friction(options_.wheel_friction, footing.grip.tyre_friction);
  model_->dof_frictionloss[model_->jnt_dofadr[wheel->joint]] = RollingLoss_Nm(
      description_, options_.rolling_resistance_m.value_or(footing.grip.rolling_resistance_m));
  mjtNum* force_W = data_->xfrc_applied + 6 * static_cast<std::ptrdiff_t>(wheel->body);
  if (footing.water_m <= 0.0) return;
  std::array<mjtNum, 6> velocity{};  // turning, then moving, in W
  mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, wheel->body, velocity.data(), 0);
  const double speed = std::hypot(velocity[3], velocity[4]);
  if (speed > 0.0) {
    const double drag_N = WadingDrag_N(wheel->wading, footing.water_m, speed);
    for (int i = 0; i < 2; ++i)
      force_W[i] = -drag_N * velocity[static_cast<std::size_t>(3 + i)] / speed;
  }
  force_W[2] = WadingLift_N(wheel->wading, footing.water_m);
}

void Physics::FeelGround() {
  // The deepest contact of each shape tells what it stands on; in the air it keeps its friction.
  mju_zero(data_->xfrc_applied, 6 * model_->nbody);
  std::map<int, const mjContact*> deepest;
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    const mjContact*& kept = deepest[contact.geom2];
    if (kept == nullptr || contact.dist < kept->dist) kept = &contact;
  }
  for (const auto& [geom, contact] : deepest) StandOn(geom, ground_(ToEigen(contact->pos)));
}

void Physics::ForgetGround() {
  steps_until_ground_ = 0;
  if (!ground_) return;
  mju_zero(data_->xfrc_applied, 6 * model_->nbody);
  const Footing usual{{kUsualWheelFriction, kUsualHullFriction, kUsualRollingResistance_m}, 0.0};
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (model_->geom_type[geom] != mjGEOM_ELLIPSOID) StandOn(geom, usual);
  }
}

double Physics::WheelClearance() {
  mj_kinematics(model_.get(), data_.get());
  double least = VoidField::kLargestReach_m;
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (model_->geom_type[geom] != mjGEOM_CYLINDER) continue;
    const mjtNum* R_WG = data_->geom_xmat + 9 * geom;
    const double tread = model_->geom_user[static_cast<std::ptrdiff_t>(model_->nuser_geom) * geom];
    const Torus torus{ToEigen(data_->geom_xpos + 3 * geom),
                      {R_WG[2], R_WG[5], R_WG[8]},
                      model_->geom_size[3 * geom] - tread,
                      tread};
    for (const WallContact& contact : TorusContacts(field_, torus, 0.1))
      least = std::min(least, contact.distance_m);
  }
  return least;
}

void Physics::Place(const Sewer& sewer, const StartPose& start) {
  const std::size_t pipe = sewer.network.FindPipe(start.pipe).value();
  const Isometry3d X_WP = sewer.axes[pipe].PoseAt(start.chainage_m);
  const double radius = sewer.network.pipes[pipe].diameter_m / 2.0;
  const double heading = start.facing_downstream ? 0.0 : std::numbers::pi;

  mj_resetData(model_.get(), data_.get());
  ForgetGround();
  const auto place = [&](double down_m) {
    const Isometry3d X_WB = X_WP * Eigen::AngleAxisd(heading, Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(start.roll_rad, Vector3d::UnitX()) *
                            Eigen::Translation3d(0.0, 0.0, -down_m) *
                            Eigen::AngleAxisd(start.yaw_rad, Vector3d::UnitZ());
    const Eigen::Quaterniond q(X_WB.linear());
    const std::array<mjtNum, 7> qpos{X_WB.translation().x(),
                                     X_WB.translation().y(),
                                     X_WB.translation().z(),
                                     q.w(),
                                     q.x(),
                                     q.y(),
                                     q.z()};
    std::copy(qpos.begin(), qpos.end(), data_->qpos);
    return WheelClearance();
  };
  // Lower the robot until a tread meets the wall.
  double high = 0.0;
  double low = radius;
  if (place(high) < 0.0)
    throw std::invalid_argument(fmt::format("the robot does not fit into pipe \"{}\"", start.pipe));
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (high + low);
    (place(middle) > 0.0 ? high : low) = middle;
  }
  place(high);

  Drive(0.0, 0.0);
  while (data_->time < kSettle_s) Step();
  data_->time = 0.0;
}

void Physics::Drive(double left_rad_s, double right_rad_s) {
  for (int i = 0; i < 4; ++i) data_->ctrl[i] = i % 2 == 0 ? left_rad_s : right_rad_s;
}

void Physics::Step() {
  if (ground_ && --steps_until_ground_ <= 0) {
    FeelGround();
    steps_until_ground_ = kGroundEvery;
  }
  mj_step(model_.get(), data_.get());
}

Isometry3d Physics::PoseOfBase() const {
  Isometry3d X_WB = Isometry3d::Identity();
  X_WB.translation() = ToEigen(data_->qpos);
  X_WB.linear() = Eigen::Quaterniond(data_->qpos[3], data_->qpos[4], data_->qpos[5], data_->qpos[6])
                      .toRotationMatrix();
  return X_WB;
}

Vector3d Physics::VelocityOfBase() const { return ToEigen(data_->qvel); }

std::array<double, 4> Physics::WheelAngles() const {
  std::array<double, 4> angles{};
  for (std::size_t i = 0; i < angles.size(); ++i)
    angles[i] = data_->qpos[model_->jnt_qposadr[wheels_[i].joint]];
  return angles;
}

std::array<double, 4> Physics::MotorTorques() const {
  std::array<double, 4> torques{};
  for (std::size_t i = 0; i < torques.size(); ++i) torques[i] = data_->actuator_force[i];
  return torques;
}

std::array<double, 4> Physics::WheelSpeeds() const {
  std::array<double, 4> speeds{};
  for (std::size_t i = 0; i < speeds.size(); ++i)
    speeds[i] = data_->qvel[model_->jnt_dofadr[wheels_[i].joint]];
  return speeds;
}

Vector3d Physics::AngularVelocity() const { return ToEigen(data_->sensordata); }

Vector3d Physics::SpecificForce() const { return ToEigen(data_->sensordata + 3); }

bool Physics::Touches(const std::string& link) const {
  const int body = mj_name2id(model_.get(), mjOBJ_BODY, link.c_str());
  return std::any_of(data_->contact, data_->contact + data_->ncon, [&](const mjContact& contact) {
    return contact.dist < 0.0 && model_->geom_bodyid[contact.geom2] == body;
  });
}

}  // namespace kantaro::sim
