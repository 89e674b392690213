#include "sim/contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

VoidPrimitive Pipe(double radius_m) {
  VoidPrimitive pipe;
  pipe.length_m = 4.0;
  pipe.radius_m = radius_m;
  return pipe;
}

/// A wheel whose plane holds the pipe's axis direction and the direction to the wall: it meets the
/// wall squarely.
Torus SquareWheel(double lean_rad, double center_from_axis_m) {
  const Vector3d down(0.0, std::sin(lean_rad), -std::cos(lean_rad));
  return {Vector3d(2.0, 0.0, 0.0) + center_from_axis_m * down, Vector3d::UnitX().cross(down), 0.033,
          0.012};
}

TEST(TorusContacts, AWheelStandsOnOnePointOfARoundWall) {
  const VoidField field({Pipe(0.125)});
  // 2 mm into the wall: hub to tread is 45 mm.
  const auto contacts = TorusContacts(field, SquareWheel(0.5, 0.125 - 0.045 + 0.002), 0.0);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].distance_m, -0.002, 1e-6);
  const Vector3d up(0.0, -std::sin(0.5), std::cos(0.5));
  EXPECT_TRUE(contacts[0].normal_W.isApprox(up, 1e-3));
  EXPECT_NEAR(contacts[0].p_WC.x(), 2.0, 1e-4);
}

TEST(TorusContacts, KeepsOffWhatIsFartherThanTheMargin) {
  const VoidField field({Pipe(0.125)});
  EXPECT_TRUE(TorusContacts(field, SquareWheel(0.5, 0.125 - 0.045 - 0.003), 0.002).empty());
  EXPECT_EQ(TorusContacts(field, SquareWheel(0.5, 0.125 - 0.045 - 0.003), 0.004).size(), 1u);
}

// A wheel in front of a step (the mouth of a narrower pipe, on the same axis) touches the floor and
// the edge.
TEST(TorusContacts, FindsFloorAndEdgeAtAStep) {
  VoidPrimitive wide = Pipe(0.150);
  wide.length_m = 2.0;
  VoidPrimitive narrow = Pipe(0.140);
  narrow.X_WS.translation().x() = 1.999;
  const VoidField field({wide, narrow});
  // Upright wheel on the invert: the edge, 10 mm high, is touched where the rim's circle passes it.
  const double hub_above_floor = 0.045;
  const double ahead =
      std::sqrt(0.045 * 0.045 - (hub_above_floor - 0.010) * (hub_above_floor - 0.010));
  Torus wheel{Vector3d(2.0 - ahead, 0.0, -0.150 + hub_above_floor), Vector3d::UnitY(), 0.033,
              0.012};
  const auto contacts = TorusContacts(field, wheel, 0.0005);
  ASSERT_EQ(contacts.size(), 2u);
  for (const WallContact& contact : contacts) EXPECT_NEAR(contact.distance_m, 0.0, 0.0003);
  const auto& edge = contacts[0].normal_W.x() < -0.1 ? contacts[0] : contacts[1];
  EXPECT_NEAR(edge.normal_W.z(), (hub_above_floor - 0.010) / 0.045, 0.02);
}

/// Pebbles around a wheel whose hub is at the origin, in its plane: each so many degrees from its
/// lowest point (ahead is positive) and so deep in its tread.
struct Pebble {
  double ahead_deg{}, depth_m{};
};
const Torus kWheel{Vector3d::Zero(), Vector3d::UnitY(), 0.033, 0.012};

Vector3d Outwards(double ahead_deg) {
  const double angle = ahead_deg * std::numbers::pi / 180.0;
  return {std::sin(angle), 0.0, -std::cos(angle)};
}

VoidField Among(const std::vector<Pebble>& pebbles) {
  VoidPrimitive hall = Pipe(0.2);
  hall.X_WS.translation().x() = -2.0;
  std::vector<SolidPrimitive> solids;
  for (const auto& [ahead_deg, depth_m] : pebbles) {
    Ball ball;
    ball.radius_m = 0.004;
    ball.foot_m = -ball.radius_m;
    ball.p_WB = (kWheel.ring_m + kWheel.tread_m + ball.radius_m - depth_m) * Outwards(ahead_deg);
    SolidPrimitive& solid = solids.emplace_back();
    solid.shape = ball;
  }
  return VoidField({hall}, solids);
}

// Normals 23 degrees apart count as one side, and that stands on its deepest place.
TEST(TorusContacts, KeepsTheDeeperOfTwoOnOneSide) {
  for (const double sign : {-1.0, 1.0}) {
    const auto contacts =
        TorusContacts(Among({{sign * 17.0, 0.002}, {sign * -6.0, 0.001}}), kWheel, 0.0);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].distance_m, -0.002, 1e-6);
    EXPECT_LT((contacts[0].normal_W + Outwards(sign * 17.0)).norm(), 1e-3);
  }
}

// Twelve on sides of their own, of which eight are kept.
TEST(TorusContacts, KeepsTheDeepestAndGivesThemFirst) {
  std::vector<Pebble> pebbles;
  for (int i = 0; i < 12; ++i) pebbles.push_back({30.0 * i + 5.0, 1e-4 * ((7 * i) % 12 + 1)});
  const auto contacts = TorusContacts(Among(pebbles), kWheel, 0.0);
  ASSERT_EQ(contacts.size(), kMostContacts);
  for (std::size_t i = 0; i < kMostContacts; ++i)
    EXPECT_NEAR(contacts[i].distance_m, -1e-4 * (12.0 - static_cast<double>(i)), 1e-6) << i;
}

TEST(BoxContacts, ABoxLyingInAPipeIsHeldAtBothEndsAndBothSides) {
  const VoidField field({Pipe(0.150)});
  SolidBox box;
  box.half_m = {0.14, 0.035, 0.03};
  // Lower edges at y = ±35 mm rest on the wall where it is sqrt(150² − 35²) below the axis; 1 mm
  // deeper.
  box.X_WB.translation() =
      Vector3d(2.0, 0.0, -(std::sqrt(0.150 * 0.150 - 0.035 * 0.035) - 0.03 + 0.001));
  const auto contacts = BoxContacts(field, box, 0.0);
  // However many there are along an edge, its ends are among them: all four lower corners.
  for (const double ahead : {-1.0, 1.0}) {
    for (const double left : {-1.0, 1.0}) {
      EXPECT_TRUE(std::any_of(contacts.begin(), contacts.end(),
                              [&](const WallContact& contact) {
                                const Vector3d from_middle = contact.p_WC - box.X_WB.translation();
                                return ahead * from_middle.x() > 0.1 &&
                                       left * from_middle.y() > 0.02 && contact.distance_m < 0.0;
                              }))
          << ahead << " " << left;
    }
  }
}

}  // namespace
}  // namespace kantaro::sim
