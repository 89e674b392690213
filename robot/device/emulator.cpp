#include "robot/device/emulator.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/files.hpp"
#include "robot/device/config.hpp"

namespace kantaro::robot {
namespace {

using Clock = std::chrono::steady_clock;
using wire::Byte;
using wire::Bytes;

constexpr int kBitsPerSecond[kLines] = {921600, 2000000};
constexpr int kLookAgain_ms = 20;
constexpr auto kSendAgain = std::chrono::milliseconds(50);
constexpr RunTime kAfterwards = std::chrono::seconds(1);

/// The type of a stuffed frame. The first run holds version and type, neither of them zero.
bool PassesUnhurt(const Bytes& stuffed) {
  if (stuffed.size() < 3) return false;
  const auto type = static_cast<wire::Type>(stuffed[2]);
  return type == wire::Type::kOpen || type == wire::Type::kHello || type == wire::Type::kPace ||
         type == wire::Type::kPaceAck;
}

void Append(Bytes& bytes, std::span<const Byte> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

}  // namespace

Bytes BadLine::Pass(std::span<const Byte> bytes) {
  Bytes out;
  for (const Byte byte : bytes) {
    if (byte != 0) {
      frame_.push_back(byte);
    } else if (!frame_.empty()) {
      PassFrame(out);
      frame_.clear();
    }
  }
  return out;
}

void BadLine::PassFrame(Bytes& out) {
  const auto send = [&] {
    out.push_back(0);
    Append(out, frame_);
    out.push_back(0);
  };
  if (PassesUnhurt(frame_)) return send();
  const double fate = random_.Uniform(0.0, 1.0);
  if (fate < faults_.lost) return;
  if (fate < faults_.lost + faults_.doubled) send();
  if (fate >= 1.0 - faults_.corrupted) {
    frame_[random_.Index(frame_.size())] ^= Byte(1 << random_.Index(8));
    for (std::uint64_t noise = random_.Index(8); noise > 0; --noise) {
      out.push_back(Byte(random_.Index(256)));
    }
  }
  send();
}

Emulator::Emulator(Hardware& robot, const Description& description, EmulatorOptions options)
    : robot_(robot), options_(std::move(options)) {
  std::filesystem::create_directories(options_.folder);
  options_.folder = std::filesystem::absolute(options_.folder);
  if (options_.controller.empty()) options_.controller = options_.folder / "controller";
  if (options_.laser.empty()) options_.laser = options_.folder / "laser";
  wire::FirmwareOptions controller = wire::ControllerOf(description, options_.cameras);
  wire::FirmwareOptions scanner = wire::ScannerOf(description);
  controller.lockstep = scanner.lockstep = options_.lockstep;
  MakeEnd(Line::kController, std::move(controller), options_.controller);
  MakeEnd(Line::kLaser, std::move(scanner), options_.laser);
  if (options_.cameras) MakePipes(description);
  WriteConfig();
}

Emulator::~Emulator() {
  std::error_code none;
  for (const End& end : ends_) std::filesystem::remove(end.link, none);
}

void Emulator::MakeEnd(Line line, wire::FirmwareOptions options,
                       const std::filesystem::path& link) {
  End& end = ends_[static_cast<std::size_t>(line)];
  end.firmware.emplace(std::move(options));
  PlayedLine played = OpenPlayedLine();
  end.line.emplace(std::move(played.line));
  const char* name = line == Line::kController ? "controller" : "laser";
  end.to_host.emplace(options_.faults,
                      RandomStream(options_.seed, fmt::format("line.{}.to_host", name)));
  end.from_host.emplace(options_.faults,
                        RandomStream(options_.seed, fmt::format("line.{}.from_host", name)));
  if (std::filesystem::is_symlink(link)) std::filesystem::remove(link);
  std::filesystem::create_symlink(played.device, link);
  end.link = link;
}

void Emulator::MakePipes(const Description& description) {
  const std::array cameras{&description.front_camera, &description.stereo_left,
                           &description.stereo_right};
  for (std::size_t i = 0; i < kCameraPorts; ++i) {
    pipes_[i] = std::make_unique<ImagePipe>(
        options_.folder / fmt::format("{}.mkv", ToString(static_cast<CameraPort>(i))),
        cv::Size(cameras[i]->width_px, cameras[i]->height_px),
        RunTime(static_cast<RunTime::rep>(1e9 / cameras[i]->rate_Hz)));
  }
}

void Emulator::WriteConfig() const {
  std::string text =
      fmt::format("controller: {{line: {}, bits_per_s: {}}}\nlaser: {{line: {}, bits_per_s: {}}}\n",
                  std::filesystem::absolute(options_.controller).string(), kBitsPerSecond[0],
                  std::filesystem::absolute(options_.laser).string(), kBitsPerSecond[1]);
  if (options_.cameras) {
    text += "cameras:\n";
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      const char* name = ToString(static_cast<CameraPort>(i));
      text += fmt::format("  {0}: {{stream: {0}.mkv, stamps: controller}}\n", name);
    }
  }
  WriteFileAtomically(config(), text);
}

bool Emulator::Serve(const std::function<void(RunTime)>& watch,
                     const std::function<bool()>& give_up) {
  if (!WaitForHost(give_up)) return false;
  began_ = Clock::now();
  while (const std::optional<Reading> reading = robot_.Read()) {
    const RunTime now = reading->arrived_at;
    Cut(now);
    Show(*reading);
    for (End& end : ends_) Turn(end, now, std::span(&*reading, 1));
    Drive();
    KeepPace(now);
    if (!ends_[0].up() && !lost_at_) lost_at_ = now;
    if (watch) watch(now);
    if (lost_at_ && now >= *lost_at_ + kAfterwards) break;
  }
  for (auto& pipe : pipes_) {
    if (pipe) pipe->Close();
  }
  for (End& end : ends_) end.line.reset();
  return true;
}

bool Emulator::WaitForHost(const std::function<bool()>& give_up) {
  const auto open = [](const End& end) { return end.firmware->open(); };
  // The laser's line is the host's to use or not.
  while (!open(ends_[0])) {
    if (give_up && give_up()) return false;
    Pump(RunTime(0), kLookAgain_ms);
  }
  const auto give_up_at = Clock::now() + std::chrono::milliseconds(500);
  while (!open(ends_[1]) && Clock::now() < give_up_at) Pump(RunTime(0), kLookAgain_ms);
  return true;
}

/// One turn of a processor's loop, and what it says goes onto its line.
void Emulator::Turn(End& end, RunTime now, std::span<const Reading> measured) {
  const Bytes in = end.line ? end.from_host->Pass(end.line->Read()) : Bytes{};
  Bytes out;
  for (const Bytes& frame : end.firmware->Step(now, in, measured)) {
    Append(out, end.to_host->Pass(frame));
  }
  if (end.up()) end.line->Write(out);
}

void Emulator::Show(const Reading& reading) {
  const auto serve = [&](CameraPort camera, const cv::Mat& image) {
    const auto& pipe = pipes_[static_cast<std::size_t>(camera)];
    if (pipe) pipe->Serve(image, reading.captured_at);
  };
  if (const auto* front = std::get_if<FrontImage>(&reading.value)) {
    serve(CameraPort::kFront, front->image);
    ++served_.front_images;
  } else if (const auto* stereo = std::get_if<StereoPair>(&reading.value)) {
    serve(CameraPort::kStereoLeft, stereo->left);
    serve(CameraPort::kStereoRight, stereo->right);
    ++served_.stereo_pairs;
  }
}

/// What the controller tells its motors and lamps is done by the robot.
void Emulator::Drive() {
  const wire::Firmware& controller = *ends_[0].firmware;
  if (controller.stopped()) {
    if (!std::exchange(stopped_, true)) robot_.Stop();
    return;
  }
  const Command& wanted = controller.drive();
  const Command done = driven_.value_or(Command{});
  if (wanted.left_rad_s == done.left_rad_s && wanted.right_rad_s == done.right_rad_s &&
      wanted.lights == done.lights) {
    return;
  }
  driven_ = wanted;
  static_cast<void>(robot_.Apply(wanted));
}

void Emulator::Cut(RunTime now) {
  if (options_.cut_controller_at && now >= *options_.cut_controller_at) ends_[0].line.reset();
  if (options_.cut_laser_at && now >= *options_.cut_laser_at) ends_[1].line.reset();
  if (options_.cut_front_at && now >= *options_.cut_front_at && pipes_[0]) pipes_[0]->Close();
}

void Emulator::KeepPace(RunTime now) {
  if (options_.lockstep) {
    KeepLockstep(now);
  } else {
    KeepRealTime(now);
  }
}

void Emulator::KeepLockstep(RunTime now) {
  ++served_.step;
  auto send_at = Clock::now();
  const auto waits = [&](const End& end) {
    return end.up() && end.firmware->open() && end.firmware->acknowledged() != served_.step;
  };
  // A host without the controller has nothing more to acknowledge.
  while (ends_[0].up() && (waits(ends_[0]) || waits(ends_[1]))) {
    if (Clock::now() >= send_at) {
      for (End& end : ends_) {
        if (waits(end)) end.line->Write(end.firmware->EncodePace(served_));
      }
      send_at = Clock::now() + kSendAgain;
    }
    Pump(now, kLookAgain_ms);
  }
}

void Emulator::KeepRealTime(RunTime now) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*began_ + now - Clock::now());
    if (left.count() <= 0) return;
    Pump(now, static_cast<int>(std::min<std::int64_t>(left.count(), kLookAgain_ms)));
  }
}

/// Waits for the host's bytes, and lets both processors have them.
void Emulator::Pump(RunTime now, int milliseconds) {
  std::vector<pollfd> watched;
  for (const End& end : ends_) {
    if (!end.up()) continue;
    const short events = static_cast<short>(end.line->pending() ? POLLIN | POLLOUT : POLLIN);
    watched.push_back({end.line->descriptor(), events, 0});
  }
  poll(watched.data(), watched.size(), milliseconds);
  for (End& end : ends_) Turn(end, now, {});
  Drive();
}

}  // namespace kantaro::robot
