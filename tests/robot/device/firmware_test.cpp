// The controller's deadlines, on its own clock.

#include "robot/device/firmware.hpp"

#include <gmock/gmock.h>

namespace kantaro::robot::wire {
namespace {

using namespace std::chrono_literals;

class FirmwareTest : public testing::Test {
 protected:
  static FirmwareOptions Options() {
    FirmwareOptions options;
    options.robot = "bench";
    options.scales = {0.01, 336, 0.07, 0.19};
    options.speed_limit_rad_s = 5.0;
    options.periods = {{Sensor::kEncoders, 20ms}, {Sensor::kFrontCamera, 200ms}};
    return options;
  }

  /// A turn of the loop. @returns what it said.
  std::vector<Message> Turn(RunTime now, const std::vector<Message>& told = {},
                            std::span<const Reading> measured = {}) {
    Bytes in;
    for (const Message& message : told) {
      const Bytes frame = host_(static_cast<Byte>(TypeOf(message)), WireTime(0), Payload(message));
      in.insert(in.end(), frame.begin(), frame.end());
    }
    std::vector<Message> said;
    for (const Bytes& frame : firmware_.Step(now, in, measured)) {
      for (const Frame& one : decoder_.Take(frame)) said.push_back(Parse(one).value());
    }
    return said;
  }
  [[nodiscard]] double left_rad_s() const { return firmware_.drive().left_rad_s; }

  Firmware firmware_{Options()};
  Encoder host_;
  Decoder decoder_;
};

constexpr Command kOn{1'000'000, 1'000'000, 65535};

TEST_F(FirmwareTest, SaysNothingBeforeAHostOpensASession) {
  const Reading wheels{1ms, 1ms, WheelEncoders{}};
  EXPECT_THAT(Turn(1s, {}, std::span(&wheels, 1)), testing::IsEmpty());
  EXPECT_THAT(Turn(2s, {kOn}), testing::IsEmpty());
  EXPECT_EQ(left_rad_s(), 0.0);
  const auto said = Turn(3s, {Open{7}});
  ASSERT_FALSE(said.empty());
  const auto& hello = std::get<Hello>(said[0]);
  EXPECT_EQ(hello.session, 7u);
  EXPECT_EQ(hello.robot, "bench");
  EXPECT_EQ(hello.encoder_step_nrad, 10'000'000u);
  EXPECT_EQ(hello.speed_limit_urad_s, 5'000'000u);
}

TEST_F(FirmwareTest, CommandsZeroSpeedWithin200MillisecondsOfTheLastCommand) {
  Turn(0ms, {Open{1}});
  Turn(1000ms, {kOn});
  for (RunTime now = 1010ms; now < 1150ms; now += 10ms) {
    Turn(now);
    EXPECT_EQ(left_rad_s(), 1.0) << Seconds(now);
  }
  std::vector<Message> said;
  for (RunTime now = 1150ms; now < 3000ms; now += 10ms) {
    for (Message& message : Turn(now)) said.push_back(std::move(message));
    if (now < 1200ms) continue;
    EXPECT_EQ(left_rad_s(), 0.0) << Seconds(now);
  }
  EXPECT_THAT(said, testing::Contains(testing::VariantWith<Status>(
                        testing::Field(&Status::watchdog_tripped, true))));
  Turn(3000ms, {kOn});  // the host is back
  EXPECT_EQ(left_rad_s(), 1.0);
  EXPECT_FALSE(firmware_.watchdog_tripped());
}

TEST_F(FirmwareTest, IsNotKeptAwakeByNoiseNorByAnythingButCommands) {
  Turn(0ms, {Open{1}});
  Turn(10ms, {kOn});
  for (RunTime now = 20ms; now < 300ms; now += 10ms) {
    Turn(now, {Open{1}, PaceAck{3}});
    static_cast<void>(firmware_.Step(now, Bytes{0x00, 0x82, 0x13, 0x00, 0x55}));
  }
  EXPECT_EQ(left_rad_s(), 0.0);
}

TEST_F(FirmwareTest, ObeysStopForGoodUntilTheNextSession) {
  Turn(0ms, {Open{1}});
  Turn(10ms, {kOn});
  EXPECT_THAT(
      Turn(20ms, {Stop{}}),
      testing::Contains(testing::VariantWith<Ack>(Ack{Type::kStop, 0, CommandOutcome::kHonoured})));
  EXPECT_EQ(left_rad_s(), 0.0);
  EXPECT_THAT(Turn(30ms, {kOn}), testing::Contains(testing::VariantWith<Ack>(
                                     testing::Field(&Ack::outcome, CommandOutcome::kRefused))));
  EXPECT_EQ(left_rad_s(), 0.0);
  Turn(40ms, {Open{1}});  // the same session, asked again
  Turn(50ms, {kOn});
  EXPECT_EQ(left_rad_s(), 0.0);
  host_.ForgetSequences();
  Turn(60ms, {Open{2}});
  Turn(70ms, {kOn});
  EXPECT_EQ(left_rad_s(), 1.0);
}

TEST_F(FirmwareTest, CutsSpeedsToTheMotorsLimitAndSaysSo) {
  Turn(0ms, {Open{1}});
  EXPECT_THAT(Turn(10ms, {Command{9'000'000, -9'000'000, 0}}),
              testing::Contains(
                  testing::VariantWith<Ack>(Ack{Type::kCommand, 0, CommandOutcome::kLimited})));
  EXPECT_EQ(firmware_.drive().left_rad_s, 5.0);
  EXPECT_EQ(firmware_.drive().right_rad_s, -5.0);
  EXPECT_EQ(firmware_.drive().lights, 0.0);
}

TEST_F(FirmwareTest, TriggersTheCameraOnTimeAndTellsHowLongAgo) {
  Turn(0ms, {Open{1}});
  EXPECT_THAT(Turn(199ms),
              testing::Not(testing::Contains(testing::VariantWith<Trigger>(testing::_))));
  EXPECT_THAT(
      Turn(203ms),
      testing::Contains(testing::VariantWith<Trigger>(Trigger{{3000}, Sensor::kFrontCamera, 1})));
  EXPECT_THAT(
      Turn(400ms),
      testing::Contains(testing::VariantWith<Trigger>(Trigger{{0}, Sensor::kFrontCamera, 2})));
}

TEST_F(FirmwareTest, SendsItsOwnSensorsWithTheirAge) {
  Turn(0ms, {Open{1}});
  const std::vector<Reading> measured{{7ms, 9ms, WheelEncoders{{0.05, -0.05, 0.0, 0.014}}},
                                      {7ms, 9ms, LaserRevolution{}}};
  EXPECT_THAT(
      Turn(9ms, {}, measured),
      testing::ElementsAre(testing::VariantWith<Encoders>(Encoders{{2000}, {5, -5, 0, 1}})));
}

}  // namespace
}  // namespace kantaro::robot::wire
