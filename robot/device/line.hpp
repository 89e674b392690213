#pragma once

#include <filesystem>
#include <span>

#include "robot/device/frame.hpp"

namespace kantaro::robot {

/// An open serial line, or the robot's end of one that is played. Never blocks.
class ByteLine {
 public:
  /// Owns the descriptor, which must not block.
  explicit ByteLine(int descriptor) : descriptor_(descriptor) {}
  ByteLine(ByteLine&& other) noexcept;
  ByteLine& operator=(ByteLine&& other) noexcept;
  ~ByteLine();

  /// What has come since. Absent bytes and a line that is gone both read as nothing: see gone().
  [[nodiscard]] wire::Bytes Read();
  /// Sends what the line takes now and keeps the rest for the next call; of more than a second's
  /// worth the oldest is dropped, as a line that nobody reads would.
  void Write(std::span<const wire::Byte> bytes);
  [[nodiscard]] bool pending() const { return !unsent_.empty(); }
  /// The other end has hung up, or the cable is out.
  [[nodiscard]] bool gone() const { return gone_; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  void Close();

 private:
  int descriptor_{-1};
  bool gone_{};
  wire::Bytes unsent_;
};

/// Opens a serial device: raw, 8 data bits, no parity, one stop bit, for this process alone.
/// @throws std::system_error if that cannot be. @throws std::invalid_argument for a speed that
/// serial lines do not have (IsSerialSpeed).
[[nodiscard]] ByteLine OpenSerialLine(const std::filesystem::path& device, int bits_per_s);
[[nodiscard]] bool IsSerialSpeed(int bits_per_s);

/// A pseudo-terminal, raw, and the path under which its other end is opened.
struct PlayedLine {
  ByteLine line;
  std::filesystem::path device;
};
/// @throws std::system_error
[[nodiscard]] PlayedLine OpenPlayedLine();

}  // namespace kantaro::robot
