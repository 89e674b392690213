#include "robot/device/frame.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace kantaro::robot::wire {
namespace {

constexpr std::size_t kLargestBody = kHeaderSize + kLargestPayload + kCrcSize;
/// One code byte for each 254 bytes that hold no zero, and one.
constexpr std::size_t kLargestStuffed = kLargestBody + kLargestBody / 254 + 1;
constexpr std::size_t kLongestRun = 254;
/// A frame so far behind the newest is not a late double: the other end has begun anew.
constexpr int kOldestDouble = 64;

constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xEDB88320u : 0u);
    table[i] = value;
  }
  return table;
}();

template <typename Integer>
void AppendLittleEndian(Bytes& bytes, Integer value) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i) bytes.push_back(Byte(value >> (8 * i)));
}

template <typename Integer>
Integer LittleEndian(std::span<const Byte> bytes) {
  Integer value = 0;
  for (std::size_t i = sizeof(Integer); i-- > 0;) value = Integer(value << 8) | Integer(bytes[i]);
  return value;
}

}  // namespace

std::uint32_t Crc32(std::span<const Byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const Byte byte : bytes) crc = kCrcTable[(crc ^ byte) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

Bytes Stuff(std::span<const Byte> bytes) {
  Bytes stuffed;
  stuffed.reserve(bytes.size() + bytes.size() / kLongestRun + 1);
  for (std::size_t at = 0;;) {
    const auto rest = bytes.subspan(at);
    const std::size_t most = std::min(rest.size(), kLongestRun);
    const auto zero = std::find(rest.begin(), rest.begin() + static_cast<long>(most), Byte{0});
    const auto run = static_cast<std::size_t>(zero - rest.begin());
    stuffed.push_back(Byte(run + 1));
    stuffed.insert(stuffed.end(), rest.begin(), zero);
    at += run;
    if (at == bytes.size()) return stuffed;
    if (run < kLongestRun) ++at;  // the zero itself
  }
}

Bytes Unstuff(std::span<const Byte> stuffed) {
  Bytes bytes;
  bytes.reserve(stuffed.size());
  for (std::size_t at = 0; at < stuffed.size();) {
    const std::size_t run = stuffed[at] - std::size_t{1};
    if (stuffed[at] == 0 || run > stuffed.size() - at - 1) return {};
    const auto first = stuffed.begin() + static_cast<long>(at) + 1;
    bytes.insert(bytes.end(), first, first + static_cast<long>(run));
    at += run + 1;
    if (run < kLongestRun && at < stuffed.size()) bytes.push_back(0);
  }
  return bytes;
}

Bytes Encode(const Frame& frame) {
  if (frame.payload.size() > kLargestPayload) {
    throw std::invalid_argument("the payload is larger than a frame");
  }
  Bytes body{kProtocolVersion, frame.type};
  AppendLittleEndian(body, frame.sequence);
  AppendLittleEndian(body, static_cast<std::uint64_t>(frame.time.count()));
  body.insert(body.end(), frame.payload.begin(), frame.payload.end());
  AppendLittleEndian(body, Crc32(body));
  Bytes line{0};
  const Bytes stuffed = Stuff(body);
  line.insert(line.end(), stuffed.begin(), stuffed.end());
  line.push_back(0);
  return line;
}

std::vector<Frame> Decoder::Take(std::span<const Byte> bytes) {
  std::vector<Frame> frames;
  for (const Byte byte : bytes) {
    if (byte == 0) {
      Finish(frames);
      stuffed_.clear();
      too_long_ = false;
    } else if (stuffed_.size() < kLargestStuffed) {
      stuffed_.push_back(byte);
    } else {
      too_long_ = true;
    }
  }
  return frames;
}

void Decoder::Finish(std::vector<Frame>& frames) {
  if (stuffed_.empty()) return;  // two zeros in a row
  const Bytes body = too_long_ ? Bytes{} : Unstuff(stuffed_);
  const std::span<const Byte> all(body);
  if (body.size() < kHeaderSize + kCrcSize || body.size() > kLargestBody ||
      LittleEndian<std::uint32_t>(all.last(kCrcSize)) != Crc32(all.first(body.size() - kCrcSize))) {
    ++counts_.corrupt;
    return;
  }
  if (body[0] != kProtocolVersion) {
    ++counts_.foreign;
    return;
  }
  const auto time = LittleEndian<std::uint64_t>(all.subspan(4));
  if (time >> 63 != 0) {  // no clock has run for 292,000 years
    ++counts_.corrupt;
    return;
  }
  Frame frame{body[1],
              LittleEndian<std::uint16_t>(all.subspan(2)),
              WireTime(static_cast<std::int64_t>(time)),
              {body.begin() + kHeaderSize, body.end() - kCrcSize},
              0};
  if (!InSequence(frame)) {
    ++counts_.duplicated;
    return;
  }
  ++counts_.frames;
  frames.push_back(std::move(frame));
}

bool Decoder::InSequence(Frame& frame) {
  if (frame.type == kOpenType || frame.type == kHelloType) {
    last_sequence_.clear();
    return true;
  }
  const auto [known, first] = last_sequence_.try_emplace(frame.type, frame.sequence);
  if (first) return true;
  const auto step = static_cast<std::int16_t>(frame.sequence - known->second);
  if (step <= 0 && step > -kOldestDouble) return false;
  known->second = frame.sequence;
  if (step > 0) frame.lost_before = static_cast<std::uint16_t>(step - 1);
  counts_.lost += frame.lost_before;
  return true;
}

Bytes Encoder::operator()(Byte type, WireTime time, Bytes payload) {
  return Encode({type, next_sequence_[type]++, time, std::move(payload), 0});
}

std::uint16_t Encoder::last(Byte type) const {
  const auto next = next_sequence_.find(type);
  return next == next_sequence_.end() ? 0 : static_cast<std::uint16_t>(next->second - 1);
}

}  // namespace kantaro::robot::wire
