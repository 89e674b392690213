#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "network/generator.hpp"
#include "scenarios/body.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// Exit codes of the program.
inline constexpr int kExitPassed = 0;    ///< done and passed
inline constexpr int kExitFailed = 1;    ///< done and a verdict failed
inline constexpr int kExitBadInput = 2;  ///< bad usage or bad input
inline constexpr int kExitInternalFault = 3;

// The commands of the command line. Each writes what it has to say to `out`, one JSON document and
// nothing else if `json` is set; progress goes to standard error, and only if that is a terminal.
// Returns the exit code. Bad input throws InputError before anything is written.

struct RunRequest {
  std::vector<std::filesystem::path> scenarios;
  std::uint64_t seed{1};
  std::optional<std::filesystem::path>
      out;  ///< the run folder; of several scenarios, the folder of their run folders
  std::set<robot::Sensor> blind;  ///< dead from the beginning
  HardwareChoice hardware;        ///< what is driven
  bool record{};                  ///< writes `recording.bag` into the run folder
  int render_threads{2};          ///< beside the physics
  bool json{};
};
/// Runs each scenario once. With several, the JSON document is a list of results.
int Run(const RunRequest& request, std::ostream& out);

struct ReplayRequest {
  std::filesystem::path recording;
  std::optional<std::filesystem::path> robot_folder;  ///< absent: the recording's own files
  std::optional<std::filesystem::path> out;           ///< folder for the report and `replay.json`
  bool json{};
};
/// Plays a recording back to perception and navigation. With its own files everything is to come
/// out to the bit, and if it does not the exit code is 1; with others it tells what differs.
int Replay(const ReplayRequest& request, std::ostream& out);

struct SuiteRequest {
  std::vector<std::filesystem::path> paths;
  std::uint64_t seeds{1};
  unsigned jobs{1};
  std::optional<std::filesystem::path> junit, baseline, out;
  std::set<robot::Sensor> blind;
  bool json{};
  std::filesystem::path program;  ///< this program, to run each mission in a process of its own
};
/// Runs missions times seeds 1 … K and writes `suite.json` beside their run folders.
int Suite(const SuiteRequest& request, std::ostream& out);

struct NetworkRequest {
  std::filesystem::path file;
  std::optional<std::filesystem::path> to;  ///< where to write it as the project's YAML
  bool json{};
};
int DescribeNetwork(const NetworkRequest& request, std::ostream& out);

struct GenerateRequest {
  network::GeneratorOptions options;
  std::filesystem::path to;  ///< a .yaml
  bool json{};
};
/// Makes a test network, writes it and describes it.
int GenerateNetwork(const GenerateRequest& request, std::ostream& out);

struct RenderRequest {
  std::filesystem::path scenario;
  std::string pipe;
  double chainage_m{};
  std::uint64_t seed{1};
  std::optional<std::filesystem::path> out;
  bool json{};
};
int Render(const RenderRequest& request, std::ostream& out);

struct CalibrateRequest {
  std::filesystem::path robot_folder;
  std::uint64_t seed{1};
  std::size_t views{};  ///< of each set of training views and camera; 0: the usual
  unsigned jobs{1};
  std::filesystem::path to;  ///< a .yaml
  bool thesis_only{};        ///< what `ours` needs stays as the robot's folder has it
  std::optional<std::filesystem::path> recording;  ///< learn from it, for the thesis' method alone
  bool json{};
};
/// Learns from training views of the twin what the landmark methods need, and writes it.
int Calibrate(const CalibrateRequest& request, std::ostream& out);

struct ExperimentRequest {
  std::string name;  ///< of one experiment, or `all`
  std::uint64_t seed{1};
  std::size_t count{};            ///< runs of each row; 0: each experiment's own
  std::vector<std::string> only;  ///< cases; empty: all
  unsigned jobs{1};
  std::filesystem::path robot_folder;
  std::filesystem::path photos, scans;        ///< folders of what is measured against
  std::filesystem::path out;                  ///< folder for NAME.json
  std::optional<std::filesystem::path> from;  ///< folder of NAME.json: show it, run nothing
  std::optional<std::filesystem::path> page;  ///< where to write the page of results
  bool json{};
};
/// With `all`, the JSON document is a list of results. Exit code 1 if a required row fails.
int RunExperiments(const ExperimentRequest& request, std::ostream& out);

}  // namespace kantaro::scenarios
