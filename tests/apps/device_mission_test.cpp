// Missions through the device back end and the wire, with the emulator and the twin behind it on
// another thread and the judge's truth beside it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <thread>

#include "robot/device/device.hpp"
#include "robot/device/emulator.hpp"
#include "scenarios/runner.hpp"

namespace kantaro::scenarios {
namespace {

using namespace std::chrono_literals;
using robot::RunTime;

/// The twin, for the emulator's thread to drive and the judge's to look at.
class SharedTwin : public robot::Hardware {
 public:
  explicit SharedTwin(Body body) : body_(std::move(body)) {}
  [[nodiscard]] std::optional<robot::Reading> Read() override {
    const std::scoped_lock lock(mutex_);
    auto reading = body_.hardware->Read();
    if (!reading) return reading;
    if (const auto* wheels = std::get_if<robot::WheelEncoders>(&reading->value)) {
      angles_.emplace_back(reading->captured_at, wheels->angle_rad);
    }
    return reading;
  }
  robot::CommandOutcome Apply(const robot::Command& command) override {
    const std::scoped_lock lock(mutex_);
    return body_.hardware->Apply(command);
  }
  void Stop() override {
    const std::scoped_lock lock(mutex_);
    body_.hardware->Stop();
  }
  [[nodiscard]] RunTime Now() const override { return body_.hardware->Now(); }
  [[nodiscard]] sim::GroundTruth Truth() {
    const std::scoped_lock lock(mutex_);
    return body_.truth();
  }

  /// Fastest that any wheel turned in a time [rad/s].
  [[nodiscard]] double Fastest(RunTime from, RunTime to) const {
    double fastest = 0.0;
    for (std::size_t i = 1; i < angles_.size(); ++i) {
      if (angles_[i - 1].first < from || angles_[i].first > to) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        fastest = std::max(fastest, std::abs(angles_[i].second[k] - angles_[i - 1].second[k]) /
                                        robot::Seconds(angles_[i].first - angles_[i - 1].first));
      }
    }
    return fastest;
  }
  [[nodiscard]] RunTime last() const { return angles_.back().first; }

 private:
  Body body_;
  std::mutex mutex_;
  std::vector<std::pair<RunTime, std::array<double, 4>>> angles_;
};

/// One mission through the wire.
class DeviceMission : public testing::Test {
 protected:
  ~DeviceMission() override { std::filesystem::remove_all(options_.folder); }

  MissionRun Run(const std::filesystem::path& scenario, std::uint64_t seed) {
    RunOptions options;
    options.make_body = [&](const Scenario& around, const Conditions& conditions,
                            const robot::Description& description) {
      emulator_.reset();  // it takes its links with it
      twin_ = std::make_unique<SharedTwin>(MakeBody({}, around, conditions, description, 2));
      emulator_ = std::make_unique<robot::Emulator>(*twin_, description, options_);
      thread_ = std::jthread([this](const std::stop_token& stop) {
        emulator_->Serve({}, [&] { return stop.stop_requested(); });
      });
      return Body{robot::OpenDevice(emulator_->config(), description),
                  [this] { return twin_->Truth(); }};
    };
    MissionRun run = RunMission(ReadScenario(scenario), seed, options);
    thread_.join();
    return run;
  }
  MissionRun RunShort() {
    return Run(std::filesystem::path(KANTARO_SOURCE_DIR) / "tests/apps/short_mission.yaml", 1);
  }
  static std::string Failures(const MissionRun& run) {
    std::string failures = run.trace.ending;
    for (const Check& check : run.result.verdict.checks) {
      if (!check.passed) failures += fmt::format("\n{}: {}", check.name, check.text);
    }
    return failures;
  }

  robot::EmulatorOptions options_ = [] {
    static std::atomic<int> count{};
    robot::EmulatorOptions options;
    options.folder = std::filesystem::temp_directory_path() /
                     fmt::format("kantaro_mission_{}_{}", getpid(), ++count);
    return options;
  }();
  std::unique_ptr<SharedTwin> twin_;
  std::unique_ptr<robot::Emulator> emulator_;
  std::jthread thread_;
};

#ifdef KANTARO_LONG_MISSIONS

TEST_F(DeviceMission, DrivesRoute1) {
  const MissionRun run =
      Run(std::filesystem::path(KANTARO_SOURCE_DIR) / "scenarios/route_1.yaml", 1);
  EXPECT_TRUE(run.result.verdict.passed) << Failures(run);
  EXPECT_TRUE(run.trace.finished);
}

#else

TEST_F(DeviceMission, PassesAndRepeatsToTheBit) {
  const MissionRun first = RunShort();
  EXPECT_TRUE(first.result.verdict.passed) << Failures(first);
  EXPECT_TRUE(first.trace.finished);
  const MissionRun second = RunShort();
  EXPECT_EQ(first.trace.sha256, second.trace.sha256);
}

TEST_F(DeviceMission, PassesOnALineThatLosesDoublesAndCorruptsFrames) {
  options_.faults = {0.03, 0.03, 0.03};
  const MissionRun run = RunShort();
  EXPECT_TRUE(run.result.verdict.passed) << Failures(run);
  EXPECT_GT(run.trace.lost.at("encoders"), 0u);
}

// The laser lies at the rear and finds the manhole: without it the mission goes on as far as it
// can.
TEST_F(DeviceMission, GoesOnWhenTheLasersCableIsPulled) {
  options_.cut_laser_at = 5s;
  const MissionRun run = RunShort();
  EXPECT_GT(run.trace.end_s, 6.0) << run.trace.ending;
  // At 5 s the next revolution was not due yet: the line is down, and nothing is lost so far.
  EXPECT_THAT(run.trace.events,
              testing::Contains(testing::Field(
                  &Event::text, testing::StartsWith("laser: nothing comes from there any more"))));
  EXPECT_EQ(run.trace.refused, 0u);
}

TEST_F(DeviceMission, EndsAndSaysWhyWhenTheControllersCableIsPulledAndTheWheelsStandWithin400ms) {
  options_.cut_controller_at = 5s;
  const MissionRun run = RunShort();
  EXPECT_FALSE(run.trace.finished);
  EXPECT_FALSE(run.result.verdict.passed);
  EXPECT_NEAR(run.trace.end_s, 5.0, 0.2);
  EXPECT_NE(run.trace.ending, "");
  ASSERT_EQ(emulator_->lost_at(), 5s);
  EXPECT_GE(twin_->last(), 5900ms);
  EXPECT_GT(twin_->Fastest(4500ms, 5000ms), 1.0);   // it did drive
  EXPECT_LT(twin_->Fastest(5400ms, 6000ms), 0.16);  // one count of the encoder in 20 ms
}

#endif

}  // namespace
}  // namespace kantaro::scenarios
