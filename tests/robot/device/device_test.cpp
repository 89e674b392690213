// The device back end, through pseudo-terminals and pipes, against the emulator with a robot on a
// bench behind it.

#include "robot/device/device.hpp"

#include <gmock/gmock.h>

#include "tests/robot/device/played_robot.hpp"

namespace kantaro::robot {
namespace {

using namespace std::chrono_literals;

std::vector<Reading> ReadAll(Hardware& hardware) {
  std::vector<Reading> readings;
  while (auto reading = hardware.Read()) readings.push_back(*std::move(reading));
  return readings;
}

template <typename Value>
std::vector<std::pair<Reading, Value>> Of(const std::vector<Reading>& readings) {
  std::vector<std::pair<Reading, Value>> found;
  for (const Reading& reading : readings) {
    if (const auto* value = std::get_if<Value>(&reading.value)) found.emplace_back(reading, *value);
  }
  return found;
}

std::map<Sensor, std::uint32_t> Lost(const std::vector<Reading>& readings, bool line_down) {
  std::map<Sensor, std::uint32_t> lost;
  for (const auto& [reading, loss] : Of<Loss>(readings)) {
    if (loss.line_down == line_down) lost[loss.sensor] += loss.readings;
  }
  return lost;
}

TEST(Device, HandsOverWhatTheRobotMeasuredAtTheTimeItDid) {
  const std::vector<Reading> through_the_wire = ReadAll(*PlayBench({false, 1s}));
  BenchRobot bench(Kantaro(), {false, 1s});
  std::vector<Reading> direct = ReadAll(bench);
  ASSERT_GE(through_the_wire.size(), direct.size());
  for (std::size_t i = 0; i < direct.size(); ++i) {
    const Reading& sent = direct[i];
    const Reading& came = through_the_wire[i];
    ASSERT_EQ(came.value.index(), sent.value.index()) << i;
    EXPECT_LE(std::chrono::abs(came.captured_at - sent.captured_at), 1us) << i;
    EXPECT_EQ(came.arrived_at, sent.arrived_at) << i;
    if (const auto* turn = std::get_if<LaserRevolution>(&sent.value)) {
      const auto& samples = std::get<LaserRevolution>(came.value).samples;
      ASSERT_EQ(samples.size(), turn->samples.size());
      for (std::size_t k = 0; k < samples.size(); ++k) {
        EXPECT_EQ(samples[k].angle_rad, turn->samples[k].angle_rad);
        EXPECT_NEAR(samples[k].range_m, turn->samples[k].range_m, 5.001e-6);
        EXPECT_EQ(samples[k].status, turn->samples[k].status);
      }
    } else if (const auto* ranges = std::get_if<IrRanges>(&sent.value)) {
      EXPECT_NEAR(std::get<IrRanges>(came.value).right.value, ranges->right.value, 0.51 / 65535.0);
    } else if (const auto* inertial = std::get_if<InertialReading>(&sent.value)) {
      const auto& measured = std::get<InertialReading>(came.value);
      EXPECT_LT((measured.angular_velocity_rad_s - inertial->angular_velocity_rad_s).norm(), 1e-6);
      EXPECT_LT((measured.specific_force_m_s2 - inertial->specific_force_m_s2).norm(), 1e-6);
    } else if (const auto* inclination = std::get_if<Inclination>(&sent.value)) {
      const auto& measured = std::get<Inclination>(came.value);
      EXPECT_NEAR(measured.roll_rad, inclination->roll_rad, 0.51e-6);
      EXPECT_NEAR(measured.pitch_rad, inclination->pitch_rad, 0.51e-6);
    } else if (const auto* compass = std::get_if<CompassHeading>(&sent.value)) {
      const auto& measured = std::get<CompassHeading>(came.value);
      EXPECT_NEAR(measured.heading_rad, compass->heading_rad, 0.51e-6);
      EXPECT_EQ(measured.disturbed, compass->disturbed);
    } else if (const auto* battery = std::get_if<BatteryState>(&sent.value)) {
      const auto& measured = std::get<BatteryState>(came.value);
      EXPECT_NEAR(measured.voltage_V, battery->voltage_V, 0.51e-3);
      EXPECT_NEAR(measured.current_A, battery->current_A, 0.51e-3);
      EXPECT_NEAR(measured.charge, battery->charge, 0.51e-6);
    } else if (const auto* wheels = std::get_if<WheelEncoders>(&sent.value)) {
      EXPECT_EQ(std::get<WheelEncoders>(came.value).angle_rad, wheels->angle_rad);
    }
  }
}

TEST(Device, DrivesTheWheelsAsItIsTold) {
  const auto robot = PlayBench({false, 1s});
  std::optional<WheelEncoders> last;
  while (const auto reading = robot->Read()) {
    if (std::holds_alternative<Loss>(reading->value)) break;
    EXPECT_EQ(robot->Apply({2.0, -1.0, 0.5}), CommandOutcome::kHonoured);
    if (const auto* wheels = std::get_if<WheelEncoders>(&reading->value)) last = *wheels;
  }
  // A second at 2 and at -1 rad/s, less the first 10 ms, when nothing had been told yet.
  ASSERT_TRUE(last);
  EXPECT_NEAR(last->angle_rad[0], 2.0, 0.03);
  EXPECT_NEAR(last->angle_rad[1], -1.0, 0.02);
}

TEST(Device, HandsOverEveryImageToTheLastBitWithItsTriggersTime) {
  const std::vector<Reading> readings = ReadAll(*PlayBench({true, 1s}));
  const auto fronts = Of<FrontImage>(readings);
  const auto pairs = Of<StereoPair>(readings);
  ASSERT_EQ(fronts.size(), 4u);  // at 0.2, 0.4, 0.6 and 0.8 s; that of 1.0 s is 60 ms late
  ASSERT_EQ(pairs.size(), 4u);
  const auto same = [](const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const RunTime at = (static_cast<int>(i) + 1) * 200ms;
    EXPECT_EQ(fronts[i].first.captured_at, at);
    EXPECT_EQ(fronts[i].first.arrived_at, at + 60ms);
    EXPECT_EQ(pairs[i].first.captured_at, at);
    EXPECT_TRUE(same(fronts[i].second.image, BenchRobot::Picture(Kantaro().front_camera, at, 0)));
    EXPECT_TRUE(same(pairs[i].second.left, BenchRobot::Picture(Kantaro().stereo_left, at, 1)));
    EXPECT_TRUE(same(pairs[i].second.right, BenchRobot::Picture(Kantaro().stereo_right, at, 2)));
  }
}

TEST(Device, RepeatsToTheBitOnABadLine) {
  EmulatorOptions bad;
  bad.faults = {0.1, 0.1, 0.1};
  const auto first = ReadAll(*PlayBench({false, 2s}, bad));
  const auto second = ReadAll(*PlayBench({false, 2s}, bad));
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].captured_at, second[i].captured_at);
    EXPECT_EQ(first[i].arrived_at, second[i].arrived_at);
    EXPECT_EQ(first[i].value.index(), second[i].value.index());
  }
}

// Each frame is lost or corrupted with 20 %; a revolution needs all its seven. Nothing comes twice.
TEST(Device, TellsOfEveryReadingThatABadLineTook) {
  EmulatorOptions bad;
  bad.faults = {0.1, 0.1, 0.1};
  const std::vector<Reading> readings = ReadAll(*PlayBench({false, 10s}, bad));
  auto lost = Lost(readings, false);
  EXPECT_NEAR(lost[Sensor::kEncoders], 100, 40);  // of 500
  EXPECT_NEAR(lost[Sensor::kInertial], 200, 60);  // of 1000
  EXPECT_NEAR(lost[Sensor::kLaser], 300 * (1 - std::pow(0.8, 7)), 40);
  const auto down = Lost(readings, true);
  const auto whole = [&](Sensor sensor, std::size_t came) {
    return static_cast<double>(came) + lost[sensor] + (down.contains(sensor) ? down.at(sensor) : 0);
  };
  // What was lost at the very beginning has no reading before it, by which it could be missed.
  EXPECT_NEAR(whole(Sensor::kEncoders, Of<WheelEncoders>(readings).size()), 500, 3);
  EXPECT_NEAR(whole(Sensor::kInertial, Of<InertialReading>(readings).size()), 1000, 3);
  RunTime last{};
  for (const auto& [reading, wheels] : Of<WheelEncoders>(readings)) {
    EXPECT_GT(reading.captured_at, last);
    last = reading.captured_at;
  }
}

TEST(Device, TellsOfASensorThatStalls) {
  BenchRobot::Options bench{false, 3s};
  bench.dead = {Sensor::kInfrared};
  bench.dead_from = 1s;
  bench.dead_until = 2s;
  const std::vector<Reading> readings = ReadAll(*PlayBench(bench));
  const auto losses = Of<Loss>(readings);
  ASSERT_FALSE(losses.empty());
  EXPECT_EQ(losses[0].second.sensor, Sensor::kInfrared);
  EXPECT_FALSE(losses[0].second.line_down);
  EXPECT_EQ(losses[0].first.captured_at, 1s);  // the last came at 0.98 s, the next was due
  EXPECT_LE(losses[0].first.arrived_at, 1.11s);
  EXPECT_EQ(Lost(readings, false)[Sensor::kInfrared], 50u);
  EXPECT_EQ(Of<IrRanges>(readings).back().first.captured_at, 3s);
}

TEST(Device, GoesOnWithoutALaserWhoseCableIsPulled) {
  EmulatorOptions options;
  options.cut_laser_at = 1s;
  const std::vector<Reading> readings = ReadAll(*PlayBench({false, 2s}, options));
  const auto losses = Of<Loss>(readings);
  ASSERT_FALSE(losses.empty());
  EXPECT_EQ(losses[0].second.sensor, Sensor::kLaser);
  EXPECT_TRUE(losses[0].second.line_down);
  EXPECT_LE(Of<LaserRevolution>(readings).back().first.arrived_at, 1s);
  EXPECT_EQ(Of<WheelEncoders>(readings).back().first.captured_at, 2s);
}

TEST(Device, GoesOnWithoutACameraThatEnds) {
  EmulatorOptions options;
  options.cut_front_at = 500ms;
  const std::vector<Reading> readings = ReadAll(*PlayBench({true, 1s}, options));
  EXPECT_EQ(Of<FrontImage>(readings).size(), 2u);
  EXPECT_EQ(Of<StereoPair>(readings).size(), 4u);
  const auto losses = Of<Loss>(readings);
  ASSERT_FALSE(losses.empty());
  EXPECT_EQ(losses[0].second.sensor, Sensor::kFrontCamera);
  EXPECT_TRUE(losses[0].second.line_down);
}

TEST(Device, EndsTheRunAndRefusesCommandsWhenTheControllersCableIsPulled) {
  EmulatorOptions options;
  options.cut_controller_at = 1s;
  const auto robot = PlayBench({false, 5s}, options);
  std::vector<Reading> readings;
  while (auto reading = robot->Read()) {
    robot->Apply({1.0, 1.0, 1.0});
    readings.push_back(*std::move(reading));
  }
  EXPECT_EQ(robot->Apply({1.0, 1.0, 1.0}), CommandOutcome::kRefused);
  EXPECT_FALSE(robot->Read());
  EXPECT_LE(robot->Now(), 1.1s);
  const auto down = Lost(readings, true);
  EXPECT_TRUE(down.contains(Sensor::kEncoders) && down.contains(Sensor::kInertial) &&
              down.contains(Sensor::kInfrared));
}

TEST(Device, StandsWithin200MillisecondsAfterTheControllersCableIsPulled) {
  std::vector<std::pair<RunTime, double>> told;
  auto bench = std::make_unique<BenchRobot>(Kantaro(), BenchRobot::Options{false, 5s});
  const BenchRobot& body = *bench;
  EmulatorOptions options;
  options.cameras = false;
  options.cut_controller_at = 1s;
  PlayedRobot robot(std::move(bench), Kantaro(), options,
                    [&](RunTime now) { told.emplace_back(now, body.command().left_rad_s); });
  while (robot.Read()) robot.Apply({1.0, 1.0, 1.0});
  const Emulator& emulator = robot.Finish();
  EXPECT_EQ(emulator.lost_at(), 1s);
  EXPECT_TRUE(emulator.controller().watchdog_tripped());
  EXPECT_GE(told.back().first, 1.9s);
  for (const auto& [now, left_rad_s] : told) {
    if (now > 100ms && now < 1s) {
      EXPECT_EQ(left_rad_s, 1.0) << Seconds(now);
    } else if (now >= 1.2s) {
      EXPECT_EQ(left_rad_s, 0.0) << Seconds(now);
    }
  }
}

}  // namespace
}  // namespace kantaro::robot
