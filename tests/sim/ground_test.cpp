#include "sim/ground.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "sim/physics.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;
using network::Material;
using network::WallCondition;

constexpr double kRadius_m = 0.15;
constexpr double kCreep_m_s = 0.015;  // a robot held by its motors
const std::string kShipped = KANTARO_SOURCE_DIR "/models/materials.yaml";

/// A 300 mm pipe of 10 m between the centres of its shafts, falling by `slope` from wall to wall.
network::Network Falling(double slope) {
  constexpr double kShaft_m = kRadius_m + 0.25;
  network::Network network = network::OnePipe();
  network.manholes[0].p_WM.z() = (10.0 - 2.0 * kShaft_m) * slope;
  return network;
}

/// A sewer with its field and ground.
struct Place {
  explicit Place(const network::Network& network)
      : sewer(BuildSewer(network)),
        field(sewer.voids, sewer.solids),
        ground(sewer, field, ReadGripTable(kShipped)) {}

  /// On the wall of the pipe.
  [[nodiscard]] Footing At(double chainage_m, double clock_h, double radius_m = kRadius_m) const {
    return ground(sewer.axes[0].PoseAt(chainage_m) *
                  Vector3d(radius_m * network::ClockDirection(clock_h)));
  }

  Sewer sewer;
  VoidField field;
  SewerGround ground;
};

std::string Refusal(const std::string& what, const std::string& with) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "ground_test_materials.yaml";
  std::string text = ReadInputFile(kShipped);
  WriteFileAtomically(file, text.replace(text.find(what), what.size(), with));
  try {
    (void)ReadGripTable(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

// The two that the robot is tested at.
TEST(GripTable, HasDryAndWetPlasticAsTheLocomotionTestsDo) {
  const GripTable grips = ReadGripTable(kShipped);
  EXPECT_EQ(grips.At(Ground::kPvc, WallCondition::kDry).tyre_friction, 0.7);
  EXPECT_EQ(grips.At(Ground::kPvc, WallCondition::kWet).tyre_friction, 0.3);
  EXPECT_EQ(grips.At(GroundOf(Material::kLined), WallCondition::kDry).tyre_friction,
            grips.At(Ground::kLined, WallCondition::kDry).tyre_friction);
}

TEST(GripTable, RefusesWhatIsMissingUnknownOrUnfounded) {
  EXPECT_THAT(Refusal("lined:", "tarred:"), testing::HasSubstr("tarred"));
  EXPECT_THAT(Refusal("  slimy:\n    tyre_friction: 0.10", "  greasy:\n    tyre_friction: 0.10"),
              testing::HasSubstr("clay.greasy"));
  EXPECT_THAT(Refusal("source: As slimy PVC.", "source: me"),
              testing::HasSubstr("lined.slimy.source: say where the values are from"));
  EXPECT_THAT(Refusal("tyre_friction: 0.70", "tyre_friction: 0.29"),
              testing::HasSubstr("pvc.wet.tyre_friction: a tyre grips dry walls best"));
  EXPECT_THAT(Refusal("rolling_resistance_mm: 0.5", "rolling_resistance_mm: -0.5"),
              testing::HasSubstr("rolling_resistance_mm"));
}

TEST(Water, IsAsDeepOnASlopeAsOnTheLevelAndNoneAboveItsSurface) {
  network::Network network = Falling(0.05);
  network.pipes[0].water_m = 0.02;
  const Place place(network);
  for (const double chainage_m : {0.5, 4.0, 8.0}) {
    EXPECT_NEAR(place.At(chainage_m, 6.0).water_m, 0.020, 1e-6);
    // An hour is 30 degrees: the wall lies R (1 - cos 15) = 5.1 mm above the invert at half past
    // five.
    EXPECT_NEAR(place.At(chainage_m, 5.5).water_m,
                0.020 - kRadius_m * (1.0 - std::cos(std::numbers::pi / 12.0)), 1e-6);
    EXPECT_EQ(place.At(chainage_m, 4.5).water_m, 0.0);
    EXPECT_EQ(place.At(chainage_m, 12.0).water_m, 0.0);
  }
}

// It counts from the invert: a groove's bottom lies deeper.
TEST(Water, FillsGrooves) {
  network::Network network = Falling(0.0);
  network.pipes[0].water_m = 0.02;
  network.pipes[0].joints = {{.chainage_m = 4.0, .gap_m = 0.02, .depth_m = 0.006}};
  const Place place(network);
  EXPECT_NEAR(place.At(4.0, 6.0, kRadius_m + 0.006).water_m, 0.026, 1e-6);
}

TEST(Water, StandsInTheChannelsOfAManholeAsInItsDeepestPipe) {
  network::Network network = Falling(0.0);
  network.manholes.push_back(network::ManholeAt("C", 20, 0));
  network.pipes.push_back(network::PipeFrom("Q", "B", "C"));
  network.pipes[0].water_m = 0.02;
  network.pipes[1].water_m = 0.03;
  const Place place(network);
  EXPECT_NEAR(place.ground(Vector3d(10.0, 0.0, 0.0)).water_m, 0.03, 1e-6);
  EXPECT_NEAR(place.ground(Vector3d(10.0, 0.0, 0.001)).water_m, 0.029, 1e-6);
}

TEST(Footing, IsThatOfThePipesMaterialAndConditionAndWetUnderWater) {
  const GripTable grips = ReadGripTable(kShipped);
  network::Network network = Falling(0.0);
  network.pipes[0].material = Material::kClay;
  network.pipes[0].water_m = 0.02;
  const auto friction = [&](WallCondition condition) {
    return grips.At(Ground::kClay, condition).tyre_friction;
  };
  for (const auto& [wall, under] : {std::pair{WallCondition::kDry, WallCondition::kWet},
                                    {WallCondition::kWet, WallCondition::kWet},
                                    {WallCondition::kSlimy, WallCondition::kSlimy}}) {
    network.pipes[0].condition = wall;
    const Place place(network);
    EXPECT_EQ(place.At(4.0, 6.0).grip.tyre_friction, friction(under));
    EXPECT_EQ(place.At(4.0, 4.0).grip.tyre_friction, friction(wall));
  }
}

TEST(Footing, IsConcreteAsWetAsItsWettestPipeInAManhole) {
  network::Network network = Falling(0.0);
  network.manholes.push_back(network::ManholeAt("C", 20, 0));
  network.pipes.push_back(network::PipeFrom("Q", "B", "C"));
  network.pipes[1].condition = WallCondition::kSlimy;
  const Place place(network);
  const GripTable grips = ReadGripTable(kShipped);
  EXPECT_EQ(place.ground(Vector3d(10.0, 0.0, 0.0)).grip.tyre_friction,
            grips.At(Ground::kConcrete, WallCondition::kSlimy).tyre_friction);
  EXPECT_EQ(place.ground(Vector3d(0.0, 0.0, 0.0)).grip.tyre_friction,
            grips.At(Ground::kConcrete, WallCondition::kDry).tyre_friction);
}

// On the bed's top, on a brick's, and beside them.
TEST(Footing, IsThatOfWhatStandsInThePipe) {
  network::Network network = Falling(0.0);
  using network::ObstacleKind;
  network.pipes[0].obstacles = {{.name = "bed",
                                 .kind = ObstacleKind::kSediment,
                                 .chainage_m = 3.0,
                                 .height_m = 0.02,
                                 .length_m = 0.5},
                                {.name = "brick",
                                 .kind = ObstacleKind::kBrick,
                                 .chainage_m = 5.0,
                                 .height_m = 0.05,
                                 .length_m = 0.2,
                                 .width_m = 0.1}};
  const Place place(network);
  const GripTable grips = ReadGripTable(kShipped);
  const auto friction = [&](Ground ground) {
    return grips.At(ground, WallCondition::kDry).tyre_friction;
  };
  EXPECT_EQ(place.At(3.0, 6.0, kRadius_m - 0.020).grip.tyre_friction, friction(Ground::kSediment));
  EXPECT_EQ(place.At(5.0, 6.0, kRadius_m - 0.050).grip.tyre_friction, friction(Ground::kConcrete));
  EXPECT_EQ(place.At(4.0, 6.0).grip.tyre_friction, friction(Ground::kPvc));
}

// A disc of 45 mm, 24 mm thick: half of it displaces half its volume, and no more than all of it.
TEST(Wading, LiftsByTheWaterDisplaced) {
  const WadingWheel wheel{0.045, 0.024};
  const double whole_N = 1000.0 * 9.81 * std::numbers::pi * 0.045 * 0.045 * 0.024;
  EXPECT_NEAR(WadingLift_N(wheel, 0.045), 0.5 * whole_N, 1e-12);
  EXPECT_NEAR(WadingLift_N(wheel, 0.5), whole_N, 1e-12);
  EXPECT_NEAR(WadingLift_N(wheel, 0.0), 0.0, 1e-12);
}

// 1/2 * 1000 kg/m3 * (24 mm * 10 mm) * (0.15 m/s)^2 = 2.7 mN.
TEST(Wading, DragsWithTheSquareOfTheSpeed) {
  const WadingWheel wheel{0.045, 0.024};
  EXPECT_NEAR(WadingDrag_N(wheel, 0.010, 0.15), 2.7e-3, 1e-9);
  EXPECT_NEAR(WadingDrag_N(wheel, 0.010, 0.30), 4.0 * 2.7e-3, 1e-9);
}

class OnTheGround : public testing::Test {
 protected:
  robot::Description description_ = robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");

  PhysicsOptions Options() const {
    PhysicsOptions options;
    options.mast_height_m = description_.MastHeight(0.300);
    return options;
  }
  static void StepFor(Physics& physics, double seconds) {
    const double until = physics.time_s() + seconds;
    while (physics.time_s() < until) physics.Step();
  }
};

// Braked on a slope, wheels that lean by t against a round wall press W cos(a) / cos(t) on it and
// hold up to tan(a) = mu / cos(t). Held, the motors' brakes still creep by mm/s.
TEST_F(OnTheGround, StandsOnAFallBelowTheFrictionOfItsWallAndSlidesOnOneAbove) {
  const auto speed = [&](WallCondition condition, double slope, double* leaning = nullptr) {
    network::Network network = Falling(slope);
    network.pipes[0].condition = condition;
    const Place place(network);
    Physics physics(place.field, description_, Options(), place.ground);
    physics.Place(place.sewer, {"P", 2.0, true, 0.0, 0.0});
    for (int i = 0; leaning != nullptr && i < physics.data().ncon; ++i)
      *leaning += physics.data().contact[i].frame[2] / physics.data().ncon;
    return physics.VelocityOfBase().norm();
  };
  double leaning = 0.0;  // cos(t)
  EXPECT_LT(speed(WallCondition::kSlimy, 0.0, &leaning), kCreep_m_s);
  EXPECT_GT(leaning, 0.8);
  for (const auto& [condition, friction] :
       {std::pair{WallCondition::kSlimy, 0.12}, {WallCondition::kWet, 0.3}}) {
    EXPECT_LT(speed(condition, 0.9 * friction / leaning), kCreep_m_s);
    EXPECT_GT(speed(condition, 1.1 * friction / leaning), 5.0 * kCreep_m_s);
  }
  EXPECT_LT(speed(WallCondition::kDry, 0.35), kCreep_m_s);
}

// Sliding, too, friction is mu W cos(a) / cos(t), no more and no less: it leaves
// g (sin a - mu cos a / cos t). The wall of a 300 mm pipe leans by t where the tyres touch it:
// their lowest circle lies 57.8 mm beside the middle (docs/robot.md), 138 mm from the axis. Within
// 2 % of the friction. (The solver lifts a sliding wheel off the wall for single steps and presses
// it the harder in others: what counts is the mean.)
TEST_F(OnTheGround, SlidesDownWithWhatFrictionLeavesOfGravity) {
  constexpr double kGravity_m_s2 = 9.81;
  const double cos_lean = std::cos(std::asin(0.0578 / 0.138));
  for (const auto& [condition, friction, slope] : {std::tuple{WallCondition::kSlimy, 0.12, 0.16},
                                                   {WallCondition::kSlimy, 0.12, 0.30},
                                                   {WallCondition::kWet, 0.30, 0.40}}) {
    network::Network network = Falling(slope);
    network.pipes[0].condition = condition;
    const Place place(network);
    Physics physics(place.field, description_, Options(), place.ground);
    physics.Place(place.sewer, {"P", 1.0, true, 0.0, 0.0});
    const double before_m_s = physics.VelocityOfBase().norm();
    StepFor(physics, 1.0);
    const double gained_m_s = physics.VelocityOfBase().norm() - before_m_s;
    const double angle = std::atan(slope);
    const double held_m_s2 = friction * kGravity_m_s2 * std::cos(angle) / cos_lean;
    EXPECT_NEAR(gained_m_s, kGravity_m_s2 * std::sin(angle) - held_m_s2, 0.02 * held_m_s2)
        << friction << " " << slope;
  }
}

// Sliding down with braked wheels, the side that grips is held back more, and the robot turns to
// it.
TEST_F(OnTheGround, TurnsTowardsTheSideThatGrips) {
  const Place place(Falling(0.6));
  const GripTable grips = ReadGripTable(kShipped);
  const auto turn = [&](double slimy_side) {
    const auto ground = [&](const Vector3d& p_W) {
      return Footing{grips.At(Ground::kPvc, slimy_side * p_W.y() > 0.0 ? WallCondition::kSlimy
                                                                       : WallCondition::kDry),
                     0.0};
    };
    Physics physics(place.field, description_, Options(), ground);
    physics.Place(place.sewer, {"P", 1.0, true, 0.0, 0.0});
    const Vector3d forward = physics.PoseOfBase().linear().col(0);
    return std::atan2(forward.y(), forward.x());
  };
  const double slimy_left = turn(1.0);
  EXPECT_LT(slimy_left, -0.02);
  EXPECT_NEAR(turn(-1.0), -slimy_left, 0.2 * std::abs(slimy_left));
}

// At a steady speed the wall pushes the robot on by what the water holds it back, and the motors
// pay.
TEST_F(OnTheGround, RollsHeavierThroughWater) {
  struct Ride {
    double torque_Nm{}, push_N{}, speed_m_s{}, depth_m{};
  };
  const auto ride_through = [&](double water_m) {
    network::Network network = Falling(0.0);
    network.pipes[0].condition = WallCondition::kWet;
    network.pipes[0].water_m = water_m;
    const Place place(network);
    Physics physics(place.field, description_, Options(), place.ground);
    physics.Place(place.sewer, {"P", 1.0, true, 0.0, 0.0});
    Ride ride;
    ride.depth_m = place.ground(Vector3d(physics.data().contact[0].pos)).water_m;
    physics.Drive(0.24 / 0.045, 0.24 / 0.045);
    StepFor(physics, 3.0);
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
      physics.Step();
      ride.speed_m_s += physics.VelocityOfBase().x() / kSteps;
      for (int motor = 0; motor < 4; ++motor)
        ride.torque_Nm += physics.data().actuator_force[motor] / kSteps;
      for (int k = 0; k < physics.data().ncon; ++k) {
        std::array<mjtNum, 6> force{};
        mj_contactForce(&physics.model(), &physics.data(), k, force.data());
        for (std::size_t axis = 0; axis < 3; ++axis)
          ride.push_N += force[axis] * physics.data().contact[k].frame[3 * axis] / kSteps;
      }
    }
    return ride;
  };
  const Ride dry = ride_through(0.0), wading = ride_through(0.06);
  EXPECT_EQ(dry.depth_m, 0.0);
  EXPECT_NEAR(dry.push_N, 0.0, 0.005);
  EXPECT_GT(wading.depth_m, 0.03);
  const double drag_N =
      4.0 * 0.5 * 1000.0 * 0.024 * wading.depth_m * wading.speed_m_s * wading.speed_m_s;
  EXPECT_NEAR(wading.push_N, drag_N, 0.05 * drag_N);
  EXPECT_GT(wading.torque_Nm, dry.torque_Nm + 0.5 * drag_N * 0.045);
}

TEST_F(OnTheGround, GivesWayToAFrictionThatIsToldToHoldEverywhere) {
  network::Network network = Falling(0.2);
  network.pipes[0].condition = WallCondition::kSlimy;
  const Place place(network);
  PhysicsOptions options = Options();
  options.wheel_friction = 0.7;
  Physics physics(place.field, description_, options, place.ground);
  physics.Place(place.sewer, {"P", 2.0, true, 0.0, 0.0});
  StepFor(physics, 0.5);
  EXPECT_LT(physics.VelocityOfBase().norm(), kCreep_m_s);
}

// What the solver is told: each wheel's loss is lever arm times a quarter of the weight; the boxes
// have the hull's friction; water lifts each wheel and drags it back along the way it goes, here y.
TEST_F(OnTheGround, TellsTheSolverOfLossLiftAndDragAtEachWheel) {
  network::Network network = Falling(0.0);
  network.manholes[1].p_WM = {0.0, 10.0, 0.0};
  const Place place(network);
  constexpr double kWater_m = 0.03;
  const auto ground = [](const Vector3d&) { return Footing{{0.6, 0.4, 0.003}, kWater_m}; };
  Physics physics(place.field, description_, Options(), ground);
  physics.Place(place.sewer, {"P", 2.0, true, 0.0, 0.0});
  physics.Drive(0.2 / 0.045, 0.2 / 0.045);
  StepFor(physics, 2.0);
  const mjModel& model = physics.model();
  const double speed_m_s = physics.VelocityOfBase().y();
  EXPECT_NEAR(speed_m_s, 0.2, 0.01);
  for (const std::string& name : description_.wheels) {
    const robot::Tyre& tyre = description_.tyres.at(name);
    const WadingWheel wading{tyre.radius_m, 2.0 * tyre.tread_radius_m};
    const int joint = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
    EXPECT_NEAR(model.dof_frictionloss[model.jnt_dofadr[joint]],
                0.003 * description_.TotalMass_kg() * 9.81 / 4.0, 1e-9);
    const mjtNum* force_W = physics.data().xfrc_applied + 6 * model.jnt_bodyid[joint];
    EXPECT_NEAR(force_W[2], WadingLift_N(wading, kWater_m), 1e-12);
    const double drag_N = WadingDrag_N(wading, kWater_m, speed_m_s);
    EXPECT_NEAR(force_W[1], -drag_N, 0.05 * drag_N);
    EXPECT_NEAR(force_W[0], 0.0, 0.05 * drag_N);
  }
}

TEST_F(OnTheGround, GivesABoxThatTouchesTheHullsFriction) {
  const Place place(Falling(0.0));
  const auto ground = [](const Vector3d&) { return Footing{{0.6, 0.37, 0.001}, 0.0}; };
  Physics physics(place.field, description_, Options(), ground);
  physics.Place(place.sewer, {"P", 2.0, true, 2.0, 0.0});  // on its side
  StepFor(physics, 0.1);
  int boxes = 0;
  for (int i = 0; i < physics.data().ncon; ++i) {
    const int geom = physics.data().contact[i].geom2;
    if (physics.model().geom_type[geom] != mjGEOM_BOX) continue;
    ++boxes;
    EXPECT_EQ(physics.model().geom_friction[3 * geom], 0.37);
  }
  EXPECT_GT(boxes, 0);
}

TEST_F(OnTheGround, ScalesWithTheFactor) {
  network::Network network = Falling(0.2);
  network.pipes[0].condition = WallCondition::kSlimy;
  const Place place(network);
  PhysicsOptions options = Options();
  options.friction_factor = 2.5;  // 0.12 to 0.3
  Physics physics(place.field, description_, options, place.ground);
  physics.Place(place.sewer, {"P", 2.0, true, 0.0, 0.0});
  StepFor(physics, 0.5);
  EXPECT_LT(physics.VelocityOfBase().norm(), kCreep_m_s);
}

}  // namespace
}  // namespace kantaro::sim
