#include "robot/device/firmware.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace kantaro::robot::wire {
namespace {

constexpr std::uint32_t kMostMirrorCounts = 65536;
constexpr RunTime kStatusPeriod = std::chrono::milliseconds(100);

RunTime Period(double rate_Hz) { return RunTime(std::llround(1e9 / rate_Hz)); }

Scales ScalesOf(const Description& robot) {
  if (robot.laser.mirror_counts > kMostMirrorCounts) {
    throw std::invalid_argument(
        "the protocol carries 65536 counts to a turn of the mirror at most");
  }
  return {robot.encoder_resolution_rad, robot.laser.mirror_counts, robot.laser.range_min_m,
          robot.laser.range_max_m};
}

bool IsCamera(Sensor sensor) {
  return sensor == Sensor::kFrontCamera || sensor == Sensor::kStereoCameras;
}

}  // namespace

FirmwareOptions ControllerOf(const Description& robot, bool cameras) {
  FirmwareOptions options;
  options.robot = robot.name;
  options.scales = ScalesOf(robot);
  options.speed_limit_rad_s = robot.SpeedLimit_rad_s();
  options.periods = {{Sensor::kEncoders, Period(robot.encoder_rate_Hz)},
                     {Sensor::kInfrared, Period(robot.infrared_rate_Hz)},
                     {Sensor::kInertial, Period(robot.inertial.rate_Hz)},
                     {Sensor::kInclinometer, Period(robot.inclinometer.rate_Hz)},
                     {Sensor::kCompass, Period(robot.compass.rate_Hz)},
                     {Sensor::kBattery, Period(robot.battery.rate_Hz)}};
  if (cameras) {
    options.periods[Sensor::kFrontCamera] = Period(robot.front_camera.rate_Hz);
    options.periods[Sensor::kStereoCameras] = Period(robot.stereo_left.rate_Hz);
  }
  return options;
}

FirmwareOptions ScannerOf(const Description& robot) {
  FirmwareOptions options;
  options.robot = robot.name;
  options.scales = ScalesOf(robot);
  if (robot.laser.speed_rpm > 0.0) {
    options.periods = {{Sensor::kLaser, Period(robot.laser.speed_rpm / 60.0)}};
  }
  return options;
}

Firmware::Firmware(FirmwareOptions options) : options_(std::move(options)) {}

std::vector<Bytes> Firmware::Step(RunTime now, std::span<const Byte> in,
                                  std::span<const Reading> measured) {
  now_ = now;
  for (const Frame& frame : decoder_.Take(in)) Handle(frame);
  WatchTheHost();
  TriggerCameras();
  if (open_) {
    for (const Reading& reading : measured) Report(reading);
    ReportStatus();
  }
  return std::exchange(out_, {});
}

Bytes Firmware::EncodePace(const Pace& pace) {
  return encoder_(static_cast<Byte>(Type::kPace), ToWire(now_), Payload(pace));
}

void Firmware::Handle(const Frame& frame) {
  const std::optional<Message> message = Parse(frame);
  if (!message) return;
  if (const auto* open = std::get_if<Open>(&*message)) return Begin(*open);
  if (!open_) return;
  if (const auto* command = std::get_if<wire::Command>(&*message)) Obey(*command, frame.sequence);
  if (std::holds_alternative<wire::Stop>(*message)) StopForGood(frame.sequence);
  if (const auto* ack = std::get_if<PaceAck>(&*message)) acknowledged_ = ack->step;
}

void Firmware::Begin(const Open& open) {
  if (!open_ || open.session != session_) {
    session_ = open.session;
    open_ = true;
    encoder_.ForgetSequences();
    drive_ = {0.0, 0.0, drive_.lights};
    driven_ = false;
    status_ = reported_ = {};
    acknowledged_ = 0;
  }
  Send(MakeHello());
}

Hello Firmware::MakeHello() const {
  Hello hello;
  hello.session = session_;
  hello.lockstep = options_.lockstep;
  hello.watchdog_ms = static_cast<std::uint16_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(options_.watchdog).count());
  hello.robot = options_.robot;
  if (options_.periods.contains(Sensor::kEncoders)) {
    hello.encoder_step_nrad = Fixed<std::uint32_t>(options_.scales.encoder_step_rad, 1e9);
  }
  hello.speed_limit_urad_s = Fixed<std::uint32_t>(options_.speed_limit_rad_s, 1e6);
  if (options_.speed_limit_rad_s <= 0.0) hello.mirror_counts = options_.scales.mirror_counts;
  for (const auto& [sensor, period] : options_.periods) {
    hello.streams.push_back({sensor, static_cast<std::uint32_t>(ToWire(period).count())});
  }
  return hello;
}

void Firmware::Obey(const wire::Command& command, std::uint16_t sequence) {
  if (options_.speed_limit_rad_s <= 0.0) return;
  if (status_.stopped) return Send(Ack{Type::kCommand, sequence, CommandOutcome::kRefused});
  const double limit = options_.speed_limit_rad_s;
  const robot::Command wanted = ToCommand(command);
  drive_ = {std::clamp(wanted.left_rad_s, -limit, limit),
            std::clamp(wanted.right_rad_s, -limit, limit), wanted.lights};
  const bool limited =
      drive_.left_rad_s != wanted.left_rad_s || drive_.right_rad_s != wanted.right_rad_s;
  driven_ = true;
  commanded_at_ = now_;
  status_.watchdog_tripped = false;
  Send(Ack{Type::kCommand, sequence,
           limited ? CommandOutcome::kLimited : CommandOutcome::kHonoured});
}

void Firmware::StopForGood(std::uint16_t sequence) {
  if (options_.speed_limit_rad_s <= 0.0) return;
  status_.stopped = true;
  drive_ = {0.0, 0.0, drive_.lights};
  Send(Ack{Type::kStop, sequence, CommandOutcome::kHonoured});
}

void Firmware::WatchTheHost() {
  status_.corrupt = static_cast<std::uint32_t>(decoder_.counts().corrupt);
  status_.lost = static_cast<std::uint32_t>(decoder_.counts().lost);
  if (!driven_ || now_ - commanded_at_ < options_.watchdog) return;
  status_.watchdog_tripped = true;
  drive_ = {0.0, 0.0, drive_.lights};
}

void Firmware::TriggerCameras() {
  for (const auto& [camera, period] : options_.periods) {
    if (!IsCamera(camera)) continue;
    std::int64_t& given = triggers_[camera];
    while ((given + 1) * period <= now_) {
      ++given;
      if (!open_) continue;
      Send(Trigger{{Age(given * period, now_)}, camera, static_cast<std::uint32_t>(given)});
    }
  }
}

void Firmware::Report(const Reading& reading) {
  const Sensor sensor = SensorOf(reading);
  if (std::holds_alternative<Loss>(reading.value) || !options_.periods.contains(sensor)) return;
  if (sensor == Sensor::kLaser) ++revolution_;
  for (const Message& message : ToMessages(reading, now_, options_.scales, revolution_)) {
    Send(message);
  }
}

void Firmware::ReportStatus() {
  const bool changed = status_.watchdog_tripped != reported_.watchdog_tripped ||
                       status_.stopped != reported_.stopped ||
                       status_.motor_fault != reported_.motor_fault;
  if (!changed && now_ - reported_at_ < kStatusPeriod) return;
  Send(status_);
  reported_ = status_;
  reported_at_ = now_;
}

void Firmware::Send(const Message& message) {
  out_.push_back(encoder_(static_cast<Byte>(TypeOf(message)), ToWire(now_), Payload(message)));
}

}  // namespace kantaro::robot::wire
