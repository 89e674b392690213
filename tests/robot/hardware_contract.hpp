#pragma once

// The contract of robot::Hardware (robot/hardware.hpp) as tests. A back end joins with one line:
//
//   INSTANTIATE_TEST_SUITE_P(Sim, HardwareContract, testing::Values(BackEnd{"pipe", MakeTwin}),
//   Name);
//
// Include it in one source file of a test program.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "robot/hardware.hpp"

namespace kantaro::robot {

/// A back end as the suite sees it.
struct BackEnd {
  std::string name;
  /// A fresh run of a robot at rest, its encoders among its sensors, that can be read for
  /// kContractTime at least.
  std::function<std::unique_ptr<Hardware>()> make;
  /// The same with a sensor that loses readings within that time; empty if it never does.
  std::function<std::unique_ptr<Hardware>()> make_losing;
};

inline constexpr RunTime kContractTime = std::chrono::seconds(1);

/// What the suite tells the robot: after each reading of the encoders, the same. A recording for
/// the suite is one of a robot that was told just this.
inline constexpr Command kContractCommand{1.0, 1.5, 0.5};
[[nodiscard]] inline bool CommandIsDue(const Reading& reading) {
  return std::holds_alternative<WheelEncoders>(reading.value);
}

/// Replaces the n-th reading (from 1) of another back end by its loss.
class LosesNthReading : public Hardware {
 public:
  LosesNthReading(std::unique_ptr<Hardware> hardware, int n)
      : hardware_(std::move(hardware)), n_(n) {}
  [[nodiscard]] std::optional<Reading> Read() override {
    std::optional<Reading> reading = hardware_->Read();
    if (reading && ++count_ == n_) reading->value = Loss{SensorOf(*reading), 1, false};
    return reading;
  }
  CommandOutcome Apply(const Command& command) override { return hardware_->Apply(command); }
  void Stop() override { hardware_->Stop(); }
  [[nodiscard]] RunTime Now() const override { return hardware_->Now(); }

 private:
  std::unique_ptr<Hardware> hardware_;
  int n_, count_{};
};

class HardwareContract : public testing::TestWithParam<BackEnd> {
 protected:
  /// Reads for kContractTime, telling the robot what the suite tells it.
  static std::vector<Reading> Drive(Hardware& hardware) {
    std::vector<Reading> readings;
    while (hardware.Now() < kContractTime) {
      std::optional<Reading> reading = hardware.Read();
      if (!reading) break;
      if (CommandIsDue(*reading)) {
        EXPECT_EQ(hardware.Apply(kContractCommand), CommandOutcome::kHonoured);
      }
      readings.push_back(std::move(*reading));
    }
    EXPECT_GE(hardware.Now(), kContractTime) << "the run is too short for this suite";
    return readings;
  }

  static void ExpectOrder(const std::vector<Reading>& readings) {
    RunTime last{};
    for (const Reading& reading : readings) {
      EXPECT_GE(reading.captured_at, RunTime{});
      EXPECT_LE(reading.captured_at, reading.arrived_at) << ToString(SensorOf(reading));
      EXPECT_GE(reading.arrived_at, last) << ToString(SensorOf(reading));
      last = reading.arrived_at;
    }
  }
};

/// Every number of a reading is finite and in its range.
struct CheckNumbers {
  void operator()(const FrontImage& front) const { EXPECT_EQ(front.image.type(), CV_8UC3); }
  void operator()(const StereoPair& pair) const {
    EXPECT_EQ(pair.left.type(), CV_8UC3);
    EXPECT_EQ(pair.left.size(), pair.right.size());
  }
  void operator()(const LaserRevolution& revolution) const {
    for (const LaserSample& sample : revolution.samples) {
      EXPECT_TRUE(sample.angle_rad >= 0.0 && sample.angle_rad < 2.0 * std::numbers::pi);
      EXPECT_TRUE(std::isfinite(sample.range_m) && sample.range_m >= 0.0);
    }
  }
  void operator()(const IrRanges& ranges) const {
    for (const IrReading& reading : {ranges.up, ranges.left, ranges.right})
      EXPECT_TRUE(reading.value >= 0.0 && reading.value <= 1.0) << reading.value;
  }
  void operator()(const WheelEncoders& encoders) const {
    for (const double angle_rad : encoders.angle_rad) EXPECT_TRUE(std::isfinite(angle_rad));
  }
  void operator()(const InertialReading& inertial) const {
    EXPECT_TRUE(inertial.angular_velocity_rad_s.allFinite());
    EXPECT_TRUE(inertial.specific_force_m_s2.allFinite());
  }
  void operator()(const Inclination& inclination) const {
    EXPECT_TRUE(std::isfinite(inclination.roll_rad) && std::isfinite(inclination.pitch_rad));
  }
  void operator()(const CompassHeading& compass) const {
    EXPECT_TRUE(compass.heading_rad >= 0.0 && compass.heading_rad < 2.0 * std::numbers::pi);
  }
  void operator()(const BatteryState& battery) const {
    EXPECT_TRUE(std::isfinite(battery.voltage_V) && std::isfinite(battery.current_A));
    EXPECT_TRUE(battery.charge >= 0.0 && battery.charge <= 1.0);
  }
  void operator()(const Loss& loss) const { EXPECT_TRUE(loss.readings > 0 || loss.line_down); }
};

TEST_P(HardwareContract, ReadingsComeInOrderAndNoneBeforeItsCapture) {
  const auto hardware = GetParam().make();
  EXPECT_EQ(hardware->Now(), RunTime{});
  ExpectOrder(Drive(*hardware));
}

TEST_P(HardwareContract, NowIsTheArrivalOfTheLastReading) {
  const auto hardware = GetParam().make();
  for (int i = 0; i < 20; ++i) {
    const std::optional<Reading> reading = hardware->Read();
    ASSERT_TRUE(reading);
    EXPECT_EQ(hardware->Now(), reading->arrived_at);
  }
}

TEST_P(HardwareContract, EveryNumberIsFiniteAndInItsRange) {
  const auto hardware = GetParam().make();
  for (const Reading& reading : Drive(*hardware)) std::visit(CheckNumbers{}, reading.value);
}

TEST_P(HardwareContract, AnImageOnceHandedOverIsNeverWrittenAgain) {
  const auto hardware = GetParam().make();
  std::vector<std::pair<cv::Mat, cv::Mat>> images;  // as handed over, and a copy made then
  const auto keep = [&](const cv::Mat& image) { images.emplace_back(image, image.clone()); };
  while (hardware->Now() < kContractTime) {
    const std::optional<Reading> reading = hardware->Read();
    ASSERT_TRUE(reading);
    if (const auto* front = std::get_if<FrontImage>(&reading->value)) keep(front->image);
    if (const auto* pair = std::get_if<StereoPair>(&reading->value))
      keep(pair->left), keep(pair->right);
  }
  for (const auto& [image, copy] : images) {
    ASSERT_TRUE(image.isContinuous());
    EXPECT_TRUE(std::equal(image.datastart, image.dataend, copy.datastart, copy.dataend));
  }
}

TEST_P(HardwareContract, CommandsBeyondTheMotorsAreNotHonoured) {
  const auto hardware = GetParam().make();
  ASSERT_TRUE(hardware->Read());
  EXPECT_NE(hardware->Apply({1e6, 1e6, 1.0}), CommandOutcome::kHonoured);
}

TEST_P(HardwareContract, CommandsThatAreNoNumbersAreMisuse) {
  const auto hardware = GetParam().make();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  for (const Command& bad :
       {Command{nan, 0.0, 1.0}, Command{0.0, infinite, 1.0}, Command{0.0, 0.0, nan},
        Command{0.0, 0.0, 1.5}, Command{0.0, 0.0, -0.1}}) {
    EXPECT_THROW(hardware->Apply(bad), std::invalid_argument);
  }
  ExpectOrder(Drive(*hardware));  // and the run is none the worse
}

TEST_P(HardwareContract, StopIsObeyedInMotionAndNoLaterCommandMovesTheWheels) {
  const auto hardware = GetParam().make();
  Drive(*hardware);
  hardware->Stop();
  const RunTime stopped_at = hardware->Now();
  std::optional<WheelEncoders> standing;
  while (hardware->Now() < stopped_at + 2 * kContractTime) {
    const std::optional<Reading> reading = hardware->Read();
    if (!reading) break;
    EXPECT_EQ(hardware->Apply(kContractCommand), CommandOutcome::kRefused);
    const auto* wheels = std::get_if<WheelEncoders>(&reading->value);
    if (wheels == nullptr || reading->captured_at < stopped_at + kContractTime) continue;
    if (!standing) standing = *wheels;
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(wheels->angle_rad[i], standing->angle_rad[i], 0.02) << "wheel " << i;
  }
  EXPECT_EQ(hardware->Apply(kContractCommand), CommandOutcome::kRefused);
}

TEST_P(HardwareContract, StopIsObeyedBeforeTheFirstReadingAndTwice) {
  const auto hardware = GetParam().make();
  hardware->Stop();
  hardware->Stop();
  EXPECT_EQ(hardware->Apply(kContractCommand), CommandOutcome::kRefused);
}

TEST_P(HardwareContract, AFaultOnTheNthReadIsToldInItsPlaceAndTheRunGoesOn) {
  for (const int n : {1, 2, 7, 50}) {
    LosesNthReading faulty(GetParam().make(), n);
    std::vector<Reading> readings;
    while (readings.size() < 60) {
      std::optional<Reading> reading = faulty.Read();
      ASSERT_TRUE(reading);
      if (CommandIsDue(*reading)) faulty.Apply(kContractCommand);
      readings.push_back(std::move(*reading));
    }
    ExpectOrder(readings);
    EXPECT_TRUE(std::holds_alternative<Loss>(readings[static_cast<std::size_t>(n) - 1].value));
    EXPECT_FALSE(std::holds_alternative<Loss>(readings.back().value)) << "n = " << n;
  }
}

TEST_P(HardwareContract, LostReadingsAreTold) {
  if (!GetParam().make_losing) GTEST_SKIP() << GetParam().name << " loses nothing by itself";
  const auto hardware = GetParam().make_losing();
  std::vector<Reading> readings;
  while (hardware->Now() < kContractTime) {
    std::optional<Reading> reading = hardware->Read();
    if (!reading) break;
    readings.push_back(std::move(*reading));
  }
  ExpectOrder(readings);
  EXPECT_TRUE(std::any_of(readings.begin(), readings.end(), [](const Reading& reading) {
    return std::holds_alternative<Loss>(reading.value);
  }));
}

TEST_P(HardwareContract, ARunThatIsOverStaysOver) {
  const auto hardware = GetParam().make();
  hardware->Stop();
  constexpr RunTime kPatience = std::chrono::seconds(20);
  while (hardware->Now() < kPatience && hardware->Read()) {
  }
  if (hardware->Now() >= kPatience) GTEST_SKIP() << "a device is never over";
  EXPECT_FALSE(hardware->Read());
  EXPECT_FALSE(hardware->Read());
}

}  // namespace kantaro::robot
