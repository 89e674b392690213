#include "robot/device/host.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace kantaro::robot {
namespace {

/// A third of the watchdog's time and less: two of three may be lost.
constexpr RunTime kCommandPeriod = std::chrono::milliseconds(40);
constexpr RunTime kStopPeriod = std::chrono::milliseconds(20);
constexpr RunTime kLeastPatience = std::chrono::milliseconds(100);
constexpr int kPatientPeriods = 5;
constexpr RunTime kFirstStamp =
    std::chrono::milliseconds(1);               // below it, no trigger made the image
constexpr double kLargestStepError_rad = 1e-9;  // the unit in which the robot tells its step

bool IsCamera(Sensor sensor) {
  return sensor == Sensor::kFrontCamera || sensor == Sensor::kStereoCameras;
}

Sensor SensorOf(CameraPort camera) {
  return camera == CameraPort::kFront ? Sensor::kFrontCamera : Sensor::kStereoCameras;
}

}  // namespace

Host::Host(const Description& robot, HostOptions options, RunTime now)
    : robot_(robot), options_(std::move(options)), began_(now) {
  scales_ = {robot.encoder_resolution_rad, 0, robot.laser.range_min_m, robot.laser.range_max_m};
  At(Line::kController).present = true;
  At(Line::kLaser).present = options_.laser;
  for (LineState& line : lines_) line.heard_at = now;
}

void Host::SendOpen(RunTime now) {
  for (const Line line : {Line::kController, Line::kLaser}) {
    if (!At(line).hello) Send(line, wire::Open{options_.session}, now);
  }
}

bool Host::opened() const {
  return std::all_of(lines_.begin(), lines_.end(),
                     [](const LineState& line) { return !line.present || line.hello.has_value(); });
}

Line Host::silent() const { return lines_[0].hello ? Line::kLaser : Line::kController; }

const wire::Decoder::Counts& Host::received(Line line) const {
  return lines_[static_cast<std::size_t>(line)].decoder.counts();
}

RunTime Host::RunClock(RunTime now) const { return lockstep_ ? settled_at_ : now - began_; }

void Host::Receive(Line line, std::span<const wire::Byte> bytes, RunTime now) {
  LineState& state = At(line);
  if (state.down || bytes.empty()) return;
  for (const wire::Frame& frame : state.decoder.Take(bytes)) Handle(line, frame, now);
  if (!state.hello && state.decoder.counts().foreign > 0) {
    trouble_ = fmt::format("it speaks another version of the protocol; this program speaks {}",
                           wire::kProtocolVersion);
  }
}

void Host::Handle(Line line, const wire::Frame& frame, RunTime now) {
  LineState& state = At(line);
  const std::optional<wire::Message> message = wire::Parse(frame);
  if (!message) return;
  state.heard_at = now;
  state.clock.Observe(frame.time, RunClock(now));
  if (const auto* hello = std::get_if<wire::Hello>(&*message)) {
    Greet(line, *hello, frame.time, now);
  } else if (state.hello) {
    if (line == Line::kController) newest_ = std::max(newest_, state.clock(frame.time));
    Take(line, *message, frame, now);
  }
}

void Host::Greet(Line line, const wire::Hello& hello, wire::WireTime time, RunTime now) {
  LineState& state = At(line);
  if (state.hello || hello.session != options_.session) return;
  if (hello.robot != robot_.name) {
    trouble_ = fmt::format("the robot there is \"{}\", the one described \"{}\"", hello.robot,
                           robot_.name);
  }
  if (line == Line::kController &&
      std::abs(hello.encoder_step_nrad * 1e-9 - robot_.encoder_resolution_rad) >
          kLargestStepError_rad) {
    trouble_ = fmt::format("its encoders step by {} nrad, the described ones by {:.0f} nrad",
                           hello.encoder_step_nrad, robot_.encoder_resolution_rad * 1e9);
  }
  if (line == Line::kLaser) {
    scales_.mirror_counts = hello.mirror_counts;
    if (hello.mirror_counts == 0) trouble_ = "this is no laser scanner";
  }
  state.hello = hello;
  lockstep_ = hello.lockstep;
  if (lockstep_) state.clock.Fix(time);
  for (const auto& [sensor, period_us] : hello.streams) {
    if (sensor == Sensor::kFrontCamera && !options_.front) continue;
    if (sensor == Sensor::kStereoCameras && !options_.stereo) continue;
    const RunTime period = std::chrono::microseconds(std::max(1u, period_us));
    const auto known = options_.patience.find(sensor);
    const RunTime patience = known != options_.patience.end()
                                 ? known->second
                                 : std::max(kLeastPatience, kPatientPeriods * period);
    continuity_.insert_or_assign(sensor, Continuity(sensor, period, patience, RunClock(now)));
    if (IsCamera(sensor)) {
      const std::size_t images = sensor == Sensor::kStereoCameras ? 2 : 1;
      matchers_.insert_or_assign(sensor, ImageMatcher(images, period));
    }
  }
}

void Host::Take(Line line, const wire::Message& message, const wire::Frame& frame, RunTime now) {
  LineState& state = At(line);
  const RunTime sent_at = state.clock(frame.time);
  const RunTime captured_at = sent_at - wire::AgeOf(message).value_or(RunTime(0));
  const RunTime arrived_at = lockstep_ ? sent_at : RunClock(now);
  if (auto value = wire::ToValue(message, scales_)) {
    Stage(captured_at, arrived_at, *std::move(value), frame.lost_before);
  } else if (const auto* part = std::get_if<wire::Laser>(&message)) {
    TakePart(*part, captured_at, arrived_at);
  } else if (const auto* trigger = std::get_if<wire::Trigger>(&message)) {
    const auto matcher = matchers_.find(trigger->camera);
    if (matcher != matchers_.end()) matcher->second.Trigger(trigger->frame, captured_at);
  } else if (const auto* status = std::get_if<wire::Status>(&message)) {
    status_ = *status;
  } else if (const auto* ack = std::get_if<wire::Ack>(&message)) {
    stop_acknowledged_ = stop_acknowledged_ || (stopping_ && ack->type == wire::Type::kStop);
  } else if (const auto* pace = std::get_if<wire::Pace>(&message)) {
    state.paced = pace->step;
    served_ = *pace;
    // Sent again, for the answer was lost.
    if (state.acknowledged == pace->step) Send(line, wire::PaceAck{pace->step}, now);
  }
}

void Host::TakePart(const wire::Laser& part, RunTime captured_at, RunTime arrived_at) {
  if (!turn_ || turn_->number != part.revolution) turn_ = Turn{part.revolution, 0, {}};
  if (part.first != turn_->parts_end) return;  // one before it was lost, and so the revolution
  for (const wire::Laser::Sample& sample : part.samples) {
    turn_->revolution.samples.push_back(wire::ToSample(sample, scales_));
  }
  turn_->parts_end += part.samples.size();
  if (turn_->parts_end != part.of) return;
  const std::uint32_t lost = whole_turn_ ? part.revolution - *whole_turn_ - 1 : 0;
  whole_turn_ = part.revolution;
  Stage(captured_at, arrived_at, std::move(turn_->revolution), lost);
  turn_.reset();
}

void Host::Arrive(CameraPort camera, cv::Mat image, RunTime stamp, StampClock clock) {
  const auto matcher = matchers_.find(SensorOf(camera));
  if (matcher == matchers_.end() || (clock == StampClock::kController && stamp < kFirstStamp)) {
    return;
  }
  ++images_[static_cast<std::size_t>(camera)];
  std::optional<RunTime> stamped_at;
  if (clock == StampClock::kController) {
    stamped_at = At(Line::kController).clock(std::chrono::round<wire::WireTime>(stamp));
  } else if (clock == StampClock::kHost) {
    stamped_at = stamp - began_;
  }
  matcher->second.Image(camera == CameraPort::kStereoRight ? 1 : 0, std::move(image), stamped_at);
}

void Host::TakeImages(RunTime arrived_at) {
  for (auto& [camera, matcher] : matchers_) {
    while (auto match = matcher.Take()) {
      if (camera == Sensor::kFrontCamera) {
        Stage(match->captured_at, arrived_at, FrontImage{std::move(match->images[0])},
              match->lost_before);
      } else {
        Stage(match->captured_at, arrived_at,
              StereoPair{std::move(match->images[0]), std::move(match->images[1])},
              match->lost_before);
      }
    }
  }
}

void Host::Stage(RunTime captured_at, RunTime arrived_at, decltype(Reading::value) value,
                 std::uint32_t lost_before) {
  staged_.push_back({{captured_at, arrived_at, std::move(value)}, lost_before});
}

void Host::Release() {
  std::stable_sort(staged_.begin(), staged_.end(), [](const Staged& a, const Staged& b) {
    return a.reading.arrived_at < b.reading.arrived_at;
  });
  for (Staged& staged : std::exchange(staged_, {})) {
    const auto watched = continuity_.find(robot::SensorOf(staged.reading));
    if (watched == continuity_.end() || watched->second.down()) continue;
    if (auto loss = watched->second.Came(staged.reading.captured_at, staged.lost_before,
                                         staged.reading.arrived_at)) {
      HandOver(*std::move(loss));
    }
    HandOver(std::move(staged.reading));
  }
}

void Host::HandOver(Reading reading) {
  const RunTime earliest = ready_.empty() ? run_time_ : ready_.back().arrived_at;
  reading.arrived_at = std::max(reading.arrived_at, earliest);
  reading.captured_at = std::clamp(reading.captured_at, RunTime(0), reading.arrived_at);
  ready_.push_back(std::move(reading));
}

void Host::Cut(Line line, RunTime now) {
  LineState& state = At(line);
  if (std::exchange(state.down, true)) return;
  if (line == Line::kLaser && lines_[0].down) return;  // the run is over as it is
  SettleBeforeCut(line, now);
  for (auto& [sensor, continuity] : continuity_) {
    if ((sensor == Sensor::kLaser) != (line == Line::kLaser) || continuity.down()) continue;
    HandOver(continuity.GoDown(RunClock(now)));
  }
}

void Host::SettleBeforeCut(Line line, RunTime now) {
  if (!lockstep_) {
    TakeImages(RunClock(now));
    Release();
  } else if (line == Line::kController) {
    staged_.clear();
  }
}

void Host::Cut(CameraPort camera, RunTime now) {
  if (std::exchange(camera_down_[static_cast<std::size_t>(camera)], true)) return;
  const auto watched = continuity_.find(SensorOf(camera));
  if (watched == continuity_.end() || watched->second.down()) return;
  if (!lockstep_) SettleBeforeCut(Line::kController, now);
  HandOver(watched->second.GoDown(RunClock(now)));
}

void Host::WatchSilence(RunTime now) {
  const RunTime patience = lockstep_ ? options_.lockstep_patience : options_.line_patience;
  for (const Line line : {Line::kController, Line::kLaser}) {
    const LineState& state = At(line);
    if (state.hello && !state.down && now - state.heard_at > patience) Cut(line, now);
  }
}

bool Host::Settled() const {
  std::optional<std::uint32_t> common;
  for (const LineState& line : lines_) {
    if (!line.present || line.down) continue;
    if (line.paced == line.acknowledged || line.paced != common.value_or(line.paced)) return false;
    common = line.paced;
  }
  const auto there = [&](CameraPort camera, std::uint32_t served) {
    const auto port = static_cast<std::size_t>(camera);
    return !matchers_.contains(SensorOf(camera)) || camera_down_[port] || images_[port] >= served;
  };
  return there(CameraPort::kFront, served_.front_images) &&
         there(CameraPort::kStereoLeft, served_.stereo_pairs) &&
         there(CameraPort::kStereoRight, served_.stereo_pairs);
}

std::optional<Reading> Host::Next(RunTime now) {
  WatchSilence(now);
  const bool settled = lockstep_ && !lines_[0].down && Settled();
  if (settled) settled_at_ = newest_;
  if (!lockstep_ || settled) {
    TakeImages(RunClock(now));
    Release();
    for (auto& [sensor, continuity] : continuity_) {
      if (auto loss = continuity.Wait(RunClock(now))) HandOver(*std::move(loss));
    }
  }
  if (!ready_.empty()) {
    Reading reading = std::move(ready_.front());
    ready_.pop_front();
    run_time_ = reading.arrived_at;
    return reading;
  }
  KeepDriving(now);
  if (settled) AcknowledgePace();
  return std::nullopt;
}

void Host::KeepDriving(RunTime now) {
  const RunTime run_now = RunClock(now);
  if (stopping_) {
    if (!stop_acknowledged_ && run_now - stopped_at_ >= kStopPeriod) {
      stopped_at_ = run_now;
      Send(Line::kController, wire::Stop{}, now);
    }
  } else if (command_ && run_now - commanded_at_ >= kCommandPeriod) {
    commanded_at_ = run_now;
    Send(Line::kController, *command_, now);
  }
}

void Host::AcknowledgePace() {
  for (const Line line : {Line::kLaser, Line::kController}) {
    LineState& state = At(line);
    if (!state.present || state.down) continue;
    state.acknowledged = state.paced;
    Send(line, wire::PaceAck{state.paced}, began_);
  }
}

CommandOutcome Host::Apply(const Command& command, RunTime now) {
  if (!std::isfinite(command.left_rad_s) || !std::isfinite(command.right_rad_s)) {
    throw std::invalid_argument("a wheel speed is no number");
  }
  if (!(command.lights >= 0.0 && command.lights <= 1.0)) {
    throw std::invalid_argument("lights must be 0 to 1");
  }
  if (stopping_ || lines_[0].down || status_.stopped) return CommandOutcome::kRefused;
  const wire::Command message = wire::ToMessage(command);
  if (message != command_ || RunClock(now) - commanded_at_ >= kCommandPeriod) {
    command_ = message;
    commanded_at_ = RunClock(now);
    Send(Line::kController, message, now);
  }
  const double fastest = std::max(std::abs(command.left_rad_s), std::abs(command.right_rad_s));
  return fastest > robot_.SpeedLimit_rad_s() ? CommandOutcome::kLimited : CommandOutcome::kHonoured;
}

void Host::Stop(RunTime now) {
  if (stopping_) return;
  stopping_ = true;
  stopped_at_ = RunClock(now);
  // The one message that should not need to be repeated.
  for (int i = 0; i < 3; ++i) Send(Line::kController, wire::Stop{}, now);
}

wire::Bytes Host::Output(Line line) { return std::exchange(At(line).out, {}); }

void Host::Send(Line line, const wire::Message& message, RunTime now) {
  LineState& state = At(line);
  if (!state.present || state.down) return;
  const auto time = wire::ToWire(std::max(RunTime(0), RunClock(now)));
  const wire::Bytes bytes =
      state.encoder(static_cast<wire::Byte>(wire::TypeOf(message)), time, wire::Payload(message));
  state.out.insert(state.out.end(), bytes.begin(), bytes.end());
}

}  // namespace kantaro::robot
