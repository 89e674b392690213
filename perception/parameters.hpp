#pragma once

#include <filesystem>
#include <string>

#include "perception/fault_detector.hpp"
#include "perception/ir_landmarks.hpp"
#include "perception/landmark_parameters.hpp"
#include "perception/laser_landmarks.hpp"
#include "perception/ring_finder.hpp"
#include "perception/stereo/stereo.hpp"

namespace kantaro::perception {

/// Every threshold of this room. The members' defaults serve tests; twin and robot alike read the
/// file.
struct Parameters {
  LaserParameters laser;
  IrParameters ir;
  RingParameters rings;
  FaultParameters faults;
  stereo::Parameters stereo;
  LandmarkParameters landmarks;  ///< without their calibration, which is in landmarks.yaml
  int stuck_readings{8};         ///< so many equal ones in a row: the sensor hangs (Repetition)
};

/// Reads `perception.yaml`. Every key must be there and no other.
/// @throws InputError
[[nodiscard]] Parameters ReadParameters(const std::filesystem::path& file);
/// The same from text; complaints name `name` as the file.
[[nodiscard]] Parameters ParseParameters(const std::string& text,
                                         const std::filesystem::path& name);

}  // namespace kantaro::perception
