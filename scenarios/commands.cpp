#include "scenarios/commands.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "perception/parameters.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/landmark_calibration.hpp"
#include "scenarios/replay.hpp"
#include "scenarios/result.hpp"
#include "scenarios/runner.hpp"
#include "scenarios/suite.hpp"
#include "scenarios/view.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

/// A line on standard error that is written over and over; silent unless that is a terminal.
class ProgressLine {
 public:
  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { Show(""); }

  void Show(const std::string& text) const {
    if (terminal_) std::cerr << "\r\x1b[K" << text << std::flush;
  }

 private:
  bool terminal_{isatty(STDERR_FILENO) == 1};
};

std::string ResultText(const Result& result, const std::filesystem::path& folder) {
  std::string text =
      fmt::format("{} seed {}: {} ({:.1f} s simulated, {:.1f} times real time)\n", result.scenario,
                  result.seed, result.verdict.passed ? "passed" : "FAILED", result.timing.sim_s,
                  result.timing.RealTimeFactor());
  for (const Check& check : result.verdict.checks) {
    const char* mark = !check.judged ? "-   " : check.passed ? "ok  " : "FAIL";
    text += fmt::format("  {} {:<26}{}\n", mark, check.name, check.text);
  }
  return text + fmt::format("report: {}\n", (folder / "report.html").string());
}

std::filesystem::path FolderOf(const RunRequest& request, const Scenario& scenario) {
  if (request.out && request.scenarios.size() == 1) return *request.out;
  return request.out.value_or("runs") / scenario.name / fmt::format("seed-{}", request.seed);
}

std::vector<Scenario> ReadAll(const RunRequest& request) {
  std::vector<Scenario> scenarios;
  std::map<std::string, std::filesystem::path> names;
  for (const std::filesystem::path& file : request.scenarios) {
    Scenario scenario = ReadScenario(file);
    for (const robot::Sensor sensor : request.blind) scenario.faults.push_back(Blind(sensor));
    if (const auto [known, is_new] = names.emplace(scenario.name, file); !is_new) {
      throw InputError(
          file, {}, "name",
          fmt::format("\"{}\" is also the name of {}", scenario.name, known->second.string()));
    }
    CheckFolder(FolderOf(request, scenario), "result.json");
    scenarios.push_back(std::move(scenario));
  }
  return scenarios;
}

/// Beside the run folder until the run is over, where it is found if the run breaks off.
std::filesystem::path RecordingOf(const std::filesystem::path& folder) {
  return folder.string() + ".recording.bag";
}

Result RunOne(const Scenario& scenario, const RunRequest& request,
              const std::filesystem::path& folder) {
  const std::uint64_t seed = request.seed;
  const ProgressLine line;
  RunOptions options;
  options.hardware = request.hardware;
  options.render_threads = request.render_threads;
  options.progress = [&](double sim_s, double limit_s) {
    line.Show(fmt::format("{} seed {}: {:.0f} s of at most {:.0f} s", scenario.name, seed, sim_s,
                          limit_s));
  };
  std::optional<FileLock> lock;  // two recordings in one file would spoil each other
  if (request.record) {
    options.recording = RecordingOf(folder);
    lock.emplace(folder.string() + ".recording.lock", folder);
  }
  const MissionRun run = RunMission(scenario, seed, options);
  WriteFolder(folder, FilesOf(run),
              options.recording ? MovedFiles{{"recording.bag", *options.recording}} : MovedFiles{});
  return run.result;
}

Json Measure(const Experiment& experiment, const ExperimentRequest& request) {
  const ProgressLine line;
  const auto progress = [&](std::size_t done, std::size_t all) {
    line.Show(fmt::format("{}: {} of {} runs", experiment.name, done, all));
  };
  return experiment.run({request.robot_folder, request.seed, request.count, request.only,
                         request.jobs, request.photos, request.scans, request.out, progress});
}

Json ReadMeasured(const Experiment& experiment, const std::filesystem::path& file) {
  try {
    Json result = Json::parse(ReadInputFile(file));
    if (result.at("experiment") == experiment.name) {
      // Touch all that is used, so that a file of another kind is refused as a whole.
      static_cast<void>(experiment.table(result) + experiment.chapter(result));
      static_cast<void>(result.at("passed").get<bool>());
      return result;
    }
  } catch (const Json::exception&) {
    // said below
  }
  throw InputError(file, {}, "",
                   fmt::format("not a result of the experiment \"{}\"", experiment.name));
}

std::string BlindWords(const std::set<robot::Sensor>& blind) {
  std::string words;
  for (const robot::Sensor sensor : blind)
    words += (words.empty() ? "" : ",") + std::string(robot::ToString(sensor));
  return words;
}

void DemandYamlEnding(const std::filesystem::path& to) {
  if (to.extension() == ".yaml" || to.extension() == ".yml") return;
  throw InputError(
      "--to", {}, "",
      fmt::format("\"{}\" does not end in .yaml, the format that is written", to.string()));
}

std::string DescriptionOf(const network::Network& network, bool json) {
  const std::string text = json ? network::DescribeJson(network) : network::Describe(network);
  return text.ends_with('\n') ? text : text + '\n';
}

struct Learnt {
  perception::LandmarkCalibration calibration;
  std::string remark;  ///< how
};

Learnt Learn(const CalibrateRequest& request, const CalibrationOptions& options) {
  const robot::Description robot = robot::ReadDescription(request.robot_folder);
  const auto parameters =
      perception::ReadParameters(request.robot_folder / "perception.yaml").landmarks;
  const std::string twin = fmt::format("--seed {} --views {}", options.seed, options.views);
  if (!request.thesis_only && !request.recording)
    return {CalibrateLandmarks(robot, parameters, options),
            twin + " from training views of the twin"};
  auto calibration = perception::ReadLandmarkCalibration(request.robot_folder / "landmarks.yaml");
  if (request.recording) {
    const auto views =
        CalibrateThesisFromRecording(robot, parameters, *request.recording, calibration);
    return {calibration,
            fmt::format("--from {}: {} views of manholes, {} of joints, {} of inlets",
                        request.recording->filename().string(), views[0], views[1], views[2])};
  }
  for (const ViewCameras cameras : {ViewCameras::kFront, ViewCameras::kStereo})
    CalibrateThesis(robot, parameters, ViewSet::kReproduction, cameras, options, calibration);
  return {calibration, twin + " --only thesis from training views of the twin"};
}

}  // namespace

int Run(const RunRequest& request, std::ostream& out) {
  const std::vector<Scenario> scenarios = ReadAll(request);
  Json results = Json::array();
  bool passed = true;
  for (const Scenario& scenario : scenarios) {
    const std::filesystem::path folder = FolderOf(request, scenario);
    const Result result = RunOne(scenario, request, folder);
    passed = passed && result.verdict.passed;
    results.push_back(ToJson(result));
    if (!request.json) out << ResultText(result, folder) << std::flush;
  }
  if (request.json) out << (results.size() == 1 ? results.front() : results).dump(2) << '\n';
  return passed ? kExitPassed : kExitFailed;
}

int Replay(const ReplayRequest& request, std::ostream& out) {
  if (request.out) CheckFolder(*request.out, "result.json");
  const ReplayResult result = ReplayRecording(request.recording, request.robot_folder);
  const std::string json = ToJson(result).dump(2) + "\n";
  if (request.out) {
    FolderFiles files = FilesOf(result.run);
    files.emplace_back("replay.json", json);
    WriteFolder(*request.out, files);
  }
  out << (request.json ? json : ToText(result));
  return result.same() || request.robot_folder ? kExitPassed : kExitFailed;
}

int Suite(const SuiteRequest& request, std::ostream& out) {
  SuiteOptions options{request.paths,   request.seeds,
                       request.jobs,    request.out.value_or("runs/suite"),
                       request.program, {}};
  if (!request.blind.empty()) options.extra = {"--blind", BlindWords(request.blind)};
  const std::string baseline = request.baseline ? ReadInputFile(*request.baseline) : "";
  if (request.baseline) static_cast<void>(CompareWithBaseline({}, baseline, *request.baseline));
  const std::vector<SuiteCase> cases = ListCases(options);
  for (const SuiteCase& mission : cases) CheckFolder(mission.run_folder, "result.json");

  std::vector<CaseResult> results;
  {
    const ProgressLine line;
    std::size_t failed = 0;
    line.Show(fmt::format("0 of {} missions", cases.size()));
    results =
        RunCases(cases, options, [&](const CaseResult& result, std::size_t done, std::size_t all) {
          failed += result.outcome == CaseResult::Outcome::kPassed ? 0 : 1;
          line.Show(fmt::format("{} of {} missions, {} not passed; last: {} seed {}", done, all,
                                failed, result.mission.scenario, result.mission.seed));
        });
  }
  std::optional<Comparison> comparison;
  if (request.baseline) comparison = CompareWithBaseline(results, baseline, *request.baseline);
  const Comparison* compared = comparison ? &*comparison : nullptr;
  const std::string json = SuiteJson(results, compared, options.out).dump(2) + "\n";
  WriteFileAtomically(options.out / "suite.json", json);
  const std::filesystem::path page = options.out / "suite.html";
  WriteFileAtomically(page, SuiteHtml(results, compared, options.out));
  if (request.junit) WriteFileAtomically(*request.junit, JunitXml(results));
  out << (request.json ? json : SuiteTable(results, compared));
  if (!request.json) out << fmt::format("report: {}\n", page.string());
  return AllPassed(results) ? kExitPassed : kExitFailed;
}

int DescribeNetwork(const NetworkRequest& request, std::ostream& out) {
  const network::Network network = network::ReadNetwork(request.file);
  if (request.to) DemandYamlEnding(*request.to);
  const std::string text = DescriptionOf(network, request.json);
  if (request.to) WriteFileAtomically(*request.to, network::ToYaml(network));
  out << text;
  return kExitPassed;
}

int GenerateNetwork(const GenerateRequest& request, std::ostream& out) {
  DemandYamlEnding(request.to);
  const network::Network network = network::Generate(request.options);
  const std::string text = DescriptionOf(network, request.json);
  WriteFileAtomically(request.to, network::ToYaml(network));
  out << text;
  return kExitPassed;
}

int Render(const RenderRequest& request, std::ostream& out) {
  const Scenario scenario = ReadScenario(request.scenario);
  const std::filesystem::path folder =
      request.out.value_or(std::filesystem::path("runs") / scenario.name /
                           fmt::format("view-{}-{:.2f}", request.pipe, request.chainage_m));
  CheckFolder(folder, "truth.json");
  const FolderFiles files = RenderView(scenario, request.pipe, request.chainage_m, request.seed);
  WriteFolder(folder, files);
  if (request.json) {
    out << files.front().second;
  } else {
    for (const auto& [name, bytes] : files) out << (folder / name).string() << '\n';
  }
  return kExitPassed;
}

int Calibrate(const CalibrateRequest& request, std::ostream& out) {
  DemandYamlEnding(request.to);
  CalibrationOptions options;
  options.seed = request.seed;
  if (request.views > 0) options.views = request.views;
  options.jobs = request.jobs;
  const ProgressLine progress;
  options.progress = [&](std::size_t done, std::size_t all) {
    progress.Show(fmt::format("calibrate: {} of {} views", done, all));
  };
  const auto [calibration, remark] = Learn(request, options);
  WriteFileAtomically(request.to,
                      perception::ToYaml(calibration, "Written by kantaro calibrate " + remark));
  if (request.json) {
    out << Json{{"file", request.to.string()}, {"how", remark}}.dump(2) << '\n';
  } else {
    out << request.to.string() << '\n';
  }
  return kExitPassed;
}

int RunExperiments(const ExperimentRequest& request, std::ostream& out) {
  const std::span<const Experiment> experiments = ExperimentsNamed(request.name);
  std::vector<Json> results;
  bool passed = true;
  for (const Experiment& experiment : experiments) {
    const std::filesystem::path file =
        request.from.value_or(request.out) / (experiment.name + ".json");
    results.push_back(request.from ? ReadMeasured(experiment, file) : Measure(experiment, request));
    if (!request.from) WriteFileAtomically(file, results.back().dump(2) + "\n");
    passed = passed && results.back().at("passed").get<bool>();
    if (!request.json)
      out << experiment.table(results.back()) << "results: " << file.string() << '\n' << std::flush;
  }
  if (request.page) {
    const std::string before =
        std::filesystem::exists(*request.page) ? ReadInputFile(*request.page) : "";
    WriteFileAtomically(*request.page, ResultsPage(experiments, results, before));
  }
  if (request.json)
    out << (request.name == "all" ? Json(results) : results.front()).dump(2) << '\n';
  return passed ? kExitPassed : kExitFailed;
}

}  // namespace kantaro::scenarios
