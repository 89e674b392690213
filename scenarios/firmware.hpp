#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>

namespace kantaro::scenarios {

struct FirmwareRequest {
  std::filesystem::path scenario;
  std::uint64_t seed{1};
  std::optional<std::filesystem::path> out;  ///< folder of the lines, cameras and device.yaml
  std::optional<std::filesystem::path> controller, laser;  ///< where else their lines are linked
  bool lockstep{};  ///< time goes on as the host says; else with the clock on the wall
  double noise{};   ///< share of frames lost, as many doubled, as many corrupted
  std::optional<double> cut_controller_s, cut_laser_s, cut_front_s;  ///< cables pulled then
  bool json{};
};

/// Puts the twin behind the robot's own protocol (robot::Emulator) for one session, and says in the
/// end where it truly stands. Returns the exit code.
int PlayFirmware(const FirmwareRequest& request, std::ostream& out);

}  // namespace kantaro::scenarios
