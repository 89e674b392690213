#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/random.hpp"
#include "robot/readings.hpp"
#include "robot/sensor_parameters.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {

/// The magnetic field under the street, the same in every run. W: x east, y north, z up.
///
/// To the earth's comes that of iron: the cast covers of manholes, as upright dipoles, and the
/// reinforcement of concrete pipes, each length of which keeps a magnetisation of its own from the
/// day it was made.
class MagneticField {
 public:
  /// @param sewer  must outlive the field.
  MagneticField(const Sewer& sewer, const robot::Compass& compass);

  /// @param pipe, chainage_m  where the point lies, if in a pipe. @returns [T] in W
  [[nodiscard]] Eigen::Vector3d At(const Eigen::Vector3d& p_W, std::optional<std::size_t> pipe,
                                   double chainage_m) const;

  /// Of a cast-iron cover of 60 kg (600 mm, EN 124 D 400): 8.3 litres at 2.4 kA/m, what grey iron
  /// keeps [A m²]. Pointing down, as the earth's field does in the north.
  static constexpr double kCoverMoment_Am2 = 20.0;
  /// Field of the bars of a concrete pipe in its middle: a third of the earth's. Surveys over
  /// reinforced floors find 5 to 30 µT at such distances.
  static constexpr double kReinforcement_T = 15e-6;
  static constexpr double kLengthOfPipe_m = 2.0;  ///< from joint to joint

 private:
  const Sewer& sewer_;
  Eigen::Vector3d earth_W_;
};

/// The robot's compass.
class CompassSensor {
 public:
  CompassSensor(const robot::Compass& compass, std::uint64_t seed);

  /// @param field_T  in W. @param motor_current_A  drawn by the motors
  [[nodiscard]] robot::CompassHeading Measure(const Eigen::Matrix3d& R_WB,
                                              const Eigen::Vector3d& field_T,
                                              double motor_current_A);

 private:
  robot::Compass compass_;
  RandomStream noise_;
};

}  // namespace kantaro::sim
