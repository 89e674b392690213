#include "sim/robot_model.hpp"

#include <fmt/format.h>

#include <cstring>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using robot::Description;
using robot::Joint;
using robot::JointType;
using robot::Link;

std::string Numbers(const Vector3d& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

std::string Placement(const Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  return fmt::format(R"(pos="{}" quat="{} {} {} {}")", Numbers(X.translation()), q.w(), q.x(),
                     q.y(), q.z());
}

const Joint* JointAbove(const Description& description, const std::string& link) {
  for (const Joint& joint : description.joints) {
    if (joint.child == link) return &joint;
  }
  return nullptr;
}

Isometry3d PoseInParent(const Description& description, const Joint& joint, double mast_height_m) {
  Isometry3d X_PJ = joint.X_PJ;
  if (joint.name == description.laser.mast) X_PJ.translate(joint.axis_J * mast_height_m);
  return X_PJ;
}

class Writer {
 public:
  Writer(const Description& description, const PhysicsOptions& options)
      : description_(description), options_(options) {}

  std::string Write() {
    text_ += fmt::format(R"(<mujoco model="{}">
<compiler angle="radian" inertiafromgeom="false" balanceinertia="false"/>
<option timestep="{}" integrator="Euler" cone="elliptic" solver="Newton" impratio="3" tolerance="1e-9"/>
<size nuser_geom="1" nconmax="200" njmax="1000"/>
<statistic extent="1" center="0 0 0" meansize="0.1"/>
<worldbody>
<geom name="wall" type="ellipsoid" size="1e5 1e5 1e5" contype="1" conaffinity="0" friction="0 0 0" condim="4"/>
)",
                         description_.name, options_.timestep_s);
    WriteBody(description_.links.front(), nullptr);
    text_ += "</worldbody>\n<actuator>\n";
    for (const std::string& wheel : description_.wheels) WriteMotor(wheel);
    text_ += "</actuator>\n<sensor>\n";
    text_ +=
        "<gyro name=\"gyro\" site=\"base\"/>\n<accelerometer name=\"accelerometer\" "
        "site=\"base\"/>\n";
    text_ += "</sensor>\n</mujoco>\n";
    return std::move(text_);
  }

 private:
  void WriteBody(const Link& link, const Joint* joint) {
    if (joint == nullptr) {
      text_ += fmt::format(
          "<body name=\"{}\">\n<freejoint name=\"base\"/>\n<site name=\"base\"/>\n", link.name);
    } else {
      text_ += fmt::format("<body name=\"{}\" {}>\n", link.name,
                           Placement(PoseInParent(description_, *joint, options_.mast_height_m)));
      WriteJoint(*joint);
    }
    if (link.inertial) {
      const Eigen::Matrix3d& I = link.inertial->I_LLcm_L;
      text_ += fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>\n",
                           Numbers(link.inertial->p_LoLcm_L), link.inertial->mass_kg, I(0, 0),
                           I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    }
    for (const robot::Shape& shape : link.collisions) WriteShape(shape, joint);
    for (const Joint& below : description_.joints) {
      if (below.parent == link.name && (below.type != JointType::kFixed || HasBody(below.child))) {
        WriteBody(description_.LinkNamed(below.child), &below);
      }
    }
    text_ += "</body>\n";
  }

  /// Sensor frames weigh nothing and touch nothing: they need no body.
  bool HasBody(const std::string& name) const {
    const Link& link = description_.LinkNamed(name);
    if (link.inertial || !link.collisions.empty()) return true;
    for (const Joint& below : description_.joints) {
      if (below.parent == name && HasBody(below.child)) return true;
    }
    return false;
  }

  void WriteJoint(const Joint& joint) {
    if (joint.type == JointType::kPrismatic && joint.name != description_.laser.mast) {
      const robot::Suspension& spring = description_.suspensions.at(joint.name);
      text_ += fmt::format(
          "<joint name=\"{}\" type=\"slide\" axis=\"{}\" limited=\"true\" range=\"{} {}\" "
          "stiffness=\"{}\" "
          "damping=\"{}\" springref=\"{}\"/>\n",
          joint.name, Numbers(joint.axis_J), joint.lower, joint.upper, spring.stiffness_N_m,
          spring.damping_Ns_m, spring.rest_position_m);
    } else if (joint.type == JointType::kContinuous) {
      text_ += fmt::format(
          "<joint name=\"{}\" type=\"hinge\" axis=\"{}\" limited=\"false\" armature=\"{}\" "
          "frictionloss=\"{}\"/>\n",
          joint.name, Numbers(joint.axis_J), description_.motors.at(joint.name).rotor_inertia_kg_m2,
          RollingLoss_Nm(description_,
                         options_.rolling_resistance_m.value_or(kUsualRollingResistance_m)));
    }
  }

  void WriteShape(const robot::Shape& shape, const Joint* joint) {
    std::string form;
    double friction = options_.hull_friction.value_or(kUsualHullFriction);
    if (joint != nullptr && description_.tyres.contains(joint->name)) {
      const robot::Tyre& tyre = description_.tyres.at(joint->name);
      form = fmt::format("type=\"cylinder\" size=\"{} {}\" user=\"{}\"", tyre.radius_m,
                         tyre.tread_radius_m, tyre.tread_radius_m);
      friction = options_.wheel_friction.value_or(kUsualWheelFriction);
    } else if (const auto* box = std::get_if<robot::Box>(&shape.geometry)) {
      form = fmt::format("type=\"box\" size=\"{}\"", Numbers(0.5 * box->size_m));
    } else {
      throw std::invalid_argument("only wheels and boxes touch the wall");
    }
    text_ += fmt::format(
        "<geom {} {} contype=\"0\" conaffinity=\"1\" condim=\"4\" friction=\"{} 0.003 0\" "
        "solref=\"0.006 1\"/>\n",
        form, Placement(shape.X_LG), friction);
  }

  void WriteMotor(const std::string& wheel) {
    const robot::Motor& motor = description_.motors.at(wheel);
    text_ += fmt::format(
        "<velocity name=\"{0}\" joint=\"{0}\" kv=\"{1}\" ctrllimited=\"true\" ctrlrange=\"{2} "
        "{3}\" "
        "forcelimited=\"true\" forcerange=\"{4} {5}\"/>\n",
        wheel, motor.speed_gain_Nm_s, -motor.speed_limit_rad_s, motor.speed_limit_rad_s,
        -motor.torque_limit_Nm, motor.torque_limit_Nm);
  }

  const Description& description_;
  const PhysicsOptions& options_;
  std::string text_;
};

}  // namespace

std::string RobotMjcf(const Description& description, const PhysicsOptions& options) {
  return Writer(description, options).Write();
}

ModelPointer BuildRobotModel(const Description& description, const PhysicsOptions& options) {
  const std::string mjcf = RobotMjcf(description, options);
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  constexpr const char* kName = "robot.xml";
  if (mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(mjcf.size())) != 0) {
    throw std::runtime_error("MuJoCo has no room for the robot's model text");
  }
  std::memcpy(files->filedata[0], mjcf.data(), mjcf.size());
  std::array<char, 1000> error{};
  ModelPointer model(mj_loadXML(kName, files.get(), error.data(), static_cast<int>(error.size())));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(fmt::format("MuJoCo refuses the robot: {}", error.data()));
  return model;
}

double RollingLoss_Nm(const Description& description, double rolling_resistance_m) {
  constexpr double kGravity_m_s2 = 9.81;
  return rolling_resistance_m * description.TotalMass_kg() * kGravity_m_s2 /
         static_cast<double>(description.wheels.size());
}

Isometry3d MountPose(const Description& description, const std::string& link,
                     double mast_height_m) {
  Isometry3d X_BL = Isometry3d::Identity();
  for (const Joint* joint = JointAbove(description, link); joint != nullptr;
       joint = JointAbove(description, joint->parent)) {
    X_BL = PoseInParent(description, *joint, mast_height_m) * X_BL;
  }
  return X_BL;
}

}  // namespace kantaro::sim
