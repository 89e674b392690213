#include "robot/device/conversion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "robot/mirror_angle.hpp"

namespace kantaro::robot::wire {
namespace {

constexpr double kMicro = 1e6;
constexpr double kMilli = 1e3;
constexpr double kShares = 65535.0;      // of 0 to 1 in 16 bits
constexpr double kRangesPerMetre = 1e5;  // 10 µm

wire::Laser::Sample ToSample(const LaserSample& sample, const Scales& scales) {
  const auto range =
      sample.status == RangeStatus::kTooFar ? wire::Laser::kTooFar
      : sample.status == RangeStatus::kTooNear
          ? wire::Laser::kTooNear
          : std::min<std::uint16_t>(Fixed<std::uint16_t>(sample.range_m, kRangesPerMetre),
                                    wire::Laser::kTooNear - 1);
  const std::uint32_t mirror = MirrorCount(sample.angle_rad, scales.mirror_counts);
  return {static_cast<std::uint16_t>(mirror), range};
}

std::vector<Message> Parts(const LaserRevolution& revolution, std::uint32_t age_us,
                           const Scales& scales, std::uint32_t number) {
  std::vector<Message> parts;
  const auto& samples = revolution.samples;
  for (std::size_t first = 0; first < samples.size(); first += wire::Laser::kMostSamples) {
    const std::size_t end = std::min(samples.size(), first + wire::Laser::kMostSamples);
    wire::Laser part{{age_us},
                     number,
                     static_cast<std::uint16_t>(first),
                     static_cast<std::uint16_t>(samples.size()),
                     {}};
    for (std::size_t i = first; i < end; ++i) part.samples.push_back(ToSample(samples[i], scales));
    parts.emplace_back(std::move(part));
  }
  return parts;
}

}  // namespace

WireTime ToWire(RunTime time) { return std::chrono::round<WireTime>(time); }

std::uint32_t Age(RunTime captured_at, RunTime sent_at) {
  const auto age = (ToWire(sent_at) - ToWire(captured_at)).count();
  return static_cast<std::uint32_t>(
      std::clamp<std::int64_t>(age, 0, std::numeric_limits<std::uint32_t>::max()));
}

std::vector<Message> ToMessages(const Reading& reading, RunTime sent_at, const Scales& scales,
                                std::uint32_t revolution) {
  const std::uint32_t age_us = Age(reading.captured_at, sent_at);
  return std::visit(
      [&](const auto& value) -> std::vector<Message> {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, LaserRevolution>) {
          return Parts(value, age_us, scales, revolution);
        } else if constexpr (std::is_same_v<Value, WheelEncoders>) {
          Encoders encoders{{age_us}, {}};
          for (std::size_t i = 0; i < 4; ++i) {
            encoders.counts[i] =
                Fixed<std::int32_t>(value.angle_rad[i], 1.0 / scales.encoder_step_rad);
          }
          return {encoders};
        } else if constexpr (std::is_same_v<Value, IrRanges>) {
          return {Infrared{{age_us},
                           {Fixed<std::uint16_t>(value.up.value, kShares),
                            Fixed<std::uint16_t>(value.left.value, kShares),
                            Fixed<std::uint16_t>(value.right.value, kShares)}}};
        } else if constexpr (std::is_same_v<Value, InertialReading>) {
          Inertial inertial{{age_us}, {}, {}};
          for (int i = 0; i < 3; ++i) {
            inertial.angular_velocity_urad_s[i] =
                Fixed<std::int32_t>(value.angular_velocity_rad_s[i], kMicro);
            inertial.specific_force_um_s2[i] =
                Fixed<std::int32_t>(value.specific_force_m_s2[i], kMicro);
          }
          return {inertial};
        } else if constexpr (std::is_same_v<Value, robot::Inclination>) {
          return {wire::Inclination{{age_us},
                                    Fixed<std::int32_t>(value.roll_rad, kMicro),
                                    Fixed<std::int32_t>(value.pitch_rad, kMicro)}};
        } else if constexpr (std::is_same_v<Value, CompassHeading>) {
          return {
              Compass{{age_us}, Fixed<std::uint32_t>(value.heading_rad, kMicro), value.disturbed}};
        } else if constexpr (std::is_same_v<Value, BatteryState>) {
          return {Battery{{age_us},
                          Fixed<std::uint32_t>(value.voltage_V, kMilli),
                          Fixed<std::int32_t>(value.current_A, kMilli),
                          Fixed<std::uint32_t>(value.charge, kMicro)}};
        } else {
          return {};
        }
      },
      reading.value);
}

std::optional<decltype(Reading::value)> ToValue(const Message& message, const Scales& scales) {
  using Value = std::optional<decltype(Reading::value)>;
  return std::visit(
      [&](const auto& m) -> Value {
        using M = std::decay_t<decltype(m)>;
        if constexpr (std::is_same_v<M, Encoders>) {
          WheelEncoders encoders;
          for (std::size_t i = 0; i < 4; ++i) {
            encoders.angle_rad[i] = m.counts[i] * scales.encoder_step_rad;
          }
          return encoders;
        } else if constexpr (std::is_same_v<M, Infrared>) {
          return IrRanges{
              {m.values[0] / kShares}, {m.values[1] / kShares}, {m.values[2] / kShares}};
        } else if constexpr (std::is_same_v<M, Inertial>) {
          InertialReading inertial;
          for (int i = 0; i < 3; ++i) {
            inertial.angular_velocity_rad_s[i] = m.angular_velocity_urad_s[i] / kMicro;
            inertial.specific_force_m_s2[i] = m.specific_force_um_s2[i] / kMicro;
          }
          return inertial;
        } else if constexpr (std::is_same_v<M, wire::Inclination>) {
          return robot::Inclination{m.roll_urad / kMicro, m.pitch_urad / kMicro};
        } else if constexpr (std::is_same_v<M, Compass>) {
          const double heading_rad = m.heading_urad / kMicro;
          return CompassHeading{heading_rad < kFullTurn_rad ? heading_rad : 0.0, m.disturbed};
        } else if constexpr (std::is_same_v<M, Battery>) {
          return BatteryState{m.voltage_mV / kMilli, m.current_mA / kMilli, m.charge_ppm / kMicro};
        } else {
          return std::nullopt;
        }
      },
      message);
}

std::optional<RunTime> AgeOf(const Message& message) {
  return std::visit(
      [](const auto& m) -> std::optional<RunTime> {
        if constexpr (std::is_base_of_v<Aged, std::decay_t<decltype(m)>>) {
          return std::chrono::microseconds(m.age_us);
        } else {
          return std::nullopt;
        }
      },
      message);
}

LaserSample ToSample(const wire::Laser::Sample& sample, const Scales& scales) {
  const double angle_rad = MirrorAngle(sample.mirror, scales.mirror_counts);
  switch (sample.range) {
    case wire::Laser::kTooFar:
      return {angle_rad, scales.range_max_m, RangeStatus::kTooFar};
    case wire::Laser::kTooNear:
      return {angle_rad, scales.range_min_m, RangeStatus::kTooNear};
    default:
      return {angle_rad, sample.range / kRangesPerMetre, RangeStatus::kValid};
  }
}

wire::Command ToMessage(const robot::Command& command) {
  return {Fixed<std::int32_t>(command.left_rad_s, kMicro),
          Fixed<std::int32_t>(command.right_rad_s, kMicro),
          Fixed<std::uint16_t>(command.lights, kShares)};
}

robot::Command ToCommand(const wire::Command& command) {
  return {command.left_urad_s / kMicro, command.right_urad_s / kMicro, command.lights / kShares};
}

}  // namespace kantaro::robot::wire
