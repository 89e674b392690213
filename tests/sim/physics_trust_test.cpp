// The physics against answers worked out by hand. Notation: alpha is the lean of the wall where a
// tyre touches it, measured from the horizontal; a wheel that carries F upwards presses the wall
// with F / cos alpha (the wedge).

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "sim/mujoco_error.hpp"
#include "sim/physics.hpp"
#include "sim/sewer.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_m_s2 = 9.81;
constexpr double kTyre_m = 0.045;
constexpr double kTread_m = 0.012;
/// Where a tyre's lowest circle lies beside the robot's middle: docs/robot.md.
constexpr double kBeside_m = 0.0578;

/// The circle inside the tyre lies one tread radius from the wall.
double WallLean(double diameter_m) { return std::asin(kBeside_m / (diameter_m / 2.0 - kTread_m)); }

/// 10 m of pipe from "A" up to "B", its grade the tangent of its slope.
network::Network PipeOf(double diameter_m, double grade = 0.0) {
  network::Network network = network::OnePipe();
  network.pipes[0].diameter_m = diameter_m;
  // The grade counts from wall to wall.
  const double shaft_m = diameter_m / 2.0 + 0.25;
  network.manholes[1].p_WM.z() = (10.0 - 2.0 * shaft_m) * grade;
  return network;
}

/// A robot in a sewer of its own.
class Rig {
 public:
  Rig(const network::Network& network, const PhysicsOptions& options,
      const robot::Description& description = Kantaro())
      : description_(description),
        sewer_(BuildSewer(network)),
        field_(sewer_.voids, sewer_.solids),
        physics_(field_, description_, options) {}

  static const robot::Description& Kantaro() {
    static const robot::Description robot =
        robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
    return robot;
  }

  Physics& Place(double chainage_m, double yaw_rad = 0.0) {
    physics_.Place(sewer_, {"P", chainage_m, true, 0.0, yaw_rad});
    return physics_;
  }
  void Run(double seconds) {
    const double until_s = physics_.time_s() + seconds;
    while (physics_.time_s() < until_s) physics_.Step();
  }
  double Chainage() const {
    return sewer_.axes[0].Locate(physics_.PoseOfBase().translation()).chainage_m;
  }
  double SumOfNormalForces_N() const {
    double sum = 0.0;
    for (int i = 0; i < physics_.data().ncon; ++i) {
      std::array<mjtNum, 6> force{};
      mj_contactForce(&physics_.model(), &physics_.data(), i, force.data());
      sum += force[0];
    }
    return sum;
  }
  double JointPosition(const std::string& joint) const {
    const int id = mj_name2id(&physics_.model(), mjOBJ_JOINT, joint.c_str());
    return physics_.data().qpos[physics_.model().jnt_qposadr[id]];
  }
  /// Energy of motion [J].
  double KineticEnergy_J() const {
    const mjModel& model = physics_.model();
    std::vector<mjtNum> momentum(static_cast<std::size_t>(model.nv));
    mj_mulM(&model, &physics_.data(), momentum.data(), physics_.data().qvel);
    return 0.5 * mju_dot(momentum.data(), physics_.data().qvel, model.nv);
  }
  Physics& physics() { return physics_; }
  const Physics& physics() const { return physics_; }

 private:
  const robot::Description description_;
  const Sewer sewer_;
  const VoidField field_;
  Physics physics_;
};

PhysicsOptions Friction(double wheel_friction) {
  PhysicsOptions options;
  options.wheel_friction = wheel_friction;
  return options;
}

double Weight_N() { return Rig::Kantaro().TotalMass_kg() * kGravity_m_s2; }

// Without friction a wall can only push along its normal: four wheels carry the weight by
// N cos alpha each, so the walls push with weight / cos alpha in all: 1.33 times the weight in
// 200 mm, 1.10 times in 300 mm.
TEST(WallForces, AreTheWeightOverTheCosineOfTheWallsLean) {
  for (const double diameter_m : {0.200, 0.250, 0.300}) {
    Rig rig(PipeOf(diameter_m), Friction(1e-4));
    rig.Place(5.0);
    const double expected_N = Weight_N() / std::cos(WallLean(diameter_m));
    EXPECT_NEAR(rig.SumOfNormalForces_N(), expected_N, 0.01 * expected_N) << diameter_m;
  }
}

// Braked wheels hold on a slope s until weight * sin s exceeds mu * N, N = weight * cos s / cos
// alpha: tan s = mu / cos alpha. Within 5 %: 5 % below it holds (a braked motor creeps: 0.31 Nm on
// the steepest of these slopes against a gain of 1.5 Nm s is 9 mm/s), 5 % above it slides away,
// at g cos s * 5 % * mu / cos alpha = 0.10 m/s2 or more if the limit is met exactly. With more
// friction the front wheels would lift before the robot slides.
TEST(SteepestSlope, IsFrictionOverTheCosineOfTheWallsLean) {
  for (const double diameter_m : {0.200, 0.250, 0.300}) {
    for (const double mu : {0.2, 0.3}) {
      const double grade = mu / std::cos(WallLean(diameter_m));
      for (const double share : {0.95, 1.05}) {
        Rig rig(PipeOf(diameter_m, share * grade), Friction(mu));
        rig.Place(7.0);
        rig.Run(5.0);
        const double speed_m_s = rig.physics().VelocityOfBase().norm();
        if (share < 1.0) {
          EXPECT_LT(speed_m_s, 0.05) << diameter_m << " " << mu;
        } else {
          EXPECT_GT(speed_m_s, 0.10) << diameter_m << " " << mu;
        }
      }
    }
  }
}

// Each spring carries a quarter of what is sprung, F / 4 / k. With 2 kg more on the middle that is
// 4.9 N / 2500 N/m = 1.96 mm more.
TEST(Springs, GiveWayByLoadOverStiffness) {
  robot::Description laden = Rig::Kantaro();
  for (robot::Link& link : laden.links) {
    // The mass goes where the sprung part's centre is, right above the middle of the wheels.
    if (link.name == "base") {
      link.inertial =
          robot::Inertial{2.0, Vector3d(0.0, 0.0, 0.06), 0.001 * Eigen::Matrix3d::Identity()};
    }
  }
  Rig plain(PipeOf(0.300), Friction(0.7));
  Rig heavy(PipeOf(0.300), Friction(0.7), laden);
  plain.Place(5.0);
  heavy.Place(5.0);
  double sum_m = 0.0;
  for (const auto& [joint, spring] : laden.suspensions) {
    EXPECT_NEAR(plain.JointPosition(joint), 0.0, 0.0003) << joint;
    sum_m += heavy.JointPosition(joint) - plain.JointPosition(joint);
  }
  EXPECT_NEAR(sum_m / 4.0, 2.0 * kGravity_m_s2 / 4.0 / 2500.0, 0.00005);
}

// At steady speed on the level the motors work against rolling resistance alone: lever arm times
// load. In 260 mm the wall leans as the wheels do and nothing twists in the contact
// (asin(57.8 / 118) = 0.512 against the camber's 0.5).
TEST(RollingResistance, IsWhatTheMotorsWorkAgainst) {
  for (const double lever_m : {0.0005, 0.002}) {
    PhysicsOptions options = Friction(0.7);
    options.rolling_resistance_m = lever_m;
    Rig rig(PipeOf(0.260), options);
    rig.Place(2.0).Drive(2.0, 2.0);
    rig.Run(3.0);
    double torque_Nm = 0.0;
    int steps = 0;
    for (; steps < 500; ++steps) {
      rig.physics().Step();
      for (int i = 0; i < 4; ++i) torque_Nm += rig.physics().data().actuator_force[i];
    }
    const double expected_Nm = lever_m * Weight_N();
    EXPECT_NEAR(torque_Nm / steps, expected_Nm, 0.05 * expected_Nm) << lever_m;
  }
}

// Wheels hang at their springs' rest in free fall; from h above the wall they land after
// sqrt(2 h / g): 101 ms from 50 mm, 143 ms from 100 mm. A step lasts 2 ms.
TEST(Fall, TakesTheTimeThatGravityGivesIt) {
  const robot::Description& kantaro = Rig::Kantaro();
  for (const double height_m : {0.050, 0.100}) {
    const Sewer sewer = BuildSewer(PipeOf(0.600));
    const VoidField field(sewer.voids);
    const ModelPointer model = BuildRobotModel(kantaro, {});
    const DataPointer data(mj_makeData(model.get()));
    const ContactBinding binding(model.get(), &field);
    for (const auto& [joint, spring] : kantaro.suspensions) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, joint.c_str());
      data->qpos[model->jnt_qposadr[id]] = spring.rest_position_m;
    }
    // Level with the pipe's axis, 300 mm above the invert. The ring inside a tyre lies 29.0 mm
    // below the wheel's centre, which hangs 5.9 mm low.
    const double reach_m = 0.300 - kTread_m;
    const double hang_m = -kantaro.suspensions.begin()->second.rest_position_m;
    const double rest_depth_m =
        std::sqrt(reach_m * reach_m - kBeside_m * kBeside_m) - 0.0290 - hang_m;
    const Vector3d p_WB =
        sewer.axes[0].PoseAt(5.0).translation() - (rest_depth_m - height_m) * Vector3d::UnitZ();
    for (int i = 0; i < 3; ++i) data->qpos[i] = p_WB[i];
    while (data->ncon == 0 && data->time < 1.0) mj_step(model.get(), data.get());
    EXPECT_NEAR(data->time, std::sqrt(2.0 * height_m / kGravity_m_s2), 0.004) << height_m;
  }
}

// On a slimy slope the wheels turn forwards and the robot slides back: friction gives
// mu N = mu * weight * cos s / cos alpha and no more, whatever the wheels do. At 10 % and mu = 0.05
// in 300 mm that leaves g (sin s - 0.05 cos s / cos alpha) = 0.439 m/s2: 0.22 m in the first
// second.
TEST(WheelSlip, OnASlimySlopeLeavesWhatFrictionDoesNotHold) {
  constexpr double kMu = 0.05;
  const double slope = std::atan(0.10);
  Rig rig(PipeOf(0.300, 0.10), Friction(kMu));
  rig.Place(6.0).Drive(2.0, 2.0);
  rig.Run(0.5);
  const double from_m = rig.Chainage();
  const double speed_m_s = -rig.physics().VelocityOfBase().x() / std::cos(slope);
  rig.Run(1.0);
  const double acceleration =
      kGravity_m_s2 * (std::sin(slope) - kMu * std::cos(slope) / std::cos(WallLean(0.300)));
  EXPECT_NEAR(from_m - rig.Chainage(), speed_m_s + 0.5 * acceleration, 0.02);
  EXPECT_NEAR(rig.physics().WheelAngles()[0], 2.0 * 1.5, 0.3);
}

// ... and from mu = tan s cos alpha = 0.0905 on it climbs.
TEST(WheelSlip, EndsWhereFrictionCarriesTheSlope) {
  const double needed = 0.10 * std::cos(WallLean(0.300));
  for (const double share : {0.9, 1.15}) {
    Rig rig(PipeOf(0.300, 0.10), Friction(share * needed));
    rig.Place(5.0).Drive(2.0, 2.0);
    const double from_m = rig.Chainage();
    rig.Run(4.0);
    EXPECT_EQ(rig.Chainage() > from_m, share > 1.0) << share;
  }
}

// Nothing drives a robot that stands: over ten minutes it gains no energy and goes nowhere.
TEST(Rest, GainsNoEnergyOverTenMinutes) {
  Rig rig(PipeOf(0.300), Friction(0.3));
  rig.Place(5.0, /*yaw_rad=*/0.05);
  rig.Run(2.0);
  const Vector3d from = rig.physics().PoseOfBase().translation();
  double most_J = 0.0;
  for (int minute = 0; minute < 10; ++minute) {
    rig.Run(60.0);
    most_J = std::max(most_J, rig.KineticEnergy_J());
  }
  EXPECT_LT(most_J, 1e-8);
  EXPECT_LT((rig.physics().PoseOfBase().translation() - from).norm(), 0.001);
}

/// How far the robot comes in 12 s at 0.1 m/s with a stone of 15 mm in its left wheels' way.
double WayOverALump(double timestep_s) {
  network::Network network = PipeOf(0.250);
  network::Obstacle lump;
  lump.name = "lump";
  lump.chainage_m = 2.5;
  lump.clock_h = 7.0;
  lump.height_m = 0.015;
  lump.length_m = lump.width_m = 0.060;
  network.pipes[0].obstacles = {lump};
  PhysicsOptions options = Friction(0.5);
  options.timestep_s = timestep_s;
  Rig rig(network, options);
  rig.Place(2.0).Drive(0.1 / kTyre_m, 0.1 / kTyre_m);
  const double from_m = rig.Chainage();
  double highest_m = 0.0;
  while (rig.physics().time_s() < 12.0) {
    rig.Run(0.1);
    highest_m = std::max(highest_m, std::abs(rig.physics().PoseOfBase().linear()(2, 1)));
  }
  EXPECT_GT(highest_m, 0.05) << "the robot never met the lump";  // 15 mm over 116 mm is 0.13
  return rig.Chainage() - from_m;
}

// Halving the step twice changes the way by less than 1 % (a slip more or less on the lump).
TEST(TimeStep, HalvedGivesTheSameWay) {
  const double way_m = WayOverALump(0.002);
  EXPECT_GT(way_m, 1.1);
  EXPECT_NEAR(WayOverALump(0.001), way_m, 0.01 * way_m);
  EXPECT_NEAR(WayOverALump(0.0005), way_m, 0.01 * way_m);
}

// An infinite command is an engine warning, and a warning ends the run.
TEST(EngineWarning, EndsTheRunAndLeavesNoLogFile) {
  std::filesystem::remove("MUJOCO_LOG.TXT");
  Rig rig(PipeOf(0.300), Friction(0.7));
  Physics& physics = rig.Place(5.0);
  physics.Drive(std::numeric_limits<double>::quiet_NaN(), 0.0);
  EXPECT_THROW(physics.Step(), MujocoError);
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

}  // namespace
}  // namespace kantaro::sim
