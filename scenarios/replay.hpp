#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/runner.hpp"

namespace kantaro::scenarios {

/// How many of what was recorded came out the same, to the bit.
struct Equality {
  std::uint64_t equal{}, of{};
  [[nodiscard]] bool all() const { return equal == of; }
};

/// Where a replay first left its recording.
struct Divergence {
  double time_s{};
  std::string what;  ///< one sentence without a full stop
};

/// What became of a recording's readings when the robot's program took them again.
struct ReplayResult {
  std::string program;  ///< that recorded it
  std::string robot;    ///< "the recording's own", or the folder that was given
  std::uint64_t readings{};
  Equality estimates, commands, events;
  std::optional<Divergence> first;
  /// Largest differences of the estimate while both believed in the same leg.
  double distance_m{}, distance_at_s{}, deviation_m{};
  std::uint64_t on_another_leg{};  ///< estimates
  /// Events of one side only, "12.34 s landmark: inlet to the left".
  std::vector<std::string> only_recorded, only_replayed;
  std::string recorded_sha256;  ///< of the trace as it was recorded: the run's own
  MissionRun run;               ///< as replayed, judged without ground truth

  /// To the bit: every estimate, command and event.
  [[nodiscard]] bool same() const { return estimates.all() && commands.all() && events.all(); }
};

/// Plays a recording back to perception and navigation.
/// @param robot_folder  whose description and parameters are to be used; absent: the recording's
/// own.
/// @throws InputError for a bad recording or folder.
[[nodiscard]] ReplayResult ReplayRecording(
    const std::filesystem::path& recording,
    const std::optional<std::filesystem::path>& robot_folder);

[[nodiscard]] nlohmann::ordered_json ToJson(const ReplayResult& result);
/// For a terminal, several lines.
[[nodiscard]] std::string ToText(const ReplayResult& result);

}  // namespace kantaro::scenarios
