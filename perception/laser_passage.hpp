#pragma once

#include <array>
#include <optional>

#include "perception/observations.hpp"

namespace kantaro::perception {

/// A landmark that the laser has passed.
struct PassedLandmark {
  LaserStatus kind{LaserStatus::kManhole};
  robot::RunTime opened_at{}, closed_at{};  ///< its middle lies halfway in between, by odometry
};

/// Puts the edges of the three windows together: one landmark from the opening of the wall until
/// all of it is closed again, of the kind that Table 5.3 gives to all windows that opened between.
/// It lies from the opening to the closing of the top, if that opened, else of the side. In a
/// manhole a side that was open for less than an eighth of the top's time was the robot swaying: no
/// pipe narrower than 100 mm runs into a shaft of 0.8 m.
class LaserPassage {
 public:
  /// Takes the next observation, with its edges; a landmark when the last window has closed.
  [[nodiscard]] std::optional<PassedLandmark> Update(const LaserObservation& observation);

 private:
  struct Window {
    bool open{}, opened{};
    robot::RunTime from{}, to{};  ///< first opening, last closing
    robot::RunTime since{};       ///< of the opening that lasts
    robot::RunTime time{};        ///< open in all
  };
  std::array<Window, 3> windows_{};  ///< by LaserWindow, of the landmark that is being passed
};

}  // namespace kantaro::perception
