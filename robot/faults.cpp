#include "robot/faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace kantaro::robot {
namespace {

constexpr std::array<FaultKind, 6> kKinds{FaultKind::kFrozen,    FaultKind::kDropped,
                                          FaultKind::kSaturated, FaultKind::kBiased,
                                          FaultKind::kDelayed,   FaultKind::kDead};
constexpr double kTurn_rad = 2.0 * std::numbers::pi;

RunTime FromSeconds(double seconds) { return RunTime(std::llround(seconds * 1e9)); }

bool HasAmount(FaultKind kind) {
  return kind == FaultKind::kDropped || kind == FaultKind::kBiased || kind == FaultKind::kDelayed;
}

/// The scale's end with the reading's sign, so that a robot that leans reads too much, not the
/// other way.
double EndOf(double range, double value) { return std::copysign(range, value); }

void SetRange(LaserSample& sample, double range_m, const Laser& laser) {
  if (range_m > laser.range_max_m) {
    sample = {sample.angle_rad, laser.range_max_m, RangeStatus::kTooFar};
  } else if (range_m < laser.range_min_m) {
    sample = {sample.angle_rad, laser.range_min_m, RangeStatus::kTooNear};
  } else {
    sample = {sample.angle_rad, static_cast<double>(static_cast<float>(range_m)),
              RangeStatus::kValid};
  }
}

struct Saturator {
  const Description& robot;

  void operator()(FrontImage& front) const { front.image = White(front.image); }
  void operator()(StereoPair& pair) const {
    pair.left = White(pair.left);
    pair.right = White(pair.right);
  }
  void operator()(LaserRevolution& revolution) const {
    for (LaserSample& sample : revolution.samples)
      SetRange(sample, std::numeric_limits<double>::infinity(), robot.laser);
  }
  void operator()(IrRanges& ranges) const {
    ranges.up.value = ranges.left.value = ranges.right.value = 1.0;
  }
  void operator()(WheelEncoders& encoders) const {
    encoders.angle_rad.fill(std::numeric_limits<std::int32_t>::max() *
                            robot.encoder_resolution_rad);
  }
  void operator()(InertialReading& inertial) const {
    for (int i = 0; i < 3; ++i) {
      double& turning = inertial.angular_velocity_rad_s[i];
      turning = EndOf(robot.inertial.gyro_range_rad_s, turning);
      double& force = inertial.specific_force_m_s2[i];
      force = EndOf(robot.inertial.accelerometer_range_m_s2, force);
    }
  }
  void operator()(Inclination& inclination) const {
    inclination.roll_rad = EndOf(robot.inclinometer.range_rad, inclination.roll_rad);
    inclination.pitch_rad = EndOf(robot.inclinometer.range_rad, inclination.pitch_rad);
  }
  void operator()(CompassHeading& compass) const { compass = {kTurn_rad / 8.0, true}; }
  void operator()(BatteryState& battery) const {
    battery = {robot.battery.OpenVoltage(1.0), battery.current_A, 1.0};
  }
  void operator()(Loss&) const {}

 private:
  static cv::Mat White(const cv::Mat& image) {
    return cv::Mat(image.size(), image.type(), cv::Scalar::all(255.0));
  }
};

struct Biaser {
  double amount;
  const Description& robot;

  void operator()(FrontImage& front) const { front.image = Brighter(front.image); }
  void operator()(StereoPair& pair) const {
    pair.left = Brighter(pair.left);
    pair.right = Brighter(pair.right);
  }
  void operator()(LaserRevolution& revolution) const {
    for (LaserSample& sample : revolution.samples) {
      if (sample.status == RangeStatus::kValid)
        SetRange(sample, sample.range_m + amount, robot.laser);
    }
  }
  void operator()(IrRanges& ranges) const {
    for (IrReading* reading : {&ranges.up, &ranges.left, &ranges.right})
      reading->value = std::clamp(reading->value + amount, 0.0, 1.0);
  }
  void operator()(WheelEncoders& encoders) const {
    for (double& angle : encoders.angle_rad) angle *= 1.0 + amount;
  }
  void operator()(InertialReading& inertial) const {
    inertial.angular_velocity_rad_s.array() += amount;
  }
  void operator()(Inclination& inclination) const {
    inclination.roll_rad += amount;
    inclination.pitch_rad += amount;
  }
  void operator()(CompassHeading& compass) const {
    const double heading = std::fmod(compass.heading_rad + amount, kTurn_rad);
    compass.heading_rad = heading < 0.0 ? heading + kTurn_rad : heading;
  }
  void operator()(BatteryState& battery) const { battery.voltage_V += amount; }
  void operator()(Loss&) const {}

 private:
  [[nodiscard]] cv::Mat Brighter(const cv::Mat& image) const {
    cv::Mat shifted;
    cv::add(image, cv::Scalar::all(amount), shifted);
    return shifted;
  }
};

FaultKind KindNamed(const YamlNode& node) {
  const std::string word = node.Text();
  for (const FaultKind kind : kKinds) {
    if (word == ToString(kind)) return kind;
  }
  throw node.Error(
      fmt::format("\"{:.40}\" is no kind of fault; known are frozen, dropped, "
                  "saturated, biased, delayed and dead",
                  word));
}

double ReadAmount(const YamlNode& node, FaultKind kind) {
  const auto given = node.Find("amount");
  if (!HasAmount(kind)) {
    if (given) throw given->Error(fmt::format("a {} sensor has no amount", ToString(kind)));
    return 0.0;
  }
  const YamlNode amount = node["amount"];
  if (kind == FaultKind::kDropped) return amount.Number(0.0, 1.0);
  return kind == FaultKind::kDelayed ? amount.Number(1e-3, 60.0) : amount.Number(-1e6, 1e6);
}

std::vector<Fault> ReadFault(const YamlNode& node) {
  node.AllowOnly({"sensor", "kind", "from_s", "until_s", "from_reading", "amount"});
  Fault fault;
  fault.kind = KindNamed(node["kind"]);
  fault.amount = ReadAmount(node, fault.kind);
  if (const auto from = node.Find("from_s")) fault.from = FromSeconds(from->Number(0.0, 1e6));
  if (const auto until = node.Find("until_s")) {
    fault.until = FromSeconds(until->Number(0.0, 1e6));
    if (*fault.until <= fault.from) throw until->Error("the end must come after from_s");
  }
  if (const auto reading = node.Find("from_reading")) {
    fault.from_reading = static_cast<std::uint64_t>(reading->Integer(1, 1'000'000'000));
  }
  const YamlNode word = node["sensor"];
  std::vector<Fault> faults;
  for (const Sensor sensor : SensorsNamed(word.Text())) {
    fault.sensor = sensor;
    faults.push_back(fault);
  }
  if (faults.empty()) {
    throw word.Error(
        fmt::format("\"{:.40}\" is no sensor; known are {}", word.Text(), SensorWords()));
  }
  return faults;
}

void Check(const Fault& fault) {
  const bool possible = fault.kind == FaultKind::kDropped
                            ? fault.amount >= 0.0 && fault.amount <= 1.0
                        : fault.kind == FaultKind::kDelayed ? fault.amount > 0.0
                                                            : std::isfinite(fault.amount);
  if (!possible) throw std::invalid_argument("a fault that cannot be: " + ToString(fault));
}

}  // namespace

const char* ToString(FaultKind kind) {
  switch (kind) {
    case FaultKind::kFrozen:
      return "frozen";
    case FaultKind::kDropped:
      return "dropped";
    case FaultKind::kSaturated:
      return "saturated";
    case FaultKind::kBiased:
      return "biased";
    case FaultKind::kDelayed:
      return "delayed";
    case FaultKind::kDead:
      return "dead";
  }
  throw std::invalid_argument("no such kind of fault");
}

std::string ToString(const Fault& fault) {
  std::string text = fmt::format("{} {}", ToString(fault.sensor), ToString(fault.kind));
  if (HasAmount(fault.kind)) text += fmt::format(" by {}", fault.amount);
  if (fault.from > RunTime{}) text += fmt::format(" from {} s", Seconds(fault.from));
  if (fault.from_reading > 1) text += fmt::format(" from reading {}", fault.from_reading);
  if (fault.until) text += fmt::format(" until {} s", Seconds(*fault.until));
  return text;
}

std::set<Sensor> SensorsNamed(const std::string& word) {
  if (word == "cameras") return {Sensor::kFrontCamera, Sensor::kStereoCameras};
  for (std::size_t i = 0; i < kSensorCount; ++i) {
    if (word == ToString(static_cast<Sensor>(i))) return {static_cast<Sensor>(i)};
  }
  return {};
}

std::string SensorWords() {
  std::string words;
  for (std::size_t i = 0; i < kSensorCount; ++i)
    words += std::string(ToString(static_cast<Sensor>(i))) + ", ";
  return words + "cameras";
}

std::vector<Fault> ReadFaults(const YamlNode& list) {
  std::vector<Fault> faults;
  for (const YamlNode& node : list.Elements()) {
    for (const Fault& fault : ReadFault(node)) faults.push_back(fault);
  }
  return faults;
}

void Saturate(Reading& reading, const Description& description) {
  std::visit(Saturator{description}, reading.value);
}

void Bias(Reading& reading, double amount, const Description& description) {
  std::visit(Biaser{amount, description}, reading.value);
}

Faulted::Faulted(Hardware& hardware, Description description, const std::vector<Fault>& faults,
                 std::uint64_t seed)
    : hardware_(hardware), description_(std::move(description)) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    Check(faults[i]);
    faults_.push_back({faults[i], RandomStream(seed, fmt::format("fault.{}", i)), 0, {}});
  }
}

std::optional<Reading> Faulted::Read() {
  while (ready_.empty()) {
    std::optional<Reading> reading = hardware_.Read();
    if (!reading) return reading;
    const RunTime now = reading->arrived_at;
    HandOverDelayed(now);
    RunTime delay{};
    if (!std::holds_alternative<Loss>(reading->value)) {
      for (Active& active : faults_) {
        if (active.fault.sensor == SensorOf(*reading)) delay += Spoil(active, *reading);
      }
    }
    if (delay > RunTime{} && !std::holds_alternative<Loss>(reading->value)) {
      reading->arrived_at += delay;
      delayed_.push_back(*std::move(reading));
    } else {
      ready_.push_back(*std::move(reading));
    }
  }
  Reading next = std::move(ready_.front());
  ready_.pop_front();
  return next;
}

RunTime Faulted::Spoil(Active& active, Reading& reading) const {
  if (std::holds_alternative<Loss>(reading.value)) return {};  // an earlier fault took it
  const Fault& fault = active.fault;
  const bool on = ++active.readings >= fault.from_reading && reading.captured_at >= fault.from &&
                  (!fault.until || reading.captured_at < *fault.until);
  // Drawn for every reading, so that a fault's time moves no other reading's fate.
  const bool dropped =
      fault.kind == FaultKind::kDropped && active.chance.Uniform(0.0, 1.0) < fault.amount;
  if (fault.kind == FaultKind::kFrozen && (!on || !active.last)) active.last = reading;
  if (!on) return {};
  switch (fault.kind) {
    case FaultKind::kFrozen:
      reading.value = active.last->value;
      break;
    case FaultKind::kDropped:
      if (dropped) reading.value = Loss{fault.sensor, 1, false};
      break;
    case FaultKind::kDead:
      reading.value = Loss{fault.sensor, 1, true};
      break;
    case FaultKind::kSaturated:
      Saturate(reading, description_);
      break;
    case FaultKind::kBiased:
      Bias(reading, fault.amount, description_);
      break;
    case FaultKind::kDelayed:
      return FromSeconds(fault.amount);
  }
  return {};
}

void Faulted::HandOverDelayed(RunTime now) {
  const auto due =
      std::stable_partition(delayed_.begin(), delayed_.end(),
                            [&](const Reading& held) { return held.arrived_at <= now; });
  std::stable_sort(delayed_.begin(), due,
                   [](const Reading& a, const Reading& b) { return a.arrived_at < b.arrived_at; });
  for (auto held = delayed_.begin(); held != due; ++held) {
    held->arrived_at = now;
    ready_.push_back(std::move(*held));
  }
  delayed_.erase(delayed_.begin(), due);
}

}  // namespace kantaro::robot
