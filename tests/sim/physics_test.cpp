#include "sim/physics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "network/formats.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {
namespace {

constexpr double kGravity_m_s2 = 9.81;

class PhysicsTest : public testing::Test {
 protected:
  robot::Description description_ = robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  Sewer sewer_ =
      BuildSewer(network::ReadNetwork(KANTARO_SOURCE_DIR "/models/networks/test_field.yaml"));
  VoidField field_{sewer_.voids, sewer_.solids};

  Physics Make(double friction = 0.7) const {
    PhysicsOptions options;
    options.wheel_friction = friction;
    options.mast_height_m = description_.MastHeight(0.300);
    return Physics(field_, description_, options);
  }

  double DriveFor(Physics& physics, double seconds, double wheel_rad_s) const {
    const double until = physics.time_s() + seconds;
    const Eigen::Vector3d from = physics.PoseOfBase().translation();
    physics.Drive(wheel_rad_s, wheel_rad_s);
    while (physics.time_s() < until) physics.Step();
    return (physics.PoseOfBase().translation() - from).norm();
  }
};

// At rest the walls carry the robot: their forces add up to its weight, straight up.
TEST_F(PhysicsTest, WallForcesCarryTheWeight) {
  Physics physics = Make();
  physics.Place(sewer_, {"P1", 2.5, true, 0.0, 0.0});
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < physics.data().ncon; ++i) {
    std::array<mjtNum, 6> force{};
    mj_contactForce(&physics.model(), &physics.data(), i, force.data());
    const mjtNum* frame = physics.data().contact[i].frame;
    for (int axis = 0; axis < 3; ++axis) {
      sum += force[static_cast<std::size_t>(axis)] *
             Eigen::Vector3d(frame[3 * axis], frame[3 * axis + 1], frame[3 * axis + 2]);
    }
  }
  const double weight = description_.TotalMass_kg() * kGravity_m_s2;
  EXPECT_NEAR(sum.z(), weight, 0.01 * weight);
  EXPECT_LT(std::hypot(sum.x(), sum.y()), 0.01 * weight);
}

TEST_F(PhysicsTest, StandsStillWithBrakedWheels) {
  Physics physics = Make();
  physics.Place(sewer_, {"P1", 2.5, true, 0.0, 0.0});
  EXPECT_LT(DriveFor(physics, 5.0, 0.0), 0.001);
  EXPECT_FALSE(physics.Touches(description_.upper_box));
}

// Four wheels in a 300 mm pipe: a base height known from geometry (docs/robot.md).
TEST_F(PhysicsTest, SettlesAtTheDepthThatGeometryGives) {
  Physics physics = Make();
  for (const auto& [pipe, depth_m] : {std::pair{"P1", 0.0963}, std::pair{"P5", 0.0681}}) {
    physics.Place(sewer_, {pipe, 2.5, true, 0.0, 0.0});
    const std::size_t index = sewer_.network.FindPipe(pipe).value();
    const network::PipePosition at = sewer_.axes[index].Locate(physics.PoseOfBase().translation());
    EXPECT_NEAR(at.offset_m, depth_m, 0.002) << pipe;
    EXPECT_NEAR(at.clock_h, 6.0, 0.1) << pipe;
  }
}

TEST_F(PhysicsTest, RollsAsFarAsItsWheelsTurnOnDryPlastic) {
  Physics physics = Make(0.7);
  physics.Place(sewer_, {"P1", 1.0, true, 0.0, 0.0});
  (void)DriveFor(physics, 1.0, 0.12 / 0.045);  // past the start's jerk
  const double angle = physics.WheelAngles()[0];
  const double travelled = DriveFor(physics, 10.0, 0.12 / 0.045);
  const double rolled = 0.045 * (physics.WheelAngles()[0] - angle);
  EXPECT_NEAR(travelled / rolled, 1.0, 0.02);
  EXPECT_GT(travelled, 1.1);
}

TEST_F(PhysicsTest, FacesUpstreamWhenToldTo) {
  Physics physics = Make();
  physics.Place(sewer_, {"P1", 3.0, false, 0.0, 0.0});
  const double x = physics.PoseOfBase().translation().x();
  (void)DriveFor(physics, 3.0, 0.12 / 0.045);
  EXPECT_LT(physics.PoseOfBase().translation().x(), x - 0.3);
}

TEST_F(PhysicsTest, RepeatsToTheBit) {
  std::array<Eigen::Isometry3d, 2> end;
  for (Eigen::Isometry3d& X_WB : end) {
    Physics physics = Make();
    physics.Place(sewer_, {"P1", 5.5, true, 0.01, 0.02});
    (void)DriveFor(physics, 6.0, 0.12 / 0.045);  // through the first manhole's mouth
    X_WB = physics.PoseOfBase();
  }
  EXPECT_TRUE((end[0].matrix().array() == end[1].matrix().array()).all());
}

TEST_F(PhysicsTest, RefusesAPipeItDoesNotFit) {
  network::Network narrow = sewer_.network;
  for (network::Pipe& pipe : narrow.pipes) {
    pipe.diameter_m = 0.110;
    pipe.inlets.clear();
  }
  const Sewer sewer = BuildSewer(narrow);
  const VoidField field(sewer.voids, sewer.solids);
  PhysicsOptions options;
  Physics physics(field, description_, options);
  EXPECT_THROW(physics.Place(sewer, {"P1", 2.5, true, 0.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::sim
