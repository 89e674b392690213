#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <variant>
#include <vector>

namespace kantaro::robot {

/// Time since the run began: simulated time in the twin, monotonic time on the robot.
using RunTime = std::chrono::nanoseconds;

/// Seconds as a number, for arithmetic.
[[nodiscard]] inline double Seconds(RunTime time) {
  return std::chrono::duration<double>(time).count();
}

enum class RangeStatus { kValid, kTooNear, kTooFar };

/// The front CCD camera (thesis 4.4): 8-bit BGR, 704 x 480.
struct FrontImage {
  cv::Mat image;
};

/// The stereo cameras (thesis 5.6): 8-bit BGR, 640 x 480 each, one exposure.
struct StereoPair {
  cv::Mat left, right;
};

/// One beam of the laser scanner.
struct LaserSample {
  /// Angle about +Lx [rad], 0 <= a < 2π: 0 to the right (−Ly), π/2 up (+Lz), π to the left. The
  /// rotation starts from the horizontal line and runs counterclockwise, seen from behind the robot
  /// (thesis fig 5.26).
  double angle_rad{};
  double range_m{};  ///< along the beam; the limit that was passed if not valid
  RangeStatus status{RangeStatus::kTooFar};
};

/// One turn of the laser's mirror (thesis 5.2), in the order of measurement.
struct LaserRevolution {
  std::vector<LaserSample> samples;
};

/// One IR reading. The beam starts at the sensor origin So and runs along +Sx.
struct IrReading {
  double value{};  ///< the sensor's own output, 0 to 1, falling with distance; thresholds apply to
                   ///< it (thesis 4.3)
};

/// The three IR sensors, read together (thesis fig 4.6).
struct IrRanges {
  IrReading up, left, right;
};

/// Encoder angles since power-on [rad], positive rolling forward.
struct WheelEncoders {
  std::array<double, 4> angle_rad{};  ///< front left, front right, rear left, rear right
};

/// Gyro and accelerometer in the base frame B.
struct InertialReading {
  Eigen::Vector3d angular_velocity_rad_s{Eigen::Vector3d::Zero()};
  Eigen::Vector3d specific_force_m_s2{Eigen::Vector3d::Zero()};
};

/// How the base lies against gravity. A pendulum: wrong while the robot accelerates.
struct Inclination {
  double roll_rad{};   ///< about Bx, positive if the left side is high
  double pitch_rad{};  ///< about By, positive if the nose is low
};

/// Horizontal heading.
struct CompassHeading {
  double heading_rad{};  ///< of Bx from magnetic north, clockwise from above, 0 <= h < 2π
  bool disturbed{};      ///< the field is not the earth's: iron is near, or a motor
};

/// The pack that everything on board draws from.
struct BatteryState {
  double voltage_V{};
  double current_A{};  ///< drawn, positive
  double charge{};     ///< left, 0 to 1
};

/// What readings come from.
enum class Sensor : std::uint8_t {
  kFrontCamera,
  kStereoCameras,
  kLaser,
  kInfrared,
  kEncoders,
  kInertial,
  kInclinometer,
  kCompass,
  kBattery
};
inline constexpr std::size_t kSensorCount = 9;

/// Readings that were due and did not come, told by the hardware layer itself. Captured when the
/// first of them should have been.
struct Loss {
  Sensor sensor{};
  std::uint32_t readings{};  ///< lost since the last good reading or the last Loss of this sensor
  bool line_down{};          ///< nothing at all comes from there any more
};

/// What the hardware hands over.
struct Reading {
  RunTime captured_at{};  ///< when the light or the angle was measured (a laser revolution: its
                          ///< last beam)
  RunTime arrived_at{};   ///< when it was handed over, captured_at + latency
  std::variant<FrontImage, StereoPair, LaserRevolution, IrRanges, WheelEncoders, InertialReading,
               Inclination, CompassHeading, BatteryState, Loss>
      value;
};

/// Where a reading came from, or failed to come from.
[[nodiscard]] Sensor SensorOf(const Reading& reading);
/// "front_camera", "stereo_cameras", "laser", "infrared", "encoders", "inertial", "inclinometer",
/// "compass", "battery".
[[nodiscard]] const char* ToString(Sensor sensor);

/// What the robot is told to do; holds until the next command.
struct Command {
  double left_rad_s{};  ///< speed of both left wheels, positive forward
  double right_rad_s{};
  double lights{1.0};  ///< LED brightness, 0 to 1
};

/// @throws std::invalid_argument for a speed that is not finite, or lights outside 0 to 1.
void CheckCommand(const Command& command);

}  // namespace kantaro::robot
