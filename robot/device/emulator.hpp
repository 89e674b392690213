#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/random.hpp"
#include "robot/device/firmware.hpp"
#include "robot/device/host.hpp"
#include "robot/device/image_pipe.hpp"
#include "robot/device/line.hpp"

namespace kantaro::robot {

/// What a bad line does to frames, each as a share of them.
struct LineFaults {
  double lost{}, doubled{}, corrupted{};
};

/// Does it, in both directions, and puts noise between frames that it corrupts. What opens a
/// session and keeps the pace passes unhurt, so that a run in lockstep repeats.
class BadLine {
 public:
  BadLine(LineFaults faults, RandomStream random) : faults_(faults), random_(std::move(random)) {}
  [[nodiscard]] wire::Bytes Pass(std::span<const wire::Byte> bytes);

 private:
  void PassFrame(wire::Bytes& out);

  LineFaults faults_;
  RandomStream random_;
  wire::Bytes frame_;
};

struct EmulatorOptions {
  std::filesystem::path folder;      ///< of the lines, the cameras' pipes and device.yaml
  std::filesystem::path controller;  ///< where the controller's line is linked
  std::filesystem::path laser;       ///< where the laser's is
  bool cameras{true};
  bool lockstep{true};  ///< time goes on as the host says; else with the clock on the wall
  LineFaults faults;
  std::uint64_t seed{1};  ///< of the faults
  /// Cables that are pulled, and when.
  std::optional<RunTime> cut_controller_at, cut_laser_at, cut_front_at;
};

/// Plays the two processors and the cameras of a robot, whatever moves it: usually the twin.
///
/// Simulated time stands still until a host opens a session. One session; then the emulator is
/// spent.
class Emulator {
 public:
  /// Makes the lines, the pipes and `device.yaml`. @param robot  must outlive this.
  /// @throws std::system_error
  Emulator(Hardware& robot, const Description& description, EmulatorOptions options);
  ~Emulator();
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  /// Until the robot's run is over, or for a second after the last line is down.
  /// @param watch  called after each instant. May be empty.
  /// @returns false if `give_up` returned true before a host came.
  bool Serve(const std::function<void(RunTime now)>& watch,
             const std::function<bool()>& give_up = {});

  [[nodiscard]] std::filesystem::path config() const { return options_.folder / "device.yaml"; }
  /// When the controller's line went down, by whichever end.
  [[nodiscard]] std::optional<RunTime> lost_at() const { return lost_at_; }
  [[nodiscard]] const wire::Firmware& controller() const { return *ends_[0].firmware; }

 private:
  struct End {
    std::optional<wire::Firmware> firmware;
    std::optional<ByteLine> line;
    std::optional<BadLine> to_host, from_host;
    std::filesystem::path link;

    [[nodiscard]] bool up() const { return line && !line->gone(); }
  };
  [[nodiscard]] bool WaitForHost(const std::function<bool()>& give_up);
  void MakeEnd(Line line, wire::FirmwareOptions options, const std::filesystem::path& link);
  void MakePipes(const Description& description);
  void WriteConfig() const;
  void Turn(End& end, RunTime now, std::span<const Reading> measured);
  void Show(const Reading& reading);
  void Drive();
  void Cut(RunTime now);
  void KeepPace(RunTime now);
  void KeepLockstep(RunTime now);
  void KeepRealTime(RunTime now);
  void Pump(RunTime now, int milliseconds);

  Hardware& robot_;
  EmulatorOptions options_;
  std::array<End, kLines> ends_;
  std::array<std::unique_ptr<ImagePipe>, kCameraPorts> pipes_;
  wire::Pace served_;
  std::optional<Command> driven_;
  bool stopped_{};
  std::optional<RunTime> lost_at_;
  std::optional<std::chrono::steady_clock::time_point> began_;
};

}  // namespace kantaro::robot
