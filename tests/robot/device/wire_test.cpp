#include "robot/device/wire.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace kantaro::robot::wire {
namespace {

using testing::ElementsAreArray;
using testing::Optional;
using testing::VariantWith;

Frame FrameOf(const Message& message) {
  return {static_cast<Byte>(TypeOf(message)), 0, WireTime(0), Payload(message), 0};
}

std::vector<Message> OneOfEach() {
  Hello hello{0x01020304, true, 150, 3141593, 5556000, 336, {{Sensor::kEncoders, 20000}}, "K-1"};
  Encoders encoders{{0}, {1, -1, 2147483647, -2147483647 - 1}};
  Infrared infrared{{5000}, {0, 32768, 65535}};
  Inertial inertial{{1}, {1, -2, 3}, {-4, 5, 9810000}};
  wire::Laser laser{{500}, 7, 48, 336, {{48, 15000}, {49, wire::Laser::kTooFar}}};
  return {Open{0xA1B2C3D4},
          hello,
          encoders,
          infrared,
          inertial,
          wire::Inclination{{2}, -100000, 200000},
          Compass{{3}, 3141593, true},
          Battery{{4}, 24000, -1500, 1000000},
          Trigger{{10}, Sensor::kStereoCameras, 70000},
          Status{true, false, true, 9, 300},
          Ack{Type::kCommand, 513, CommandOutcome::kLimited},
          Pace{4, 5, 6},
          PaceAck{1'000'000},
          laser,
          wire::Command{-3'000'000, 3'000'000, 65535},
          wire::Stop{}};
}

// Hand-made from docs/wire_protocol.md.
TEST(Message, StandsInThePayloadAsTheProtocolSays) {
  EXPECT_THAT(Payload(wire::Command{3'000'000, -3'000'000, 65535}),  // 0x2DC6C0 and its negative
              ElementsAreArray({0xC0, 0xC6, 0x2D, 0x00, 0x40, 0x39, 0xD2, 0xFF, 0xFF, 0xFF}));
  EXPECT_THAT(Payload(Infrared{{0x11223344}, {0, 0x8000, 0xFFFF}}),
              ElementsAreArray({0x44, 0x33, 0x22, 0x11, 0x00, 0x00, 0x00, 0x80, 0xFF, 0xFF}));
  EXPECT_THAT(Payload(wire::Laser{{1}, 2, 3, 4, {{5, wire::Laser::kTooNear}}}),
              ElementsAreArray({1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 4, 0, 1, 5, 0, 0xFE, 0xFF}));
  EXPECT_THAT(Payload(Hello{1, true, 150, 2, 3, 4, {{Sensor::kBattery, 5}}, "KA"}),
              ElementsAreArray({1, 0, 0, 0, 1, 150, 0, 2, 0, 0, 0, 3, 0,    0,
                                0, 4, 0, 0, 0, 1,   8, 5, 0, 0, 0, 2, 0x4B, 0x41}));
  EXPECT_THAT(Payload(Trigger{{0}, Sensor::kStereoCameras, 0x01020304}),
              ElementsAreArray({0, 0, 0, 0, 1, 4, 3, 2, 1}));
}

TEST(Message, OfEveryTypeComesBackAsItWas) {
  for (const Message& message : OneOfEach()) {
    EXPECT_THAT(Parse(FrameOf(message)), Optional(message)) << static_cast<int>(TypeOf(message));
  }
}

TEST(Message, IsRefusedIfItsPayloadIsTooShortOrTooLong) {
  for (const Message& message : OneOfEach()) {
    Frame frame = FrameOf(message);
    frame.payload.push_back(0);
    EXPECT_EQ(Parse(frame), std::nullopt);
    frame.payload.pop_back();
    while (!frame.payload.empty()) {
      frame.payload.pop_back();
      EXPECT_EQ(Parse(frame), std::nullopt) << static_cast<int>(frame.type);
    }
  }
}

TEST(Message, IsRefusedIfAFieldHoldsWhatItCannotMean) {
  Frame trigger = FrameOf(Trigger{{0}, Sensor::kFrontCamera, 1});
  trigger.payload[4] = static_cast<Byte>(Sensor::kLaser);  // no camera
  EXPECT_EQ(Parse(trigger), std::nullopt);
  Frame ack = FrameOf(Ack{Type::kStop, 1, CommandOutcome::kRefused});
  ack.payload[3] = 3;
  EXPECT_EQ(Parse(ack), std::nullopt);
  Frame compass = FrameOf(Compass{{0}, 1, true});
  compass.payload[8] = 2;
  EXPECT_EQ(Parse(compass), std::nullopt);
  EXPECT_EQ(Parse({0x7F, 0, WireTime(0), {}, 0}), std::nullopt);
}

TEST(FixedPoint, RoundsToTheNearestUnitAndHoldsToTheRange) {
  EXPECT_EQ(Fixed<std::int32_t>(1.2345678, 1e6), 1234568);
  EXPECT_EQ(Fixed<std::int32_t>(-1e-6, 1e6), -1);
  EXPECT_EQ(Fixed<std::int32_t>(1e9, 1e6), 2147483647);
  EXPECT_EQ(Fixed<std::int32_t>(-1e9, 1e6), -2147483647 - 1);
  EXPECT_EQ(Fixed<std::uint16_t>(-0.5, 65535.0), 0);
  EXPECT_EQ(Fixed<std::uint16_t>(2.0, 65535.0), 65535);
  EXPECT_EQ(Fixed<std::uint16_t>(std::nan(""), 65535.0), 0);
}

// 10,080 samples a second, 336 to a turn, in frames of 48, ten bits to a byte.
TEST(LaserLine, CarriesMoreThanTenThousandSamplesASecondAtTwoMegabits) {
  wire::Laser laser{{5000}, 1000000, 288, 336, {}};
  for (std::uint16_t i = 0; i < 48; ++i) laser.samples.push_back({i, 15000});
  const std::size_t bytes =
      Encode({static_cast<Byte>(Type::kLaser), 65535, WireTime(1LL << 62), Payload(laser), 0})
          .size();
  // 2 zeros, 1 or 2 code bytes, 12 of header, 13 before the samples, 48 x 4, 4 of CRC.
  EXPECT_EQ(bytes, 2u + 1u + 12u + 13u + 192u + 4u);
  const double bits_per_s = static_cast<double>(bytes) * 10.0 * 10080.0 / 48.0;
  EXPECT_LT(bits_per_s, 0.25 * 2e6);
}

}  // namespace
}  // namespace kantaro::robot::wire
