#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "robot/device/frame.hpp"
#include "robot/hardware.hpp"

/// What the frames say. Numbers travel as little-endian fixed point; a value outside its field's
/// range travels as the nearest that fits. Round trips lose at most half a unit of each field.
namespace kantaro::robot::wire {

enum class Type : Byte {
  kHello = kHelloType,
  kEncoders = 0x02,
  kInfrared = 0x03,
  kInertial = 0x04,
  kInclination = 0x05,
  kCompass = 0x06,
  kBattery = 0x07,
  kTrigger = 0x08,
  kStatus = 0x09,
  kAck = 0x0A,
  kPace = 0x0B,
  kLaser = 0x10,
  kOpen = kOpenType,
  kCommand = 0x82,
  kStop = 0x83,
  kPaceAck = 0x84
};

/// "The host is here: begin." Sent until Hello answers.
struct Open {
  std::uint32_t session{};  ///< another number than the session before: all counting begins anew

  bool operator==(const Open&) const = default;
};

/// Who answers, and what it sends.
struct Hello {
  struct Stream {
    Sensor sensor{};
    std::uint32_t period_us{};  ///< of its readings; of a camera: of its triggers

    bool operator==(const Stream&) const = default;
  };
  std::uint32_t session{};  ///< of the Open that is answered
  bool lockstep{};          ///< time goes on only as the host says (Pace, PaceAck)
  std::uint16_t watchdog_ms{};
  std::uint32_t encoder_step_nrad{};   ///< one count of the wheels' encoders; 0 if it has none
  std::uint32_t speed_limit_urad_s{};  ///< of the wheels; 0 if it drives none
  std::uint32_t mirror_counts{};       ///< to one turn of the laser's mirror; 0 if it has none
  std::vector<Stream> streams;
  std::string robot;  ///< its name, at most 32 bytes

  bool operator==(const Hello&) const = default;
};

/// How long before the frame's time a reading was captured [µs].
struct Aged {
  std::uint32_t age_us{};

  bool operator==(const Aged&) const = default;
};
struct Encoders : Aged {
  std::array<std::int32_t, 4> counts{};  ///< front left, front right, rear left, rear right

  bool operator==(const Encoders&) const = default;
};
struct Infrared : Aged {
  std::array<std::uint16_t, 3> values{};  ///< up, left, right [1/65535]

  bool operator==(const Infrared&) const = default;
};
struct Inertial : Aged {
  std::array<std::int32_t, 3> angular_velocity_urad_s{};
  std::array<std::int32_t, 3> specific_force_um_s2{};

  bool operator==(const Inertial&) const = default;
};
struct Inclination : Aged {
  std::int32_t roll_urad{}, pitch_urad{};

  bool operator==(const Inclination&) const = default;
};
struct Compass : Aged {
  std::uint32_t heading_urad{};
  bool disturbed{};

  bool operator==(const Compass&) const = default;
};
struct Battery : Aged {
  std::uint32_t voltage_mV{};
  std::int32_t current_mA{};
  std::uint32_t charge_ppm{};

  bool operator==(const Battery&) const = default;
};

/// The controller told a camera to expose.
struct Trigger : Aged {
  Sensor camera{};        ///< kFrontCamera, or kStereoCameras for both at once
  std::uint32_t frame{};  ///< counts this camera's triggers from 1

  bool operator==(const Trigger&) const = default;
};

/// How the controller is, ten times a second and at once when it changes.
struct Status {
  bool watchdog_tripped{};  ///< no command for the watchdog's time: zero speed until the next
  bool stopped{};           ///< by Stop or the robot's own emergency stop: for good
  bool motor_fault{};
  std::uint32_t corrupt{};  ///< frames from the host that came broken
  std::uint32_t lost{};     ///< frames from the host that never came

  bool operator==(const Status&) const = default;
};

/// A Command or Stop came, and this became of it.
struct Ack {
  Type type{};
  std::uint16_t sequence{};
  CommandOutcome outcome{};

  bool operator==(const Ack&) const = default;
};

/// Lockstep: all that happened up to the frame's time has been sent on this line.
struct Pace {
  std::uint32_t step{};                          ///< counts from 1, on both lines alike
  std::uint32_t front_images{}, stereo_pairs{};  ///< handed to the cameras' streams so far

  bool operator==(const Pace&) const = default;
};
/// Lockstep: the host is done with all up to this step, so the next may happen.
struct PaceAck {
  std::uint32_t step{};

  bool operator==(const PaceAck&) const = default;
};

/// Part of one turn of the laser's mirror.
struct Laser : Aged {  ///< age: of its last sample
  struct Sample {
    std::uint16_t mirror{};  ///< the mirror's encoder, 0 to the right
    std::uint16_t range{};   ///< [10 µm], or one of the two below

    bool operator==(const Sample&) const = default;
  };
  static constexpr std::uint16_t kTooNear = 0xFFFE, kTooFar = 0xFFFF;
  static constexpr std::size_t kMostSamples = 48;

  std::uint32_t revolution{};   ///< counts from 1
  std::uint16_t first{};        ///< position of the first sample in the revolution
  std::uint16_t of{};           ///< samples in the whole revolution
  std::vector<Sample> samples;  ///< at most kMostSamples

  bool operator==(const Laser&) const = default;
};

struct Command {
  std::int32_t left_urad_s{}, right_urad_s{};
  std::uint16_t lights{};  ///< [1/65535]

  bool operator==(const Command&) const = default;
};
struct Stop {
  bool operator==(const Stop&) const = default;
};

using Message = std::variant<Open, Hello, Encoders, Infrared, Inertial, Inclination, Compass,
                             Battery, Trigger, Status, Ack, Pace, PaceAck, Laser, Command, Stop>;

[[nodiscard]] Type TypeOf(const Message& message);
[[nodiscard]] Bytes Payload(const Message& message);
/// Absent for an unknown type, a payload of another length, or a value that its field cannot have.
[[nodiscard]] std::optional<Message> Parse(const Frame& frame);

/// A number in fixed point, `units` to one, rounded to the nearest and held to the type's range; no
/// number becomes the lowest.
template <typename Integer>
[[nodiscard]] Integer Fixed(double value, double units);

}  // namespace kantaro::robot::wire
