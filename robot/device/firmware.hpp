#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "robot/description.hpp"
#include "robot/device/conversion.hpp"

namespace kantaro::robot::wire {

/// What one of the robot's two processors is: the controller (motors, cameras' triggers and all
/// sensors but one), or the laser scanner.
struct FirmwareOptions {
  std::string robot;
  Scales scales;
  double speed_limit_rad_s{};  ///< of the wheels; 0: this one drives none
  /// No command for so long, and the wheels are told to stand still. Below the 200 ms that are
  /// promised, for the loop that looks at it turns every 10 ms at worst.
  RunTime watchdog{std::chrono::milliseconds(150)};
  std::map<Sensor, RunTime> periods;  ///< what it sends, and triggers, how often
  bool lockstep{};
};

/// The controller and the scanner of this robot, as the emulator plays them.
/// @param cameras  whether it has any.
[[nodiscard]] FirmwareOptions ControllerOf(const Description& robot, bool cameras);
[[nodiscard]] FirmwareOptions ScannerOf(const Description& robot);

/// The firmware's main loop as a state machine: bytes and measurements in, bytes and what the
/// motors are told out. It reads no clock and touches no line, so every deadline can be tested.
///
/// It says nothing until a host opens a session. Wheels stand still until the first command, after
/// Stop until the next session, and from the watchdog's deadline until the next command.
class Firmware {
 public:
  explicit Firmware(FirmwareOptions options);

  /// One turn of the loop.
  /// @param now       its own clock; never decreases.
  /// @param in        what came over the line since the last turn.
  /// @param measured  what its sensors measured since; those of other processors are passed over.
  /// @returns frames for the line, each encoded.
  [[nodiscard]] std::vector<Bytes> Step(RunTime now, std::span<const Byte> in,
                                        std::span<const Reading> measured = {});
  /// Lockstep: says that all up to the last turn has been sent.
  [[nodiscard]] Bytes EncodePace(const Pace& pace);

  [[nodiscard]] bool open() const { return open_; }
  /// What motors and lamps are told now.
  [[nodiscard]] const robot::Command& drive() const { return drive_; }
  [[nodiscard]] bool stopped() const { return status_.stopped; }
  [[nodiscard]] bool watchdog_tripped() const { return status_.watchdog_tripped; }
  /// Lockstep: the newest step that the host is done with; 0 before the first.
  [[nodiscard]] std::uint32_t acknowledged() const { return acknowledged_; }
  [[nodiscard]] const Decoder::Counts& received() const { return decoder_.counts(); }

 private:
  void Handle(const Frame& frame);
  void Begin(const Open& open);
  void Obey(const wire::Command& command, std::uint16_t sequence);
  void StopForGood(std::uint16_t sequence);
  void WatchTheHost();
  void TriggerCameras();
  void Report(const Reading& reading);
  void ReportStatus();
  void Send(const Message& message);
  [[nodiscard]] Hello MakeHello() const;

  FirmwareOptions options_;
  Decoder decoder_;
  Encoder encoder_;
  std::vector<Bytes> out_;
  RunTime now_{};
  bool open_{};
  std::uint32_t session_{};
  robot::Command drive_{0.0, 0.0, 1.0};
  RunTime commanded_at_{};
  bool driven_{};  ///< a command has come in this session
  Status status_, reported_;
  RunTime reported_at_{};
  std::uint32_t revolution_{};
  std::map<Sensor, std::int64_t> triggers_;  ///< given so far
  std::uint32_t acknowledged_{};
};

}  // namespace kantaro::robot::wire
