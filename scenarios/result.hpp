#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/judge.hpp"

namespace kantaro::scenarios {

/// How long a run took.
struct Timing {
  double sim_s{};
  double wall_s{};
  [[nodiscard]] double RealTimeFactor() const { return wall_s > 0.0 ? sim_s / wall_s : 0.0; }
};

/// What `result.json` says.
struct Result {
  std::string scenario;
  std::uint64_t seed{};
  Verdict verdict;
  Timing timing;
  std::string trace_sha256;
};

/// {"scenario", "seed", "verdict": {"passed", "checks": [{"name", "passed", "value", "limit",
/// "unit", "text", "at_s", "place"}]}, "metrics": {}, "timing": {"sim_s", "wall_s",
/// "real_time_factor"}, "trace_sha256"}. Numbers that are not finite become null; at_s and place
/// are left out where there is none.
[[nodiscard]] nlohmann::ordered_json ToJson(const Result& result);

/// Files of a run folder by name, with their bytes.
using RunFiles = std::vector<std::pair<std::string, std::string>>;

/// Refuses a place that WriteRunFolder would refuse, before a long run begins.
/// @throws InputError if `folder` exists and is no run folder (holds no result.json) and is not
/// empty.
void CheckRunFolder(const std::filesystem::path& folder);

/// Writes a run folder as a whole: everything goes into a folder beside it, which then takes its
/// name. A run folder that already stands there is replaced. On failure nothing is left behind.
/// @throws InputError as CheckRunFolder, or if the place cannot be written.
void WriteRunFolder(const std::filesystem::path& folder, const RunFiles& files);

}  // namespace kantaro::scenarios
