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
/// "real_time_factor"}, "trace_sha256"}. Numbers that are not finite become null, and so do passed
/// and value of a check that was not judged; at_s and place are left out where there is none.
[[nodiscard]] nlohmann::ordered_json ToJson(const Result& result);

/// Files of an output folder by name, with their bytes. The first is the folder's mark: only a
/// folder that holds a file of this name is taken for an earlier output and replaced.
using FolderFiles = std::vector<std::pair<std::string, std::string>>;
/// Files that exist already, by the name they take in the folder.
using MovedFiles = std::vector<std::pair<std::string, std::filesystem::path>>;

/// Refuses a place that WriteFolder would refuse, before long work begins.
/// @throws InputError if a file stands there, or a folder that is neither empty nor marked.
void CheckFolder(const std::filesystem::path& folder, const std::string& mark);

/// Writes a folder as a whole: everything, moved files last, goes into one beside it, which then
/// takes its name. On failure nothing is left behind. @throws InputError as CheckFolder, or if the
/// place cannot be written.
/// @throws std::invalid_argument without files.
void WriteFolder(const std::filesystem::path& folder, const FolderFiles& files,
                 const MovedFiles& moved = {});

}  // namespace kantaro::scenarios
