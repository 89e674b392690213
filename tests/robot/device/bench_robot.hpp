#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include "robot/description.hpp"
#include "robot/hardware.hpp"
#include "robot/mirror_angle.hpp"

namespace kantaro::robot {

/// A robot on a bench: its wheels turn freely at the speed they are told, at once; every sensor
/// reads what its time and the wheels make it read. Readings come at the described rates; of one
/// instant encoders first.
class BenchRobot : public Hardware {
 public:
  struct Options {
    bool cameras{};
    RunTime end{std::chrono::seconds(2)};
    std::set<Sensor> dead{};  ///< from `dead_from` to `dead_until`
    RunTime dead_from{}, dead_until{std::chrono::hours(1)};
  };

  BenchRobot(Description description, Options options)
      : description_(std::move(description)), options_(std::move(options)) {}

  std::optional<Reading> Read() override {
    while (queue_.empty()) {
      if (now_ >= options_.end) return std::nullopt;
      Step();
    }
    Reading reading = std::move(queue_.front());
    queue_.pop_front();
    return reading;
  }
  CommandOutcome Apply(const Command& command) override {
    if (!stopped_) command_ = command;
    return stopped_ ? CommandOutcome::kRefused : CommandOutcome::kHonoured;
  }
  void Stop() override {
    stopped_ = true;
    command_.left_rad_s = command_.right_rad_s = 0.0;
  }
  [[nodiscard]] RunTime Now() const override { return now_; }
  [[nodiscard]] const Command& command() const { return command_; }

  /// The image that a camera takes at a time: noise that no other image shares.
  static cv::Mat Picture(const Camera& camera, RunTime at, int which) {
    cv::Mat image(camera.height_px, camera.width_px, CV_8UC3);
    cv::RNG random(static_cast<std::uint64_t>(at.count()) * 4 + static_cast<unsigned>(which) + 1);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
  }
  /// Ranges that tell the revolution's time, one of them too near and one too far.
  [[nodiscard]] LaserRevolution Turn(RunTime at) const {
    LaserRevolution turn;
    const int samples = static_cast<int>(
        std::lround(description_.laser.samples_Hz * 60.0 / description_.laser.speed_rpm));
    const std::uint32_t counts = description_.laser.mirror_counts;
    for (int i = 0; i < samples; ++i) {
      const auto count = static_cast<std::uint32_t>(i) * counts / static_cast<unsigned>(samples);
      turn.samples.push_back(
          {MirrorAngle(count, counts), 0.1 + 0.02 * Seconds(at) + 1e-4 * i, RangeStatus::kValid});
    }
    turn.samples[3] = {turn.samples[3].angle_rad, description_.laser.range_max_m,
                       RangeStatus::kTooFar};
    turn.samples[4] = {turn.samples[4].angle_rad, description_.laser.range_min_m,
                       RangeStatus::kTooNear};
    return turn;
  }

 private:
  static constexpr RunTime kStep = std::chrono::milliseconds(2);

  [[nodiscard]] bool Due(double rate_Hz) const {
    const auto period = RunTime(std::llround(1e9 / rate_Hz));
    return (now_ / period) != ((now_ - kStep) / period);
  }
  void Queue(Sensor sensor, double latency_s, decltype(Reading::value) value) {
    if (options_.dead.contains(sensor) && now_ >= options_.dead_from &&
        now_ < options_.dead_until) {
      return;
    }
    const RunTime latency(std::llround(latency_s * 1e9));
    waiting_.push_back({now_, now_ + latency, std::move(value)});
  }
  void Step() {
    now_ += kStep;
    for (std::size_t i = 0; i < 4; ++i) {
      angle_rad_[i] += Seconds(kStep) * (i % 2 == 0 ? command_.left_rad_s : command_.right_rad_s);
    }
    if (Due(description_.encoder_rate_Hz)) Queue(Sensor::kEncoders, 0.0, Encoders());
    if (Due(description_.inertial.rate_Hz)) {
      Queue(Sensor::kInertial, 0.0,
            InertialReading{{0.001, -0.002, Seconds(now_)}, {0.1, 0.2, 9.81}});
    }
    if (Due(description_.infrared_rate_Hz)) {
      Queue(Sensor::kInfrared, 0.0, IrRanges{{0.25}, {0.5}, {std::fmod(Seconds(now_), 1.0)}});
    }
    if (Due(description_.inclinometer.rate_Hz)) {
      Queue(Sensor::kInclinometer, 0.0, Inclination{0.1, -0.01 * Seconds(now_)});
    }
    if (Due(description_.compass.rate_Hz)) {
      Queue(Sensor::kCompass, 0.0, CompassHeading{0.3 * Seconds(now_), Seconds(now_) > 0.5});
    }
    if (Due(description_.battery.rate_Hz)) {
      Queue(Sensor::kBattery, 0.0, BatteryState{15.25, 2.125, 1.0 - 1e-3 * Seconds(now_)});
    }
    if (Due(description_.laser.speed_rpm / 60.0)) {
      Queue(Sensor::kLaser, description_.laser.latency_s, Turn(now_));
    }
    if (options_.cameras && Due(description_.front_camera.rate_Hz)) {
      Queue(Sensor::kFrontCamera, description_.front_camera.latency_s,
            FrontImage{Picture(description_.front_camera, now_, 0)});
      Queue(Sensor::kStereoCameras, description_.stereo_left.latency_s,
            StereoPair{Picture(description_.stereo_left, now_, 1),
                       Picture(description_.stereo_right, now_, 2)});
    }
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const Reading& a, const Reading& b) {
      return a.arrived_at < b.arrived_at;
    });
    while (!waiting_.empty() && waiting_.front().arrived_at <= now_) {
      queue_.push_back(std::move(waiting_.front()));
      waiting_.pop_front();
    }
  }
  [[nodiscard]] WheelEncoders Encoders() const {
    WheelEncoders encoders;
    for (std::size_t i = 0; i < 4; ++i) {
      const double step = description_.encoder_resolution_rad;
      encoders.angle_rad[i] = std::floor(angle_rad_[i] / step) * step;
    }
    return encoders;
  }

  Description description_;
  Options options_;
  RunTime now_{};
  Command command_{};
  bool stopped_{};
  std::array<double, 4> angle_rad_{};
  std::deque<Reading> waiting_, queue_;
};

}  // namespace kantaro::robot
