#include "scenarios/blinded.hpp"

#include <gtest/gtest.h>

#include <deque>

namespace kantaro::scenarios {
namespace {

/// Hands over what it was given.
class Script : public robot::Hardware {
 public:
  explicit Script(std::deque<robot::Reading> readings) : readings_(std::move(readings)) {}
  [[nodiscard]] std::optional<robot::Reading> Read() override {
    if (readings_.empty()) return {};
    robot::Reading next = std::move(readings_.front());
    readings_.pop_front();
    return next;
  }
  robot::CommandOutcome Apply(const robot::Command& command) override {
    applied = command;
    return robot::CommandOutcome::kHonoured;
  }
  void Stop() override { applied = {}; }
  [[nodiscard]] robot::RunTime Now() const override { return {}; }
  robot::Command applied;

 private:
  std::deque<robot::Reading> readings_;
};

std::deque<robot::Reading> OneOfEach() {
  return {{{}, {}, robot::LaserRevolution()}, {{}, {}, robot::WheelEncoders()},
          {{}, {}, robot::FrontImage()},      {{}, {}, robot::IrRanges()},
          {{}, {}, robot::StereoPair()},      {{}, {}, robot::InertialReading()}};
}

std::size_t CountReadings(const std::set<Sense>& dead) {
  Script script(OneOfEach());
  Blinded blinded(script, dead);
  std::size_t count = 0;
  while (blinded.Read()) ++count;
  return count;
}

TEST(Blinded, LetsEverythingThroughWhileNothingIsDead) { EXPECT_EQ(CountReadings({}), 6u); }

TEST(Blinded, TakesBothKindsOfImagesWithTheCameras) {
  EXPECT_EQ(CountReadings({Sense::kCameras}), 4u);
}

TEST(Blinded, LeavesWheelsAndInertialUnitAtLeast) {
  EXPECT_EQ(CountReadings({Sense::kCameras, Sense::kLaser, Sense::kInfrared}), 2u);
}

TEST(Blinded, HandsCommandsOn) {
  Script script({});
  Blinded(script, {Sense::kLaser}).Apply({1.0, 2.0, 0.5});
  EXPECT_EQ(script.applied.right_rad_s, 2.0);
}

}  // namespace
}  // namespace kantaro::scenarios
