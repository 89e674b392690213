#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "scenarios/body.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/mission_trace.hpp"
#include "scenarios/result.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

struct RunOptions {
  HardwareChoice hardware;  ///< the twin, or what a file names
  int render_threads{2};    ///< beside the physics; decides speed, never a result
  /// Told now and then how far the run is: simulated time and its limit [s]. May be empty.
  std::function<void(double sim_s, double limit_s)> progress;
  /// Makes another body than `hardware` names. May be empty.
  std::function<Body(const Scenario&, const Conditions&, const robot::Description&)> make_body;
  /// Where to record the run (robot::Recorder), if at all.
  std::optional<std::filesystem::path> recording;
};

/// A mission that was run and judged.
struct MissionRun {
  Scenario scenario;  ///< as driven: cut to the surroundings of its route
  Conditions conditions;
  MissionTrace trace;
  Result result;
  double laser_threshold_m{};  ///< of the robot's perception
};

/// Runs a mission: hardware, perception and executive in a loop until the robot stops, the time is
/// up, the hardware has nothing more to say or refuses every command for a second; then judges it,
/// from ground truth where that is known. On the twin: same scenario and seed, same trace.
/// @throws InputError for a bad robot folder or hardware file. @throws std::runtime_error where the
/// twin cannot run (no off-screen OpenGL).
[[nodiscard]] MissionRun RunMission(const Scenario& scenario, std::uint64_t seed,
                                    const RunOptions& options);

/// `result.json`, `report.html` and the camera frames, for WriteFolder.
[[nodiscard]] FolderFiles FilesOf(const MissionRun& run);

}  // namespace kantaro::scenarios
