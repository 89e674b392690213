#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kantaro::scenarios {

/// What an experiment is told.
struct ExperimentOptions {
  std::filesystem::path robot_folder;  ///< holds kantaro.urdf and its companions
  std::uint64_t seed{1};
  std::size_t count{};  ///< random starts, images … of each row; 0: the experiment's own
  std::vector<std::string> only;        ///< cases to run; empty: all
  unsigned jobs{1};                     ///< threads; changes no result
  std::filesystem::path photos, scans;  ///< what is measured against, if an experiment does; may be
                                        ///< absent
  std::filesystem::path out;            ///< where pictures go; empty: none are made
  std::function<void(std::size_t done, std::size_t all)> progress{
      [](std::size_t, std::size_t) {}};  ///< called from one thread at a time
};

/// An experiment of the thesis, repeated on the twin. A new one is a file of its own that defines
/// one of these, and a line in experiments.cpp.
struct Experiment {
  std::string name;     ///< on the command line
  std::string summary;  ///< one line for --help
  /// @returns {"experiment", "seed", "passed", "rows": [...], "thesis": [...]}: `rows` is measured
  ///          now, `thesis` is what the thesis reports. @throws InputError
  nlohmann::ordered_json (*run)(const ExperimentOptions& options);
  /// The result for a terminal, ending in a line break.
  std::string (*table)(const nlohmann::ordered_json& result);
  /// The result as a chapter of docs/results.md, from its heading (level 2) on.
  std::string (*chapter)(const nlohmann::ordered_json& result);
  /// It has a page of its own and is not one of `all`: of that page, what is above its line
  /// kGeneratedBelow is kept.
  bool own_page{};
};

inline constexpr std::string_view kGeneratedBelow = "<!-- generated below -->\n";

/// All of them, in the order of the thesis; those with pages of their own come last.
[[nodiscard]] std::span<const Experiment> Experiments();
/// Those that a word of the command line names: one, or `all`. @throws InputError
[[nodiscard]] std::span<const Experiment> ExperimentsNamed(const std::string& word);

/// docs/results.md from the results of several experiments, or the page of one of its own.
/// @param before  what the page holds so far
[[nodiscard]] std::string ResultsPage(std::span<const Experiment> experiments,
                                      std::span<const nlohmann::ordered_json> results,
                                      const std::string& before);

/// Does jobs 0 … count − 1 on several threads. @throws what the first job to fail threw, after all
/// threads have stopped.
void ForEachInParallel(std::size_t count, unsigned threads,
                       const std::function<void(std::size_t)>& job);

}  // namespace kantaro::scenarios
