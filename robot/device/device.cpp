#include "robot/device/device.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "robot/device/camera.hpp"
#include "robot/device/config.hpp"
#include "robot/device/host.hpp"
#include "robot/device/line.hpp"

namespace kantaro::robot {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskAgain(100);
constexpr int kLookAgain_ms = 10;

/// Tells that a camera has something new.
class Wake {
 public:
  Wake() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  ~Wake() { close(descriptor_); }
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }
  void Clear() const {
    std::uint64_t count = 0;
    static_cast<void>(read(descriptor_, &count, sizeof count));
  }

 private:
  int descriptor_;
};

ByteLine OpenLine(const DeviceConfig& config, const DeviceConfig::SerialLine& line,
                  const std::string& name) {
  try {
    return OpenSerialLine(line.device, line.bits_per_s);
  } catch (const std::system_error& error) {
    throw config.ErrorAt(line.config_line, name + ".line",
                         fmt::format("{}: {}", line.device.string(), error.what()));
  }
}

RunTime HostClock() { return Clock::now().time_since_epoch(); }

/// Of the run's number only: two runs on one robot must not have the same.
std::uint32_t NewSession() {
  return static_cast<std::uint32_t>(HostClock().count() >> 10) ^
         static_cast<std::uint32_t>(getpid());
}

HostOptions OptionsOf(const DeviceConfig& config) {
  HostOptions options;
  options.laser = config.laser.has_value();
  options.front = config.cameras[0].has_value();
  options.stereo = config.cameras[1].has_value();
  options.session = NewSession();
  options.patience = config.patience;
  options.line_patience = config.line_patience;
  return options;
}

class Device : public Hardware {
 public:
  Device(DeviceConfig config, const Description& robot)
      : config_(std::move(config)),
        sizes_{cv::Size(robot.front_camera.width_px, robot.front_camera.height_px),
               cv::Size(robot.stereo_left.width_px, robot.stereo_left.height_px),
               cv::Size(robot.stereo_right.width_px, robot.stereo_right.height_px)},
        host_(robot, OptionsOf(config_), HostClock()) {
    lines_[0].emplace(OpenLine(config_, config_.controller, "controller"));
    if (config_.laser) lines_[1].emplace(OpenLine(config_, *config_.laser, "laser"));
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      const auto& camera = config_.cameras[i];
      if (camera) readers_[i].emplace(camera->source, wake_.descriptor());
    }
    Begin();
  }
  ~Device() override {
    Stop();
    // What the emulator still serves must not hold up its end of the lines.
    lines_ = {};
  }

  std::optional<Reading> Read() override {
    for (;;) {
      Collect();
      std::optional<Reading> reading = host_.Next(HostClock());
      Flush();
      if (reading || host_.over()) return reading;
      Wait(kLookAgain_ms);
    }
  }

  CommandOutcome Apply(const Command& command) override {
    const CommandOutcome outcome = host_.Apply(command, HostClock());
    Flush();
    return outcome;
  }

  void Stop() override {
    host_.Stop(HostClock());
    Flush();
  }

  [[nodiscard]] RunTime Now() const override { return host_.run_time(); }

 private:
  /// Cameras first, for a stream may only be opened while its other end is there; then both
  /// processors are asked until they answer.
  void Begin() {
    const RunTime give_up_at = HostClock() + config_.answer_within;
    RunTime ask_at{};
    while (!CamerasOpen() || !host_.opened()) {
      const RunTime now = HostClock();
      if (now > give_up_at) throw NoAnswer();
      if (CamerasOpen() && now >= ask_at) {
        host_.SendOpen(now);
        ask_at = now + kAskAgain;
      }
      Collect();
      Flush();
      if (!host_.trouble().empty()) {
        throw config_.ErrorAt(config_.controller.config_line, "controller.line", host_.trouble());
      }
      if (!host_.opened()) Wait(kLookAgain_ms);
    }
  }

  [[nodiscard]] bool CamerasOpen() const {
    bool open = true;
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      if (!readers_[i]) continue;
      const CameraReader::State state = readers_[i]->state();
      if (state == CameraReader::State::kUnusable) {
        throw CameraError(i, "VideoCapture cannot open it");
      }
      open = open && state != CameraReader::State::kOpening;
    }
    return open;
  }

  [[nodiscard]] InputError CameraError(std::size_t port, const std::string& problem) const {
    return config_.ErrorAt(config_.cameras[port]->config_line,
                           fmt::format("cameras.{}", ToString(static_cast<CameraPort>(port))),
                           problem);
  }

  [[nodiscard]] InputError NoAnswer() const {
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      if (readers_[i] && readers_[i]->state() == CameraReader::State::kOpening) {
        return CameraError(i, "no image comes from there");
      }
    }
    const bool laser = host_.silent() == Line::kLaser;
    const auto& line = laser ? *config_.laser : config_.controller;
    return config_.ErrorAt(line.config_line, laser ? "laser.line" : "controller.line",
                           fmt::format("{}: nothing there answers", line.device.string()));
  }

  /// Everything that has come, to the host.
  void Collect() {
    // A robot that leaves closes its controller's line first. That line is read last and cut first,
    // so that it does not matter where in between the other is found closed.
    for (std::size_t i = kLines; i-- > 0;) {
      if (lines_[i]) host_.Receive(static_cast<Line>(i), lines_[i]->Read(), HostClock());
    }
    for (std::size_t i = 0; i < kLines; ++i) {
      if (!lines_[i] || !lines_[i]->gone() || !host_.opened()) continue;
      host_.Cut(static_cast<Line>(i), HostClock());
    }
    wake_.Clear();
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      if (readers_[i] && host_.opened()) CollectImages(i);
    }
  }

  void CollectImages(std::size_t i) {
    const auto port = static_cast<CameraPort>(i);
    for (StampedImage& stamped : readers_[i]->Take()) {
      if (stamped.image.size() != sizes_[i]) throw CameraError(i, WrongSize(i, stamped.image));
      host_.Arrive(port, std::move(stamped.image), stamped.stamp, config_.cameras[i]->stamps);
    }
    if (readers_[i]->state() == CameraReader::State::kEnded) host_.Cut(port, HostClock());
  }

  [[nodiscard]] std::string WrongSize(std::size_t i, const cv::Mat& image) const {
    return fmt::format("its images are {} x {}, the described ones {} x {}", image.cols, image.rows,
                       sizes_[i].width, sizes_[i].height);
  }

  void Flush() {
    for (std::size_t i = 0; i < kLines; ++i) {
      if (lines_[i]) lines_[i]->Write(host_.Output(static_cast<Line>(i)));
    }
  }

  void Wait(int timeout_ms) const {
    std::vector<pollfd> watched{{wake_.descriptor(), POLLIN, 0}};
    for (const auto& line : lines_) {
      if (!line || line->gone()) continue;
      watched.push_back(
          {line->descriptor(), static_cast<short>(line->pending() ? POLLIN | POLLOUT : POLLIN), 0});
    }
    poll(watched.data(), watched.size(), timeout_ms);
  }

  DeviceConfig config_;
  std::array<cv::Size, kCameraPorts> sizes_;
  Host host_;
  Wake wake_;
  std::array<std::optional<ByteLine>, kLines> lines_;
  std::array<std::optional<CameraReader>, kCameraPorts> readers_;
};

}  // namespace

std::unique_ptr<Hardware> OpenDevice(const std::filesystem::path& config,
                                     const Description& robot) {
  return std::make_unique<Device>(ReadDeviceConfig(config), robot);
}

}  // namespace kantaro::robot
