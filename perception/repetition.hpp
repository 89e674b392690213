#pragma once

#include <array>
#include <optional>

#include "robot/readings.hpp"

namespace kantaro::perception {

/// Tells a sensor that says the same again and again. Cameras, laser, IR, inertial unit and
/// inclinometer are noisy: from them two equal readings in a row are rare, and many mean that the
/// sensor hangs. Encoders of a standing robot, a battery and a compass may well repeat themselves.
class Repetition {
 public:
  /// @throws std::invalid_argument if readings < 2
  explicit Repetition(int readings);

  /// Takes the next reading of any sensor. @returns whether its sensor has said this, to the bit,
  /// as many times in a row.
  [[nodiscard]] bool IsStuck(const robot::Reading& reading);

 private:
  struct Said {
    std::optional<robot::Reading> last;
    int times{};
  };
  int readings_;
  std::array<Said, robot::kSensorCount> said_;
};

}  // namespace kantaro::perception
