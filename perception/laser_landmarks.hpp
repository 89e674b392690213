#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/observations.hpp"
#include "perception/pipe_slice.hpp"
#include "robot/readings.hpp"

namespace kantaro::perception {

/// How openings are told from wall.
enum class LaserMethod {
  kThesis,  ///< a window's median range against one threshold for every pipe (Table 5.3)
  kOurs     ///< each beam against the circle that the wall lies on (PipeSlice)
};

/// How a laser revolution is read (thesis 5.2, 5.5).
struct LaserParameters {
  LaserMethod method{LaserMethod::kThesis};
  double threshold_m{0.175};     ///< a window above it is open (Table 5.3)
  double window_rad{0.2617994};  ///< full width of each window, 15° (fig 5.3)
  double far_limit_m{0.190};     ///< reported where nothing returned (Table 5.1)
  int revolutions{3};            ///< a window has opened or closed after so many in a row
};

/// Type of landmark from the three windows (thesis Table 5.3). One combination is not in the table:
/// both sides open under a closed top. It is read as the inlet on the side that is open farther,
/// the left one on a tie: an inlet makes the robot do nothing, where a junction or "outside" would
/// make it act on a wall that is still overhead.
[[nodiscard]] LaserStatus ClassifyWindows(bool top_open, bool left_open, bool right_open,
                                          double left_m, double right_m);

/// Reads one revolution: the median range of each window, centred on 0 (right), π/2 (top) and π
/// (left). A beam that returned too far counts as infinitely far, one too near as 0. Independent of
/// the samples' order.
///
/// kOurs decides afresh what is open, where the wall's circle is known: a beam is open if it goes
/// on beyond the circle, and says nothing if the circle may be out of reach there. So pipes of any
/// size are read, off their axis too; where most of a window says nothing, it is not known. A side
/// is open if half of a window says so that is centred within 20° of it: the robot may be rolled,
/// and an inlet not at 3 or 9 o'clock. The top is open if four fifths say so over the 110° that a
/// manhole opens at least: an inlet at the crown opens less.
/// @param wall  for kOurs
/// @returns nothing if a window holds no sample: a revolution with a gap there says nothing about
/// landmarks.
[[nodiscard]] std::optional<LaserObservation> ReadWindows(
    const robot::LaserRevolution& revolution, robot::RunTime captured_at,
    const LaserParameters& parameters, const std::optional<PipeSlice>& wall = {});

/// Tells a landmark from a stray beam: a window has opened or closed once `revolutions`
/// observations in a row say so, those apart that could not tell. Starts with all windows closed.
class LaserTracker {
 public:
  /// @param turn  of the mirror: edges are dated to the middle of the time in which they can have
  /// passed, from one look through the window to the next. 0: to the revolution that showed them.
  /// @throws std::invalid_argument if revolutions < 1.
  explicit LaserTracker(int revolutions, robot::RunTime turn = {});

  /// Takes the next observation; returns the windows whose state it settled, right, top, left.
  [[nodiscard]] std::vector<WindowEdge> Update(const LaserObservation& observation);

  [[nodiscard]] bool IsOpen(LaserWindow window) const;

 private:
  struct Window {
    bool open{};
    int run{};               ///< observations in a row that disagree with `open`
    robot::RunTime since{};  ///< the first of them
  };
  int revolutions_;
  robot::RunTime turn_;
  std::array<Window, 3> windows_;  ///< by LaserWindow
};

}  // namespace kantaro::perception
