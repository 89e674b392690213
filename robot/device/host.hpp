#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "robot/description.hpp"
#include "robot/device/clock_map.hpp"
#include "robot/device/continuity.hpp"
#include "robot/device/conversion.hpp"
#include "robot/device/image_matcher.hpp"
#include "robot/hardware.hpp"

namespace kantaro::robot {

enum class Line : std::uint8_t { kController, kLaser };
enum class CameraPort : std::uint8_t { kFront, kStereoLeft, kStereoRight };
inline constexpr std::size_t kLines = 2, kCameraPorts = 3;

/// What an image's stamp counts from.
enum class StampClock { kController, kHost, kNone };

struct HostOptions {
  bool laser{true};          ///< its line is there
  bool front{}, stereo{};    ///< cameras that are there
  std::uint32_t session{1};  ///< another number for each run
  /// Silence of a sensor that is no loss yet. Absent: five periods, at least 0.1 s.
  std::map<Sensor, RunTime> patience;
  /// Silence of a line that means it is down. In lockstep an emulator may think for long.
  RunTime line_patience{std::chrono::milliseconds(500)};
  RunTime lockstep_patience{std::chrono::seconds(60)};
};

/// The host's side of the protocol as a state machine: bytes and images in; readings, losses and
/// bytes out. It reads no clock and touches no line: `now` is the host's own clock, never
/// decreasing.
class Host {
 public:
  Host(const Description& robot, HostOptions options, RunTime now);

  /// Asks both processors to begin. Repeat until opened().
  void SendOpen(RunTime now);
  [[nodiscard]] bool opened() const;
  /// Which line has not answered yet. @pre !opened()
  [[nodiscard]] Line silent() const;
  /// What is wrong with the robot that answered, if anything.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] bool lockstep() const { return lockstep_; }

  void Receive(Line line, std::span<const wire::Byte> bytes, RunTime now);
  /// @param stamp  on its clock; below 1 ms on the controller's, no trigger made the image.
  void Arrive(CameraPort camera, cv::Mat image, RunTime stamp, StampClock clock);
  /// Nothing more comes from there.
  void Cut(Line line, RunTime now);
  void Cut(CameraPort camera, RunTime now);
  /// Bytes that wait to be sent; they are taken.
  [[nodiscard]] wire::Bytes Output(Line line);

  /// The next reading, in order of arrival; absent if there is none yet, or never will be (over()).
  /// Also keeps the robot driving: while it is called, the last command is repeated.
  [[nodiscard]] std::optional<Reading> Next(RunTime now);
  /// The controller's line is down, and all that it left has been handed over.
  [[nodiscard]] bool over() const { return lines_[0].down && ready_.empty(); }
  [[nodiscard]] RunTime run_time() const { return run_time_; }

  CommandOutcome Apply(const Command& command, RunTime now);
  void Stop(RunTime now);
  [[nodiscard]] bool stop_acknowledged() const { return stop_acknowledged_; }
  [[nodiscard]] const wire::Status& status() const { return status_; }
  [[nodiscard]] const wire::Decoder::Counts& received(Line line) const;

 private:
  struct LineState {
    bool present{}, down{};
    wire::Decoder decoder;
    wire::Encoder encoder;
    wire::Bytes out;
    ClockMap clock;
    std::optional<wire::Hello> hello;
    RunTime heard_at{};
    std::uint32_t paced{}, acknowledged{};  ///< lockstep: steps
  };
  struct Staged {
    Reading reading;
    std::uint32_t lost_before{};
  };
  /// A laser revolution whose parts are still coming.
  struct Turn {
    std::uint32_t number{};
    std::size_t parts_end{};
    LaserRevolution revolution;
  };

  [[nodiscard]] LineState& At(Line line) { return lines_[static_cast<std::size_t>(line)]; }
  void Handle(Line line, const wire::Frame& frame, RunTime now);
  void Greet(Line line, const wire::Hello& hello, wire::WireTime time, RunTime now);
  void Take(Line line, const wire::Message& message, const wire::Frame& frame, RunTime now);
  void TakePart(const wire::Laser& part, RunTime captured_at, RunTime arrived_at);
  void TakeImages(RunTime arrived_at);
  void Stage(RunTime captured_at, RunTime arrived_at, decltype(Reading::value) value,
             std::uint32_t lost_before);
  void Release();
  /// Before a line's losses are told: hands over what came before them. In lockstep a step that is
  /// not complete waits, or with the controller's line never was: how far it got is chance.
  void SettleBeforeCut(Line line, RunTime now);
  void HandOver(Reading reading);
  void WatchSilence(RunTime now);
  [[nodiscard]] bool Settled() const;
  void KeepDriving(RunTime now);
  void AcknowledgePace();
  void Send(Line line, const wire::Message& message, RunTime now);
  [[nodiscard]] RunTime RunClock(RunTime now) const;

  const Description robot_;
  HostOptions options_;
  wire::Scales scales_;
  std::array<LineState, kLines> lines_;
  std::array<bool, kCameraPorts> camera_down_{};
  std::array<std::uint32_t, kCameraPorts> images_{};  ///< that a trigger made
  wire::Pace served_;
  std::map<Sensor, Continuity> continuity_;
  std::map<Sensor, ImageMatcher> matchers_;
  std::optional<Turn> turn_;
  std::optional<std::uint32_t> whole_turn_;

  bool lockstep_{};
  RunTime began_{};       ///< on the host's clock
  RunTime run_time_{};    ///< arrival of the last reading handed over
  RunTime newest_{};      ///< newest time on the controller's line
  RunTime settled_at_{};  ///< lockstep: time of the last step that was complete
  std::vector<Staged> staged_;
  std::deque<Reading> ready_;

  std::string trouble_;
  wire::Status status_;
  std::optional<wire::Command> command_;
  RunTime commanded_at_{}, stopped_at_{};  ///< on the run's clock
  bool stopping_{}, stop_acknowledged_{};
};

}  // namespace kantaro::robot
