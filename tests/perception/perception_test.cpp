#include "perception/perception.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "pipe_view.hpp"

namespace kantaro::perception {
namespace {

using std::chrono::milliseconds;

robot::Description Robot() {
  robot::Description description;
  description.wheels = {"fl", "fr", "rl", "rr"};
  for (const auto& wheel : description.wheels) description.tyres[wheel] = {0.045, 0.012};
  description.front_camera = FrontCamera();
  return description;
}

Perception Shipped() {
  return {Robot(),
          ReadParameters(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/perception.yaml")};
}

template <typename Value>
robot::Reading At(int ms, Value value) {
  return {milliseconds(ms), milliseconds(ms + 60), std::move(value)};
}

/// So far all round, but for the floor, on which the robot stands.
robot::LaserRevolution Round(double range_m) {
  robot::LaserRevolution revolution;
  for (int i = 0; i < 336; ++i) {
    const double here_m = i > 224 && i < 280 ? 0.150 : range_m;
    revolution.samples.push_back(
        {2 * std::numbers::pi * i / 336, here_m,
         here_m < 0.19 ? robot::RangeStatus::kValid : robot::RangeStatus::kTooFar});
  }
  return revolution;
}

TEST(Perception, SaysWhereJointsAndFaultsAreInAFrontImage) {
  Perception perception = Shipped();
  perception.SetPipeDiameter(0.300);
  const cv::Mat image = Draw({.joints = {{.distance_m = 0.95}},
                              .cracks = {{.clock_h = 3.0, .near_m = 0.60, .far_m = 0.70}}});
  const auto observations = perception.Process(At(100, robot::FrontImage{image}));
  ASSERT_EQ(observations.size(), 2U);
  const auto& rings = std::get<RingObservation>(observations[0]);
  EXPECT_EQ(rings.captured_at, milliseconds(100));  // of capture, not arrival
  ASSERT_EQ(rings.rings.size(), 1U);
  EXPECT_NEAR(rings.rings[0].distance_m, 0.95, 0.02);
  const auto& faults = std::get<FaultObservation>(observations[1]);
  EXPECT_EQ(faults.captured_at, milliseconds(100));
  ASSERT_EQ(faults.candidates.size(), 1U);
  EXPECT_NEAR(faults.candidates[0].clock_h, 3.0, 0.5);
}

TEST(Perception, TakesTheScaleFromTheDiameterItIsTold) {
  Perception perception = Shipped();
  const cv::Mat image = Draw({.radius_m = 0.125, .joints = {{.distance_m = 0.60}}});
  perception.SetPipeDiameter(0.250);
  auto rings =
      std::get<RingObservation>(perception.Process(At(0, robot::FrontImage{image}))[0]).rings;
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0].distance_m, 0.60, 0.02);
  perception.SetPipeDiameter(0.300);  // wrong by 20 %, and so is the distance
  rings = std::get<RingObservation>(perception.Process(At(200, robot::FrontImage{image}))[0]).rings;
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0].distance_m, 0.72, 0.02);
}

TEST(Perception, KeepsQuietAboutImagesBeforeItKnowsTheDiameter) {
  Perception perception = Shipped();
  EXPECT_TRUE(
      perception.Process(At(0, robot::FrontImage{cv::Mat(480, 704, CV_8UC3, cv::Scalar::all(90))}))
          .empty());
}

TEST(Perception, SeesNothingInABlackImage) {
  Perception perception = Shipped();
  perception.SetPipeDiameter(0.3);
  const auto observations =
      perception.Process(At(0, robot::FrontImage{cv::Mat::zeros(480, 704, CV_8UC3)}));
  ASSERT_EQ(observations.size(), 2U);
  EXPECT_TRUE(std::get<RingObservation>(observations[0]).rings.empty());
  EXPECT_TRUE(std::get<FaultObservation>(observations[1]).candidates.empty());
}

TEST(Perception, RefusesImagesThatAreNotTheCameras) {
  Perception perception = Shipped();
  perception.SetPipeDiameter(0.3);
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(480, 704, CV_8UC1), cv::Mat(480, 704, CV_16UC3),
                               cv::Mat(480, 640, CV_8UC3)}) {
    EXPECT_THROW((void)perception.Process(At(0, robot::FrontImage{image})), std::invalid_argument);
  }
}

TEST(Perception, ReportsTheRevolutionAtWhichTheTopOpened) {
  Perception perception = Shipped();
  std::vector<WindowEdge> edges;
  for (int i = 0; i < 10; ++i) {
    const auto observations = perception.Process(At(33 * i, Round(i < 5 ? 0.150 : 0.190)));
    ASSERT_EQ(observations.size(), 1U);
    const auto& laser = std::get<LaserObservation>(observations[0]);
    EXPECT_EQ(laser.status, i < 5 ? LaserStatus::kNoLandmark : LaserStatus::kOutsideThePipe);
    edges.insert(edges.end(), laser.edges.begin(), laser.edges.end());
  }
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_EQ(edges[1].window, LaserWindow::kTop);
  EXPECT_TRUE(edges[1].open);
  EXPECT_EQ(edges[1].at, milliseconds(165));
}

TEST(Perception, PassesOverAnEmptyRevolution) {
  EXPECT_TRUE(Shipped().Process(At(0, robot::LaserRevolution{})).empty());
}

TEST(Perception, GivesOneObservationForEachOtherSensor) {
  Perception perception = Shipped();
  EXPECT_TRUE(std::holds_alternative<IrObservation>(
      perception.Process(At(1, robot::IrRanges{{0.5}, {0.5}, {0.5}})).at(0)));
  EXPECT_NEAR(std::get<OdometryObservation>(
                  perception.Process(At(2, robot::WheelEncoders{{2, 2, 2, 2}})).at(0))
                  .travel_m,
              0.090, 1e-12);
  EXPECT_TRUE(std::holds_alternative<AttitudeObservation>(
      perception.Process(At(3, robot::InertialReading{})).at(0)));
}

LossObservation OnlyLoss(const std::vector<Observation>& observations) {
  return std::get<LossObservation>(observations.at(0));
}

TEST(Perception, HandsLossesOn) {
  Perception perception = Shipped();
  const LossObservation loss =
      OnlyLoss(perception.Process(At(7, robot::Loss{robot::Sensor::kLaser, 2, true})));
  EXPECT_EQ(loss.sensor, robot::Sensor::kLaser);
  EXPECT_EQ(loss.cause, LossObservation::Cause::kLineDown);
  EXPECT_EQ(loss.captured_at, milliseconds(7));
  EXPECT_EQ(OnlyLoss(perception.Process(At(8, robot::Loss{robot::Sensor::kLaser, 2, false}))).cause,
            LossObservation::Cause::kMissing);
}

TEST(Perception, BelievesNoSensorThatHangs) {
  Perception perception = Shipped();
  for (int i = 1; i < 8; ++i) {
    EXPECT_TRUE(std::holds_alternative<AttitudeObservation>(
        perception.Process(At(10 * i, robot::InertialReading{})).at(0)));
  }
  EXPECT_EQ(OnlyLoss(perception.Process(At(80, robot::InertialReading{}))).cause,
            LossObservation::Cause::kStuck);
  EXPECT_TRUE(std::holds_alternative<AttitudeObservation>(
      perception.Process(At(90, robot::InertialReading{{0.01, 0, 0}, {0, 0, 9.8}})).at(0)));
}

TEST(Perception, BelievesNoGyroAtTheEndOfItsScale) {
  robot::Description robot = Robot();
  robot.inertial.gyro_range_rad_s = 4.0;
  Perception perception(robot, {});
  EXPECT_EQ(
      OnlyLoss(perception.Process(At(0, robot::InertialReading{{0, 0, -4.0}, {0, 0, 9.8}}))).cause,
      LossObservation::Cause::kImplausible);
  EXPECT_TRUE(std::holds_alternative<AttitudeObservation>(
      perception.Process(At(10, robot::InertialReading{{0, 0, -3.9}, {0, 0, 9.8}})).at(0)));
}

TEST(Perception, BelievesNoLaserThatDoesNotSeeTheFloor) {
  robot::LaserRevolution dazzled = Round(0.190);
  for (robot::LaserSample& sample : dazzled.samples)
    sample = {sample.angle_rad, 0.190, robot::RangeStatus::kTooFar};
  Perception perception = Shipped();
  EXPECT_EQ(OnlyLoss(perception.Process(At(0, dazzled))).cause,
            LossObservation::Cause::kImplausible);
}

TEST(Perception, TellsInclinationAndBattery) {
  Perception perception = Shipped();
  const auto leaning = std::get<InclinationObservation>(
      perception.Process(At(1, robot::Inclination{0.1, -0.2})).at(0));
  EXPECT_EQ(leaning.roll_rad, 0.1);
  EXPECT_EQ(leaning.pitch_rad, -0.2);
  const auto battery = std::get<BatteryObservation>(
      perception.Process(At(2, robot::BatteryState{14.0, 2.0, 0.3})).at(0));
  EXPECT_EQ(battery.charge, 0.3);
  EXPECT_TRUE(perception.Process(At(3, robot::CompassHeading{})).empty());
}

TEST(Perception, HasNothingToSayAboutStereo) {
  EXPECT_TRUE(Shipped().Process(At(0, robot::StereoPair{})).empty());
}

TEST(Perception, RefusesADiameterThatIsNone) {
  Perception perception = Shipped();
  EXPECT_THROW(perception.SetPipeDiameter(0.0), std::invalid_argument);
  EXPECT_THROW(perception.SetPipeDiameter(-0.3), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
