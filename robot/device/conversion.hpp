#pragma once

#include "robot/device/wire.hpp"
#include "robot/readings.hpp"

/// Between readings and the messages that carry them. A message keeps the time to 1 µs and each
/// value to half of its field's unit (docs/wire_protocol.md).
namespace kantaro::robot::wire {

/// What one count of an encoder is worth.
struct Scales {
  double encoder_step_rad{};            ///< of the wheels
  std::uint32_t mirror_counts{};        ///< to a turn of the laser's mirror, at most 65536
  double range_min_m{}, range_max_m{};  ///< of the laser: the ranges told of a beam that passed one
};

[[nodiscard]] WireTime ToWire(RunTime time);
/// How long before `sent_at` a reading was captured [µs]; 0 if it was not before.
[[nodiscard]] std::uint32_t Age(RunTime captured_at, RunTime sent_at);

/// The messages that carry a reading sent now: one, or of a laser's revolution one for each 48
/// samples; none for images and losses, which no line carries.
/// @param revolution  number of this laser revolution.
[[nodiscard]] std::vector<Message> ToMessages(const Reading& reading, RunTime sent_at,
                                              const Scales& scales, std::uint32_t revolution);

/// What a message measured; absent if it is no reading, or a part of a laser's revolution.
[[nodiscard]] std::optional<decltype(Reading::value)> ToValue(const Message& message,
                                                              const Scales& scales);
/// Age of a reading or trigger; absent for other messages.
[[nodiscard]] std::optional<RunTime> AgeOf(const Message& message);

[[nodiscard]] LaserSample ToSample(const wire::Laser::Sample& sample, const Scales& scales);

[[nodiscard]] wire::Command ToMessage(const robot::Command& command);
[[nodiscard]] robot::Command ToCommand(const wire::Command& command);

}  // namespace kantaro::robot::wire
