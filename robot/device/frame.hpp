#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

/// The robot's serial protocol, byte by byte in docs/wire_protocol.md. Pure functions over bytes:
/// no line, no clock.
namespace kantaro::robot::wire {

using Byte = std::uint8_t;
using Bytes = std::vector<Byte>;
/// The sender's own clock.
using WireTime = std::chrono::duration<std::int64_t, std::micro>;

inline constexpr Byte kProtocolVersion = 1;
inline constexpr std::size_t kHeaderSize = 12;  ///< version, type, sequence, time
inline constexpr std::size_t kCrcSize = 4;
inline constexpr std::size_t kLargestPayload = 1024;
/// The two that begin a session. All sequences begin anew behind them, so neither is ever a double.
inline constexpr Byte kOpenType = 0x81, kHelloType = 0x01;

/// One message as it travels.
struct Frame {
  Byte type{};
  std::uint16_t sequence{};  ///< counts the frames of this type that this end has sent
  WireTime time{};           ///< when the sender handed it to the line, ≥ 0
  Bytes payload;
  /// Set by the decoder: frames of this type that were sent since the last one and did not come.
  std::uint16_t lost_before{};

  bool operator==(const Frame&) const = default;
};

/// CRC-32 of IEEE 802.3 (reflected, polynomial 0x04C11DB7): 0xCBF43926 over "123456789".
[[nodiscard]] std::uint32_t Crc32(std::span<const Byte> bytes);

/// Consistent overhead byte stuffing (Cheshire and Baker, 1999): the same bytes without a zero.
[[nodiscard]] Bytes Stuff(std::span<const Byte> bytes);
/// What was stuffed. Empty if no bytes stuff to this.
[[nodiscard]] Bytes Unstuff(std::span<const Byte> stuffed);

/// The bytes on the line: a zero, the stuffed header, payload and CRC, a zero. The leading zero
/// ends whatever noise came before. @throws std::invalid_argument above kLargestPayload.
[[nodiscard]] Bytes Encode(const Frame& frame);

/// Finds frames in whatever comes over a line. Noise, halves and doubles are dropped and counted;
/// the frame after them is found.
class Decoder {
 public:
  struct Counts {
    std::uint64_t frames{};      ///< handed over
    std::uint64_t corrupt{};     ///< between two zeros, and no frame
    std::uint64_t foreign{};     ///< whole, of another version
    std::uint64_t duplicated{};  ///< whole, but here before
    std::uint64_t lost{};        ///< by the gaps in the sequence numbers

    bool operator==(const Counts&) const = default;
  };

  /// Frames that these bytes complete, in order.
  [[nodiscard]] std::vector<Frame> Take(std::span<const Byte> bytes);
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  void Finish(std::vector<Frame>& frames);
  [[nodiscard]] bool InSequence(Frame& frame);

  Bytes stuffed_;
  bool too_long_{};
  std::map<Byte, std::uint16_t> last_sequence_;  ///< by type
  Counts counts_;
};

/// Numbers what one end sends, type by type.
class Encoder {
 public:
  [[nodiscard]] Bytes operator()(Byte type, WireTime time, Bytes payload);
  /// Sequence of the last frame of this type.
  [[nodiscard]] std::uint16_t last(Byte type) const;
  void ForgetSequences() { next_sequence_.clear(); }

 private:
  std::map<Byte, std::uint16_t> next_sequence_;
};

}  // namespace kantaro::robot::wire
