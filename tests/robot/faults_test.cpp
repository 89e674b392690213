#include "robot/faults.hpp"

#include <gmock/gmock.h>

#include <deque>
#include <opencv2/core.hpp>

#include "base/input_error.hpp"
#include "tests/robot/robot_files.hpp"

namespace kantaro::robot {
namespace {

using std::chrono::milliseconds;

const Description& Kantaro() {
  static const Description robot = ReadDescription(ModelFolder());
  return robot;
}

/// Hands over what it was given.
class Script : public Hardware {
 public:
  explicit Script(std::deque<Reading> readings) : readings_(std::move(readings)) {}
  [[nodiscard]] std::optional<Reading> Read() override {
    if (readings_.empty()) return {};
    Reading next = std::move(readings_.front());
    readings_.pop_front();
    now_ = next.arrived_at;
    return next;
  }
  CommandOutcome Apply(const Command& command) override {
    applied = command;
    return CommandOutcome::kLimited;
  }
  void Stop() override { stopped = true; }
  [[nodiscard]] RunTime Now() const override { return now_; }
  Command applied;
  bool stopped{};

 private:
  std::deque<Reading> readings_;
  RunTime now_{};
};

/// Ten readings of each of two sensors, 10 ms apart: the wheels' n-th, from 1, says n rad, the
/// battery's n V, 1 ms after it was measured.
std::deque<Reading> TenOfEach() {
  std::deque<Reading> readings;
  for (int n = 1; n <= 10; ++n) {
    const RunTime at = milliseconds(10 * n);
    readings.push_back({at, at, WheelEncoders{{1.0 * n, 1.0 * n, 1.0 * n, 1.0 * n}}});
    readings.push_back({at, at + milliseconds(1), BatteryState{1.0 * n, 2.0, 0.5}});
  }
  return readings;
}

std::vector<Reading> ReadAll(std::deque<Reading> readings, const std::vector<Fault>& faults,
                             std::uint64_t seed = 1) {
  Script script(std::move(readings));
  Faulted faulted(script, Kantaro(), faults, seed);
  std::vector<Reading> all;
  while (auto reading = faulted.Read()) {
    EXPECT_EQ(faulted.Now(), script.Now());
    if (!all.empty()) {
      EXPECT_LE(all.back().arrived_at, reading->arrived_at);
    }
    EXPECT_LE(reading->captured_at, reading->arrived_at);
    all.push_back(*std::move(reading));
  }
  return all;
}

/// What the front left wheel says, reading by reading; −1 for a loss.
std::vector<double> Wheel(const std::vector<Reading>& readings) {
  std::vector<double> angles;
  for (const Reading& reading : readings) {
    if (SensorOf(reading) != Sensor::kEncoders) continue;
    const auto* encoders = std::get_if<WheelEncoders>(&reading.value);
    angles.push_back(encoders != nullptr ? encoders->angle_rad[0] : -1.0);
  }
  return angles;
}

Fault Of(Sensor sensor, FaultKind kind, double amount = 0.0) {
  return {sensor, kind, {}, {}, 1, amount};
}

using testing::ElementsAre;

TEST(Faulted, ChangesNothingWithoutFaults) {
  const auto readings = ReadAll(TenOfEach(), {});
  EXPECT_EQ(readings.size(), 20u);
  EXPECT_THAT(Wheel(readings), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
}

TEST(Faulted, FreezesAtTheLastReadingBefore) {
  Fault fault = Of(Sensor::kEncoders, FaultKind::kFrozen);
  fault.from = milliseconds(40);
  fault.until = milliseconds(80);
  const auto readings = ReadAll(TenOfEach(), {fault});
  EXPECT_THAT(Wheel(readings), ElementsAre(1, 2, 3, 3, 3, 3, 3, 8, 9, 10));
  EXPECT_EQ(readings[8].captured_at, milliseconds(50));  // the clock goes on
}

TEST(Faulted, FrozenFromTheBeginningItRepeatsItsFirstReading) {
  EXPECT_THAT(Wheel(ReadAll(TenOfEach(), {Of(Sensor::kEncoders, FaultKind::kFrozen)})),
              ElementsAre(1, 1, 1, 1, 1, 1, 1, 1, 1, 1));
}

TEST(Faulted, StrikesOnTheNthReading) {
  Fault fault = Of(Sensor::kEncoders, FaultKind::kDead);
  fault.from_reading = 7;
  EXPECT_THAT(Wheel(ReadAll(TenOfEach(), {fault})), ElementsAre(1, 2, 3, 4, 5, 6, -1, -1, -1, -1));
}

TEST(Faulted, ReportsWhatIsLostInItsPlace) {
  const auto readings = ReadAll(TenOfEach(), {Of(Sensor::kBattery, FaultKind::kDead)});
  ASSERT_EQ(readings.size(), 20u);
  const Loss& loss = std::get<Loss>(readings[3].value);
  EXPECT_EQ(loss.sensor, Sensor::kBattery);
  EXPECT_EQ(loss.readings, 1u);
  EXPECT_TRUE(loss.line_down);
  EXPECT_EQ(readings[3].captured_at, milliseconds(20));
  EXPECT_EQ(readings[3].arrived_at, milliseconds(21));
}

TEST(Faulted, DropsAShareByChanceAndTheSameOnesForOneSeed) {
  std::deque<Reading> many;
  for (int n = 0; n < 1000; ++n)
    many.push_back({milliseconds(n), milliseconds(n), WheelEncoders{}});
  const std::vector<Fault> faults{Of(Sensor::kEncoders, FaultKind::kDropped, 0.2)};
  const std::vector<double> first = Wheel(ReadAll(many, faults, 4));
  // 200 of 1000, standard deviation sqrt(1000 * 0.2 * 0.8) = 12.6
  EXPECT_NEAR(static_cast<double>(std::count(first.begin(), first.end(), -1.0)), 200.0, 51.0);
  EXPECT_EQ(first, Wheel(ReadAll(many, faults, 4)));
  EXPECT_NE(first, Wheel(ReadAll(many, faults, 5)));
  const auto readings = ReadAll(TenOfEach(), {Of(Sensor::kEncoders, FaultKind::kDropped, 1.0)});
  EXPECT_FALSE(std::get<Loss>(readings[0].value).line_down);
}

// Wheels 25 ms late among a battery's readings at 11, 21, 31 ms: each comes with the next arrival.
TEST(Faulted, DelaysWithoutTurningBackTheClock) {
  const auto readings = ReadAll(TenOfEach(), {Of(Sensor::kEncoders, FaultKind::kDelayed, 0.025)});
  std::vector<RunTime> arrivals;
  for (const Reading& reading : readings) {
    if (SensorOf(reading) == Sensor::kEncoders) arrivals.push_back(reading.arrived_at);
  }
  // Measured at 10 ms, due at 35 ms: the reading that arrives at 40 ms brings it. The last are due
  // when all is over.
  ASSERT_EQ(arrivals.size(), 7u);
  EXPECT_EQ(arrivals[0], milliseconds(40));
  EXPECT_EQ(arrivals[1], milliseconds(50));
  EXPECT_THAT(Wheel(readings), ElementsAre(1, 2, 3, 4, 5, 6, 7));
}

TEST(Faulted, BiasesOnlyTheSensorThatIsMeant) {
  const auto readings = ReadAll(TenOfEach(), {Of(Sensor::kBattery, FaultKind::kBiased, -0.5)});
  EXPECT_EQ(Wheel(readings)[4], 5.0);
  EXPECT_EQ(std::get<BatteryState>(readings[9].value).voltage_V, 4.5);
}

TEST(Faulted, DoesSeveralThingsToOneSensorInTheirOrder) {
  Fault frozen = Of(Sensor::kEncoders, FaultKind::kFrozen);
  frozen.from_reading = 3;
  EXPECT_THAT(Wheel(ReadAll(TenOfEach(), {frozen, Of(Sensor::kEncoders, FaultKind::kBiased, 1.0)})),
              ElementsAre(2, 4, 4, 4, 4, 4, 4, 4, 4, 4));
}

TEST(Faulted, HandsCommandsAndStopOn) {
  Script script({});
  Faulted faulted(script, Kantaro(), {Of(Sensor::kLaser, FaultKind::kDead)}, 1);
  EXPECT_EQ(faulted.Apply({1.0, 2.0, 0.5}), CommandOutcome::kLimited);
  EXPECT_EQ(script.applied.right_rad_s, 2.0);
  faulted.Stop();
  EXPECT_TRUE(script.stopped);
}

TEST(Faulted, RefusesWhatCannotBe) {
  Script script({});
  for (const Fault& fault :
       {Of(Sensor::kLaser, FaultKind::kDropped, 1.5), Of(Sensor::kLaser, FaultKind::kDelayed, -1.0),
        Of(Sensor::kLaser, FaultKind::kBiased, HUGE_VAL)}) {
    EXPECT_THROW(Faulted(script, Kantaro(), {fault}, 1), std::invalid_argument);
  }
}

template <typename Value>
Value Saturated(Value value) {
  Reading reading{{}, {}, std::move(value)};
  Saturate(reading, Kantaro());
  return std::get<Value>(reading.value);
}

template <typename Value>
Value Biased(Value value, double amount) {
  Reading reading{{}, {}, std::move(value)};
  Bias(reading, amount, Kantaro());
  return std::get<Value>(reading.value);
}

TEST(Saturate, PutsEachSensorAtTheEndOfItsScale) {
  EXPECT_EQ(cv::countNonZero(Saturated(FrontImage{cv::Mat::zeros(4, 5, CV_8UC1)}).image != 255), 0);
  const LaserSample near{1.0, 0.1, RangeStatus::kValid};
  const LaserSample dazzled = Saturated(LaserRevolution{{near}}).samples[0];
  EXPECT_EQ(dazzled.status, RangeStatus::kTooFar);
  EXPECT_EQ(dazzled.range_m, Kantaro().laser.range_max_m);
  EXPECT_EQ(dazzled.angle_rad, 1.0);
  EXPECT_EQ(Saturated(IrRanges{{0.1}, {0.2}, {0.3}}).left.value, 1.0);
  // 2^31 − 1 counts of 2 pi / 2000
  EXPECT_NEAR(Saturated(WheelEncoders{}).angle_rad[3], 2147483647.0 * 0.0031415926535898, 1e-3);
  const InertialReading inertial = Saturated(InertialReading{{0.1, -0.1, 0.0}, {0.0, 0.0, 9.8}});
  EXPECT_NEAR(inertial.angular_velocity_rad_s.x(), 4.363, 1e-9);
  EXPECT_NEAR(inertial.angular_velocity_rad_s.y(), -4.363, 1e-9);
  EXPECT_NEAR(inertial.specific_force_m_s2.z(), 19.6, 1e-9);
  EXPECT_NEAR(Saturated(Inclination{-0.01, 0.02}).roll_rad, -0.7854, 1e-4);
  EXPECT_TRUE(Saturated(CompassHeading{1.0, false}).disturbed);
  EXPECT_EQ(Saturated(BatteryState{11.0, 2.0, 0.01}).charge, 1.0);
}

TEST(Bias, AddsInTheSensorsOwnUnit) {
  const LaserRevolution revolution{{{0.0, 0.100, RangeStatus::kValid},
                                    {1.0, 0.185, RangeStatus::kValid},
                                    {2.0, 0.190, RangeStatus::kTooFar}}};
  const LaserRevolution farther = Biased(revolution, 0.010);
  EXPECT_NEAR(farther.samples[0].range_m, 0.110, 1e-7);
  EXPECT_EQ(farther.samples[1].status, RangeStatus::kTooFar);  // 195 mm
  EXPECT_EQ(farther.samples[2].status, RangeStatus::kTooFar);
  EXPECT_EQ(Biased(revolution, -0.040).samples[0].status, RangeStatus::kTooNear);  // 60 mm
  EXPECT_DOUBLE_EQ(Biased(IrRanges{{0.4}, {0.4}, {0.95}}, 0.1).up.value, 0.5);
  EXPECT_DOUBLE_EQ(Biased(IrRanges{{0.4}, {0.4}, {0.95}}, 0.1).right.value, 1.0);
  EXPECT_DOUBLE_EQ(Biased(WheelEncoders{{100.0, 0.0, 0.0, 0.0}}, 0.05).angle_rad[0], 105.0);
  EXPECT_DOUBLE_EQ(Biased(InertialReading{}, 0.02).angular_velocity_rad_s.z(), 0.02);
  EXPECT_DOUBLE_EQ(Biased(Inclination{0.1, 0.0}, -0.2).roll_rad, -0.1);
  EXPECT_NEAR(Biased(CompassHeading{0.1, false}, -0.2).heading_rad, 6.2832 - 0.1, 1e-4);
  const cv::Mat grey(2, 2, CV_8UC1, cv::Scalar(250));
  EXPECT_EQ(Biased(FrontImage{grey}, 20.0).image.at<unsigned char>(0, 0), 255);
  EXPECT_EQ(grey.at<unsigned char>(0, 0), 250);  // images are shared: the original stays
}

std::vector<Fault> Read(const std::string& text) {
  return ReadFaults(YamlNode::Parse(text, "faults.yaml"));
}

std::string Refusal(const std::string& text) {
  try {
    (void)Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ReadFaults, UnderstandsTimesReadingsAndAmounts) {
  const auto faults = Read(
      "- {sensor: laser, kind: biased, amount: 0.02, from_s: 3, until_s: 4.5}\n"
      "- {sensor: cameras, kind: dead, from_reading: 12}\n");
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[0].from, milliseconds(3000));
  EXPECT_EQ(faults[0].until, milliseconds(4500));
  EXPECT_EQ(faults[0].amount, 0.02);
  EXPECT_EQ(faults[1].sensor, Sensor::kFrontCamera);
  EXPECT_EQ(faults[2].sensor, Sensor::kStereoCameras);
  EXPECT_EQ(faults[2].from_reading, 12u);
  EXPECT_EQ(ToString(faults[0]), "laser biased by 0.02 from 3 s until 4.5 s");
}

TEST(ReadFaults, SaysWhatIsWrongWhere) {
  using testing::HasSubstr;
  EXPECT_THAT(Refusal("- {sensor: nose, kind: dead}"), HasSubstr("\"nose\" is no sensor; known"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: tired}"), HasSubstr("no kind of fault; known are"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: dead, amount: 1}"), HasSubstr("has no amount"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: dropped}"), HasSubstr("amount"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: dropped, amount: 2}"), HasSubstr("outside 0 to 1"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: dead, from_s: 2, until_s: 1}"),
              HasSubstr("after from_s"));
  EXPECT_THAT(Refusal("- {sensor: laser, kind: dead, when: 2}"), HasSubstr("unknown key"));
}

}  // namespace
}  // namespace kantaro::robot
