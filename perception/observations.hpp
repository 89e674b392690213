#pragma once

#include <string>
#include <variant>
#include <vector>

#include "robot/readings.hpp"

namespace kantaro::perception {

/// Landmark type by the laser's three windows (thesis Table 5.3); the numbers are the table's.
enum class LaserStatus {
  kNoLandmark = 0,
  kManhole = 1,
  kInletLeft = 2,
  kInletRight = 3,
  kManholeWithJunction = 4,
  kOutsideThePipe = 5
};

/// The laser's scanning windows (thesis fig 5.3).
enum class LaserWindow { kRight, kTop, kLeft };

/// A window that opened or closed and stayed so for several revolutions.
struct WindowEdge {
  LaserWindow window{LaserWindow::kTop};
  bool open{};  ///< true: the wall ended here; false: it began again
  robot::RunTime
      at{};  ///< capture of the first revolution that showed it, not of the one that settled it
};

/// What one laser revolution says. A window is open if its distance exceeds the threshold (175 mm
/// in the thesis).
struct LaserObservation {
  robot::RunTime captured_at{};
  bool top_open{}, left_open{}, right_open{};
  /// Whether this revolution could tell: else the window stays as it was.
  bool top_known{true}, left_known{true}, right_known{true};
  double top_m{}, left_m{},
      right_m{};  ///< median range in each window; the far limit where nothing returned
  LaserStatus status{LaserStatus::kNoLandmark};
  std::vector<WindowEdge>
      edges;  ///< that this revolution settled; the fields above are not debounced
};

/// What the IR sensors say (thesis 4.3): a value below its threshold means that the wall is gone.
struct IrObservation {
  robot::RunTime captured_at{};
  bool manhole{};  ///< up
  bool junction_left{}, junction_right{};
};

enum class RingKind { kJoint, kManholeMouth };

/// A ring of the wall seen ahead by the front camera.
struct RingSighting {
  RingKind kind{RingKind::kJoint};
  double distance_m{};  ///< from the camera to the ring's plane
  double radius_px{};
  double support{};      ///< share of the circle that lies on edges, 0 to 1
  double center_x_px{};  ///< of the circle in the image, x to the right and y down
  double center_y_px{};
  double significance{};  ///< contrast of line or step over its standard error
};

/// All rings in one front image, nearest first.
struct RingObservation {
  robot::RunTime captured_at{};
  std::vector<RingSighting> rings;
};

/// A part of the wall that does not look like the rest (thesis 3.3).
struct FaultCandidate {
  double clock_h{};     ///< of its middle, as the camera sees it: 12 at the crown, 3 to the right
  double distance_m{};  ///< from the camera to the plane of the strip of lowest C(y)
  double horizontal_similarity{};  ///< C(x), eq. 3.3
  double vertical_similarity{};    ///< C(y), eq. 3.5
};

struct FaultObservation {
  robot::RunTime captured_at{};
  std::vector<FaultCandidate> candidates;
};

/// Encoders as travel: mean of all four wheels, and per side [m], since power-on, at the tyre's
/// nominal radius.
struct OdometryObservation {
  robot::RunTime captured_at{};
  double travel_m{}, left_m{}, right_m{};
};

/// How the robot lies and turns, from gyro and accelerometer.
struct AttitudeObservation {
  robot::RunTime captured_at{};
  double roll_rad{};  ///< about the base's x, positive if the left side is high
  double roll_rate_rad_s{};
  double yaw_rate_rad_s{};  ///< about the base's z, positive turning left
};

/// How the robot lies, from the inclinometer: wrong while it accelerates, and late.
struct InclinationObservation {
  robot::RunTime captured_at{};
  double roll_rad{}, pitch_rad{};  ///< as robot::Inclination
};

struct BatteryObservation {
  robot::RunTime captured_at{};
  double charge{}, voltage_V{};
};

/// A sensor did not say what it should have.
struct LossObservation {
  enum class Cause {
    kMissing,     ///< single readings are lost; the next may come
    kLineDown,    ///< nothing comes from there any more
    kStuck,       ///< it says the same to the bit again and again
    kImplausible  ///< it says what cannot be
  };
  robot::RunTime captured_at{};
  robot::Sensor sensor{};
  Cause cause{Cause::kMissing};
};

using Observation = std::variant<LaserObservation, IrObservation, RingObservation, FaultObservation,
                                 OdometryObservation, AttitudeObservation, InclinationObservation,
                                 BatteryObservation, LossObservation>;

}  // namespace kantaro::perception
