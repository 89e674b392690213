// Whatever comes over a line: no frame is read beyond its bytes, a message that is understood is
// sent again as the same bytes, and the next whole frame is found.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "robot/device/wire.hpp"

namespace wire = kantaro::robot::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);

  wire::Decoder whole, pieces;
  const std::vector<wire::Frame> frames = whole.Take(bytes);
  std::vector<wire::Frame> same;
  for (std::size_t at = 0; at < size; at += 3) {
    for (wire::Frame& frame : pieces.Take(bytes.subspan(at, std::min<std::size_t>(3, size - at)))) {
      same.push_back(std::move(frame));
    }
  }
  if (frames != same) std::abort();

  wire::Decoder after;
  static_cast<void>(after.Take(bytes));
  const wire::Frame next{wire::kOpenType, 0, wire::WireTime(1), {}, 0};  // never taken for a double
  const std::vector<wire::Frame> found = after.Take(wire::Encode(next));
  if (found.empty() || found.back() != next) std::abort();

  // The first byte as a type, the rest as its payload: past the CRC, which a fuzzer does not guess.
  if (size > 0 && size <= wire::kLargestPayload) {
    const wire::Frame frame{data[0], 0, wire::WireTime(0), {data + 1, data + size}, 0};
    const auto message = wire::Parse(frame);
    if (message && wire::Payload(*message) != frame.payload) std::abort();
  }
  return 0;
}
