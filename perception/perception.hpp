#pragma once

#include <optional>
#include <vector>

#include "perception/attitude.hpp"
#include "perception/ir_landmarks.hpp"
#include "perception/laser_landmarks.hpp"
#include "perception/observations.hpp"
#include "perception/odometry.hpp"
#include "perception/parameters.hpp"
#include "perception/pipe_slice.hpp"
#include "perception/repetition.hpp"
#include "perception/ring_finder.hpp"
#include "robot/description.hpp"
#include "robot/readings.hpp"
#include "robot/rectifier.hpp"

namespace kantaro::perception {

/// Turns readings into observations. State is the debouncing of laser and IR, what each sensor said
/// last, and the pipe's diameter.
class Perception {
 public:
  /// @throws std::invalid_argument if the description lacks what odometry needs.
  Perception(robot::Description description, Parameters parameters);

  /// Inner diameter of the pipe that the robot is believed to be in: the scale of all that the
  /// camera says.
  /// @throws std::invalid_argument unless above 0.
  void SetPipeDiameter(double diameter_m);

  /// One reading, in the order of arrival. Gives
  /// - FrontImage, rectified first: a RingObservation and a FaultObservation, empty if nothing is
  /// seen; nothing before
  ///   SetPipeDiameter, for a circle has no distance then;
  /// - LaserRevolution: a LaserObservation with the edges it settled; nothing if a window holds no
  /// sample;
  /// - IrRanges: an IrObservation; WheelEncoders: an OdometryObservation; InertialReading: a
  /// AttitudeObservation;
  /// - Inclination, BatteryState: an observation of the same name; CompassHeading: nothing, for
  /// there is iron under every street;
  /// - Loss, and in place of the above a reading that hangs, a gyro at the end of its scale or a
  /// laser to which nothing returns, not even the floor: a LossObservation;
  /// - StereoPair: nothing. Localisation here is by the front camera (thesis chapter 4), not by
  /// stereo (chapter 5).
  /// @throws std::invalid_argument for a front image of another type or size than the camera's, or
  /// a number that
  ///         is not finite.
  [[nodiscard]] std::vector<Observation> Process(const robot::Reading& reading);

 private:
  /// Absent if the reading can be believed.
  [[nodiscard]] std::optional<LossObservation> Distrust(const robot::Reading& reading);
  [[nodiscard]] std::vector<Observation> Look(const robot::FrontImage& front,
                                              robot::RunTime captured_at) const;
  [[nodiscard]] std::vector<Observation> Scan(const robot::LaserRevolution& revolution,
                                              robot::RunTime captured_at);

  robot::Camera camera_;
  robot::Rectifier rectifier_;
  double gyro_range_rad_s_;
  Parameters parameters_;
  Odometry odometry_;
  AttitudeFilter attitude_;
  PipeSliceTracker wall_;
  LaserTracker laser_;
  IrLandmarks ir_;
  Repetition repetition_;
  std::optional<double> pipe_diameter_m_;
  std::optional<RingFinder> rings_;  ///< for this diameter
};

}  // namespace kantaro::perception
