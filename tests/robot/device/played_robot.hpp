#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "robot/device/device.hpp"
#include "robot/device/emulator.hpp"
#include "tests/robot/device/bench_robot.hpp"

namespace kantaro::robot {

/// A robot behind the emulator on a thread of its own, and the device that drives it.
class PlayedRobot : public Hardware {
 public:
  PlayedRobot(std::unique_ptr<Hardware> robot, const Description& description,
              EmulatorOptions options = {}, std::function<void(RunTime)> watch = {})
      : robot_(std::move(robot)) {
    static std::atomic<int> count{};
    options.folder = std::filesystem::temp_directory_path() /
                     fmt::format("kantaro_played_{}_{}", getpid(), ++count);
    folder_ = options.folder;
    emulator_.emplace(*robot_, description, std::move(options));
    thread_ = std::jthread([this, watch = std::move(watch)](const std::stop_token& stop) {
      emulator_->Serve(watch, [&] { return stop.stop_requested(); });
    });
    device_ = OpenDevice(emulator_->config(), description);
  }
  ~PlayedRobot() override {
    Leave();
    thread_ = {};
    emulator_.reset();
    std::filesystem::remove_all(folder_);
  }

  [[nodiscard]] std::optional<Reading> Read() override { return device_->Read(); }
  CommandOutcome Apply(const Command& command) override { return device_->Apply(command); }
  void Stop() override { device_->Stop(); }
  [[nodiscard]] RunTime Now() const override { return device_->Now(); }

  /// The host lets go of the lines.
  void Leave() { device_.reset(); }
  /// Waits until the emulator has played its last. @pre the lines are down, or the run is over.
  const Emulator& Finish() {
    thread_.join();
    return *emulator_;
  }

 private:
  std::unique_ptr<Hardware> robot_;
  std::filesystem::path folder_;
  std::optional<Emulator> emulator_;
  std::jthread thread_;
  std::unique_ptr<Hardware> device_;
};

[[nodiscard]] inline const Description& Kantaro() {
  static const Description description = ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  return description;
}

[[nodiscard]] inline std::unique_ptr<PlayedRobot> PlayBench(
    BenchRobot::Options bench = {}, EmulatorOptions options = {},
    std::function<void(RunTime)> watch = {}) {
  options.cameras = bench.cameras;
  return std::make_unique<PlayedRobot>(std::make_unique<BenchRobot>(Kantaro(), bench), Kantaro(),
                                       std::move(options), std::move(watch));
}

}  // namespace kantaro::robot
