#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace kantaro::scenarios {

/// One mission of a suite.
struct SuiteCase {
  std::string scenario;  ///< name
  std::filesystem::path file;
  std::uint64_t seed{};
  std::filesystem::path run_folder;
};

/// How a mission of a suite ended.
struct CaseResult {
  SuiteCase mission;
  enum class Outcome { kPassed, kFailed, kCrashed } outcome{Outcome::kCrashed};
  std::string message;  ///< why it failed or crashed, one line; empty if it passed
  std::vector<std::string> failed_checks;  ///< names
  std::map<std::string, double> metrics;
  double sim_s{}, wall_s{};
  std::string trace_sha256;
};

struct SuiteOptions {
  std::vector<std::filesystem::path>
      paths;               ///< scenario files, or folders of them (*.yaml, not deeper)
  std::uint64_t seeds{1};  ///< seeds 1 … K
  unsigned jobs{1};
  std::filesystem::path out;
  /// The program that runs one mission: `PROGRAM run FILE --seed N --out DIR --json [extra …]`.
  std::filesystem::path program;
  std::vector<std::string> extra;  ///< arguments handed on, e.g. --blind laser
};

/// Scenario files named by the paths, each read and checked, times the seeds, in the order given.
/// @throws InputError for a bad or missing scenario, a folder without one, or two files of one
/// scenario name.
[[nodiscard]] std::vector<SuiteCase> ListCases(const SuiteOptions& options);

/// Runs every mission in a process of its own, so that one that crashes is one failed case (and
/// because MuJoCo's collision table belongs to a whole process).
/// @param tell  called after each case, in the order in which they end.
/// @returns results in the order of the cases, whatever the order of ending.
using TellCase = std::function<void(const CaseResult& result, std::size_t done, std::size_t all)>;
[[nodiscard]] std::vector<CaseResult> RunCases(const std::vector<SuiteCase>& cases,
                                               const SuiteOptions& options, const TellCase& tell);

/// What changed from a baseline to now, mission by mission.
struct Comparison {
  struct Change {
    std::string scenario;
    std::uint64_t seed{};
    std::string text;  ///< what changed and where, one line
  };
  std::vector<Change> worse, better;
  std::size_t unchanged{};         ///< in verdict and, where given, within the metrics' tolerance
  std::size_t added{}, removed{};  ///< missions that only one of the two has
};

/// Worse: passed before and not now, or a metric of goodness (position error, duration, false
/// alarms …) grew by more than a tenth and by more than its noise. @param baseline  a suite.json.
/// @throws InputError (file `name`) if it is none.
[[nodiscard]] Comparison CompareWithBaseline(const std::vector<CaseResult>& results,
                                             const std::string& baseline,
                                             const std::filesystem::path& name);

/// {"passed", "missions", "passed_missions", "scenarios": [{"scenario", "missions", "passed"}],
/// "cases": [{"scenario", "file", "seed", "outcome", "message", "failed_checks", "metrics",
/// "timing", "trace_sha256", "run_folder"}], "comparison": {"worse", "better", "unchanged",
/// "added", "removed"}}; the last only with a baseline. Run folders are relative to `out`.
[[nodiscard]] nlohmann::ordered_json SuiteJson(const std::vector<CaseResult>& results,
                                               const Comparison* comparison,
                                               const std::filesystem::path& out);

/// JUnit XML as CI servers read it: a suite for each scenario, a case for each seed.
[[nodiscard]] std::string JunitXml(const std::vector<CaseResult>& results);

/// The same for a browser, self-contained: a table of the missions, those that did not pass first,
/// each with a link to its report. @param out  folder that the page will lie in.
[[nodiscard]] std::string SuiteHtml(const std::vector<CaseResult>& results,
                                    const Comparison* comparison, const std::filesystem::path& out);

/// A table for a terminal: a line for each scenario, then every mission that did not pass, then the
/// comparison.
[[nodiscard]] std::string SuiteTable(const std::vector<CaseResult>& results,
                                     const Comparison* comparison);

[[nodiscard]] bool AllPassed(const std::vector<CaseResult>& results);

}  // namespace kantaro::scenarios
