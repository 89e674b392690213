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
/// manhole a side that was open on less than a fifth of the way on which it could be told was the
/// robot swaying: a branch of 200 mm, the narrowest to enter, opens 0.21 of the shaft of a 350 mm
/// pipe. A robot that leans into a branch may lose the other wall beyond the scanner's reach: a
/// window that opened then stays open, but nothing is seen there that speaks for a branch. What is
/// open for less than half the narrowest inlet is no landmark: where the wall is at the end of the
/// scanner's reach, a joint's groove lies beyond it.
class LaserPassage {
 public:
  /// Takes the next observation, with its edges, and how far the robot has travelled by then; a
  /// landmark when the last window has closed.
  [[nodiscard]] std::optional<PassedLandmark> Update(const LaserObservation& observation,
                                                     double travelled_m);

 private:
  struct Window {
    bool open{}, opened{};
    robot::RunTime from{}, to{};  ///< first opening, last closing
    double from_m{}, to_m{};      ///< the same, as travel
    double seen_m{}, open_m{};    ///< of the way: where it could be told, and was open
  };
  std::array<Window, 3> windows_{};  ///< by LaserWindow, of the landmark that is being passed
  std::optional<double> last_m_;     ///< travel at the last observation
};

}  // namespace kantaro::perception
