#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "base/input_error.hpp"
#include "robot/device/camera.hpp"
#include "robot/device/host.hpp"

namespace kantaro::robot {

/// Where the robot's lines and cameras are on this computer: docs/device.md.
struct DeviceConfig {
  struct SerialLine {
    std::filesystem::path device;
    int bits_per_s{};
    int config_line{};  ///< where it stands in the file
  };
  struct Camera {
    CameraSource source;
    StampClock stamps{};
    int config_line{};
  };
  std::filesystem::path file;
  SerialLine controller;
  std::optional<SerialLine> laser;
  std::array<std::optional<Camera>, kCameraPorts> cameras;  ///< by CameraPort
  std::map<Sensor, RunTime> patience;
  RunTime line_patience{std::chrono::milliseconds(500)};
  RunTime answer_within{std::chrono::seconds(20)};

  [[nodiscard]] InputError ErrorAt(int line, const std::string& field,
                                   const std::string& problem) const {
    return {file, line, field, problem};
  }
};

/// Paths are relative to the file. @throws InputError
[[nodiscard]] DeviceConfig ReadDeviceConfig(const std::filesystem::path& file);
[[nodiscard]] DeviceConfig ParseDeviceConfig(const std::string& text,
                                             const std::filesystem::path& name);

/// "front", "stereo_left", "stereo_right".
[[nodiscard]] const char* ToString(CameraPort camera);

}  // namespace kantaro::robot
