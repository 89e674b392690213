#include "robot/device/frame.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <string_view>

#include "base/random.hpp"

namespace kantaro::robot::wire {
namespace {

using testing::ElementsAreArray;
using testing::IsEmpty;

Bytes Append(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// The worked example of docs/wire_protocol.md: Stop (0x83), the first, sent 1 s = 0x0F4240 µs
/// after power-on. Its CRC is zlib's.
const Frame kStop{0x83, 0, WireTime(1'000'000), {}, 0};
const Bytes kStopOnTheLine{0x00, 0x03, 0x01, 0x83, 0x01, 0x04, 0x40, 0x42, 0x0F, 0x01,
                           0x01, 0x01, 0x01, 0x05, 0xF6, 0xCD, 0x2C, 0x05, 0x00};

TEST(Crc32, HasTheCheckValueOfItsCatalogue) {
  constexpr std::string_view kDigits = "123456789";
  EXPECT_EQ(Crc32(Bytes(kDigits.begin(), kDigits.end())), 0xCBF43926u);
  EXPECT_EQ(Crc32({}), 0u);
}

// Each run of bytes without a zero stands behind its length plus one.
TEST(Stuffing, ReplacesEachZeroByTheWayToTheNext) {
  EXPECT_THAT(Stuff(Bytes{}), ElementsAreArray({0x01}));
  EXPECT_THAT(Stuff(Bytes{0x00}), ElementsAreArray({0x01, 0x01}));
  EXPECT_THAT(Stuff(Bytes{0x11, 0x22, 0x00, 0x33}),
              ElementsAreArray({0x03, 0x11, 0x22, 0x02, 0x33}));
  EXPECT_THAT(Stuff(Bytes{0x11, 0x00, 0x00}), ElementsAreArray({0x02, 0x11, 0x01, 0x01}));
}

TEST(Stuffing, SplitsRunsOf254BytesWithoutAZeroBetween) {
  const Bytes run(254, 0xAA);
  EXPECT_THAT(Stuff(run), ElementsAreArray(Append({0xFF}, run))) << "255 bytes, no code behind";
}

TEST(Stuffing, IsUndoneWhateverTheBytes) {
  RandomStream random(1, "stuffing");
  for (std::size_t size = 0; size < 1100; ++size) {
    Bytes bytes(size);
    const std::uint64_t span = size % 3 == 0 ? 256 : 2;  // many zeros, or few
    for (Byte& byte : bytes) byte = size % 5 == 0 ? 1 : Byte(random.Index(span));
    const Bytes stuffed = Stuff(bytes);
    EXPECT_THAT(stuffed, testing::Not(testing::Contains(0)));
    EXPECT_LE(stuffed.size(), size + size / 254 + 1);
    EXPECT_EQ(Unstuff(stuffed), bytes) << size;
  }
}

TEST(Stuffing, IsRefusedWhereARunLeavesTheBytes) {
  EXPECT_THAT(Unstuff(Bytes{0x03, 0x11}), IsEmpty());
  EXPECT_THAT(Unstuff(Bytes{0x01, 0x00, 0x01}), IsEmpty());
}

TEST(Frame, StandsOnTheLineAsTheProtocolSays) { EXPECT_EQ(Encode(kStop), kStopOnTheLine); }

TEST(Frame, IsNoLargerThanTheProtocolAllows) {
  EXPECT_NO_THROW(static_cast<void>(Encode({1, 0, WireTime(0), Bytes(kLargestPayload), 0})));
  EXPECT_THROW(static_cast<void>(Encode({1, 0, WireTime(0), Bytes(kLargestPayload + 1), 0})),
               std::invalid_argument);
}

TEST(Decoder, FindsAFrameHoweverItsBytesAreSplit) {
  for (std::size_t cut = 0; cut <= kStopOnTheLine.size(); ++cut) {
    Decoder decoder;
    const std::span<const Byte> line(kStopOnTheLine);
    std::vector<Frame> frames = decoder.Take(line.first(cut));
    for (Frame& frame : decoder.Take(line.subspan(cut))) frames.push_back(std::move(frame));
    EXPECT_THAT(frames, ElementsAreArray({kStop})) << cut;
  }
}

TEST(Decoder, RefusesAFrameWithAnySingleBitWrongAndFindsTheNext) {
  for (std::size_t bit = 0; bit < 8 * kStopOnTheLine.size(); ++bit) {
    Bytes line = kStopOnTheLine;
    line[bit / 8] ^= Byte(1 << bit % 8);
    Decoder decoder;
    // The outer zeros may be hurt: then this frame is whole behind the noise or before it.
    for (const Frame& frame : decoder.Take(line)) EXPECT_EQ(frame, kStop);
    Frame next = kStop;
    next.sequence = 1;
    EXPECT_THAT(decoder.Take(Encode(next)),
                testing::Contains(testing::Field(&Frame::sequence, testing::Eq(1))))
        << bit;
  }
}

TEST(Decoder, CountsDoublesAndGapsTypeByType) {
  Decoder decoder;
  const auto send = [&](Byte type, std::uint16_t sequence) {
    return decoder.Take(Encode({type, sequence, WireTime(0), {}, 0}));
  };
  EXPECT_EQ(send(3, 65534).size(), 1u);
  EXPECT_EQ(send(3, 65534).size(), 0u);                 // the same again
  EXPECT_EQ(send(2, 10).size(), 1u);                    // another type has a count of its own
  const std::vector<Frame> after_the_gap = send(3, 1);  // 65535 and 0 are missing
  ASSERT_EQ(after_the_gap.size(), 1u);
  EXPECT_EQ(after_the_gap[0].lost_before, 2);
  EXPECT_EQ(decoder.counts(), (Decoder::Counts{3, 0, 0, 1, 2}));
}

TEST(Decoder, TellsAnotherVersionFromNoise) {
  Bytes body{2, 0x83, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const std::uint32_t crc = Crc32(body);
  for (int i = 0; i < 4; ++i) body.push_back(Byte(crc >> (8 * i)));
  Decoder decoder;
  EXPECT_THAT(decoder.Take(Append(Append({0}, Stuff(body)), {0})), IsEmpty());
  EXPECT_EQ(decoder.counts(), (Decoder::Counts{0, 0, 1, 0, 0}));
}

TEST(Decoder, HoldsNoMoreThanAFrameOfEndlessNoise) {
  Decoder decoder;
  for (int i = 0; i < 1000; ++i) EXPECT_THAT(decoder.Take(Bytes(1000, 0x55)), IsEmpty());
  EXPECT_THAT(decoder.Take(kStopOnTheLine), ElementsAreArray({kStop}));
  EXPECT_EQ(decoder.counts().corrupt, 1u);
}

/// What a line does to the bytes of one frame.
Bytes Hurt(Bytes line, RandomStream& random) {
  for (std::uint64_t wounds = 1 + random.Index(4); wounds > 0 && !line.empty(); --wounds) {
    const auto at = line.begin() + static_cast<long>(random.Index(line.size()));
    switch (random.Index(4)) {
      case 0:
        *at ^= Byte(1 << random.Index(8));
        break;
      case 1:
        line.erase(at, at + static_cast<long>(random.Index(line.end() - at) + 1));
        break;
      case 2: {
        Bytes noise(random.Index(20));
        for (Byte& byte : noise) byte = Byte(random.Index(256));
        line.insert(at, noise.begin(), noise.end());
        break;
      }
      default:
        *at = Byte(random.Index(256));
    }
  }
  return line;
}

// A wrong frame passes once in 2^32 at most: never here. A frame that was not hurt always passes.
TEST(Decoder, TakesEveryFrameThatCameWholeAndNoOther) {
  RandomStream random(7, "line noise");
  Decoder decoder;
  Encoder encoder;
  std::vector<Frame> sent, whole, taken;
  Bytes line;
  for (int i = 0; i < 20000; ++i) {
    Bytes payload(random.Index(i % 50 == 0 ? 1000 : 40));
    for (Byte& byte : payload) byte = Byte(random.Index(random.Index(2) == 0 ? 256 : 2));
    const auto type = Byte(2 + random.Index(3));
    const Bytes bytes = encoder(type, WireTime(i), payload);
    sent.push_back({type, encoder.last(type), WireTime(i), payload, 0});
    const bool hurt = random.Index(3) == 0;
    if (!hurt) whole.push_back(sent.back());
    line = Append(std::move(line), hurt ? Hurt(bytes, random) : bytes);
    const auto arrives = static_cast<std::size_t>(random.Index(line.size() + 1));
    for (Frame& frame : decoder.Take(std::span(line).first(arrives))) taken.push_back(frame);
    line.erase(line.begin(), line.begin() + static_cast<long>(arrives));
  }
  for (Frame& frame : decoder.Take(line)) taken.push_back(frame);

  std::uint64_t lost = 0;
  for (Frame& frame : taken) lost += std::exchange(frame.lost_before, 0);
  auto next_sent = sent.begin();
  auto next_whole = whole.begin();
  for (const Frame& frame : taken) {  // `taken` lies in `sent`, and `whole` in `taken`
    next_sent = std::find(next_sent, sent.end(), frame);
    ASSERT_NE(next_sent, sent.end()) << "a frame that nobody sent";
    ++next_sent;
    if (next_whole != whole.end() && *next_whole == frame) ++next_whole;
  }
  EXPECT_EQ(next_whole, whole.end()) << "a whole frame was not found";
  EXPECT_GT(decoder.counts().corrupt, 1000u);
  // All that did not come is counted, but for what was lost before the first or after the last.
  EXPECT_NEAR(static_cast<double>(lost), static_cast<double>(sent.size() - taken.size()), 20.0);
}

}  // namespace
}  // namespace kantaro::robot::wire
