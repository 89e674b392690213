// The command line: argument parsing and nothing else.

#include <fmt/format.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <thread>

#include "base/input_error.hpp"
#include "scenarios/commands.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/firmware.hpp"

namespace {

using kantaro::InputError;
namespace scenarios = kantaro::scenarios;

/// A whole number or a decimal one, all of the word. @throws InputError naming the option.
template <typename Number>
Number Parse(const std::string& option, const std::string& word, Number low, Number high) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() ||
      !(value >= low && value <= high)) {
    throw InputError(option, {}, "",
                     fmt::format("\"{}\" is not a number from {} to {}", word, low, high));
  }
  return value;
}

std::uint64_t ParseSeed(const std::string& word) {
  return Parse<std::uint64_t>("--seed", word, 0, std::numeric_limits<std::uint64_t>::max());
}

/// As many as cores, if none are given.
unsigned ParseJobs(const std::string& word) {
  return word.empty() ? std::max(1u, std::thread::hardware_concurrency())
                      : Parse<unsigned>("--jobs", word, 1, 1024);
}

std::set<kantaro::robot::Sensor> ParseBlind(const std::vector<std::string>& words) {
  std::set<kantaro::robot::Sensor> senses;
  for (const std::string& word : words) senses.merge(scenarios::ParseBlind(word, "--blind"));
  return senses;
}

template <typename Value>
std::optional<std::filesystem::path> Given(const Value& word) {
  return word.empty() ? std::nullopt : std::optional<std::filesystem::path>(word);
}

/// Words of the command line, before they are checked.
struct Words {
  std::vector<std::string> paths, blind, only;
  std::string file, to, out, junit, baseline, pipe, chainage, pipes, length, spacing, count, page,
      from, photos, scans, controller, laser, noise, cut_controller, cut_laser, cut_front;
  std::string pace{"real"};
  std::string seed{"1"}, seeds{"1"}, jobs, robot{"models/kantaro"}, other_robot, hardware{"sim"},
      render_threads{"2"};
  bool record{}, json{};
};

/// Where data lies that is no part of the project.
std::filesystem::path DataFolder() {
  const char* given = std::getenv("KANTARO_DATA");
  return given != nullptr ? given : "../shared/data";
}

kantaro::network::GeneratorOptions ReadGeneratorOptions(const Words& words) {
  kantaro::network::GeneratorOptions options;
  const auto layout = kantaro::network::LayoutNamed(words.file);
  if (!layout) {
    throw InputError("LAYOUT", {}, "",
                     fmt::format("\"{}\" is none of grid, tree, city", words.file));
  }
  options.layout = *layout;
  options.seed = ParseSeed(words.seed);
  if (!words.spacing.empty()) {
    options.spacing_m =
        Parse<double>("--spacing-m", words.spacing, kantaro::network::kShortestManholeSpacing_m,
                      kantaro::network::kLongestManholeSpacing_m);
  }
  if (!words.length.empty()) {
    const double most_km =
        std::floor(kantaro::network::LongestGenerated(options.spacing_m) / 1000.0);
    options.length_m = 1000.0 * Parse<double>("--length-km", words.length, 0.001, most_km);
  } else {
    options.pipes = Parse<std::size_t>("--pipes", words.pipes.empty() ? "100" : words.pipes, 1,
                                       kantaro::network::kMostGeneratedPipes);
  }
  return options;
}

std::optional<double> ParseTime(const std::string& option, const std::string& word) {
  if (word.empty()) return std::nullopt;
  return Parse<double>(option, word, 0.0, 1e6);
}

scenarios::FirmwareRequest ReadFirmwareRequest(const Words& words) {
  scenarios::FirmwareRequest request;
  request.scenario = words.file;
  request.seed = ParseSeed(words.seed);
  request.out = Given(words.out);
  request.controller = Given(words.controller);
  request.laser = Given(words.laser);
  if (words.pace != "real" && words.pace != "lockstep") {
    throw InputError("--pace", {}, "", fmt::format("\"{}\" is none of real, lockstep", words.pace));
  }
  request.lockstep = words.pace == "lockstep";
  if (!words.noise.empty()) request.noise = Parse<double>("--noise", words.noise, 0.0, 0.33);
  request.cut_controller_s = ParseTime("--cut-controller", words.cut_controller);
  request.cut_laser_s = ParseTime("--cut-laser", words.cut_laser);
  request.cut_front_s = ParseTime("--cut-front", words.cut_front);
  request.json = words.json;
  return request;
}

int Dispatch(const CLI::App& app, const Words& words) {
  if (app.got_subcommand("run")) {
    scenarios::RunRequest request{{words.paths.begin(), words.paths.end()},
                                  ParseSeed(words.seed),
                                  Given(words.out),
                                  ParseBlind(words.blind),
                                  scenarios::ParseHardware(words.hardware),
                                  words.record,
                                  Parse<int>("--render-threads", words.render_threads, 0, 64),
                                  words.json};
    return scenarios::Run(request, std::cout);
  }
  if (app.got_subcommand("replay")) {
    return scenarios::Replay({words.file, Given(words.other_robot), Given(words.out), words.json},
                             std::cout);
  }
  if (app.got_subcommand("firmware")) {
    return scenarios::PlayFirmware(ReadFirmwareRequest(words), std::cout);
  }
  if (app.got_subcommand("suite")) {
    scenarios::SuiteRequest request;
    request.paths = {words.paths.begin(), words.paths.end()};
    request.seeds = Parse<std::uint64_t>("--seeds", words.seeds, 1, 1000000);
    request.jobs = ParseJobs(words.jobs);
    request.junit = Given(words.junit);
    request.baseline = Given(words.baseline);
    request.out = Given(words.out);
    request.blind = ParseBlind(words.blind);
    request.json = words.json;
    request.program = std::filesystem::read_symlink("/proc/self/exe");
    return scenarios::Suite(request, std::cout);
  }
  if (app.got_subcommand("network")) {
    return scenarios::DescribeNetwork({words.file, Given(words.to), words.json}, std::cout);
  }
  if (app.got_subcommand("generate")) {
    return scenarios::GenerateNetwork({ReadGeneratorOptions(words), words.to, words.json},
                                      std::cout);
  }
  if (app.got_subcommand("calibrate")) {
    scenarios::CalibrateRequest request;
    request.robot_folder = words.robot;
    request.seed = ParseSeed(words.seed);
    if (!words.count.empty())
      request.views = Parse<std::size_t>("--views", words.count, 30, 1000000);
    request.jobs = ParseJobs(words.jobs);
    request.to = words.to.empty() ? request.robot_folder / "landmarks.yaml"
                                  : std::filesystem::path(words.to);
    request.thesis_only = !words.only.empty();
    if (request.thesis_only && words.only != std::vector<std::string>{"thesis"})
      throw InputError("--only", {}, "", "\"thesis\" is all that can be learnt by itself");
    request.recording = Given(words.from);
    request.json = words.json;
    return scenarios::Calibrate(request, std::cout);
  }
  if (app.got_subcommand("experiment")) {
    scenarios::ExperimentRequest request;
    request.name = words.file;
    request.seed = ParseSeed(words.seed);
    if (!words.count.empty())
      request.count = Parse<std::size_t>("--count", words.count, 1, 1000000);
    request.only = words.only;
    request.jobs = ParseJobs(words.jobs);
    request.robot_folder = words.robot;
    request.photos = Given(words.photos).value_or(DataFolder() / "sewer_images");
    request.scans = Given(words.scans).value_or(DataFolder() / "pipe_scans");
    request.out = words.out.empty() ? "runs/experiments" : words.out;
    request.from = Given(words.from);
    request.page = Given(words.page);
    request.json = words.json;
    return scenarios::RunExperiments(request, std::cout);
  }
  return scenarios::Render(
      {words.file, words.pipe, Parse<double>("--chainage", words.chainage, 0.0, 1e6),
       ParseSeed(words.seed), Given(words.out), words.json},
      std::cout);
}

void Declare(CLI::App& app, Words& words) {
  app.require_subcommand(1);
  const auto command = [&](const char* name, const char* does) {
    CLI::App* sub = app.add_subcommand(name, does);
    sub->add_flag("--json", words.json, "print one JSON document and nothing else");
    return sub;
  };
  CLI::App* run =
      command("run", "Run missions, one after the other, and write a run folder for each.");
  run->add_option("SCENARIO", words.paths, "scenario files")->required();
  run->add_option("--seed", words.seed, "what the variation is drawn from (default 1)");
  run->add_option("--out", words.out, "run folder (default runs/NAME/seed-N)");
  run->add_option("--blind", words.blind,
                  "sensors to take from the robot, such as laser,infrared,cameras")
      ->delimiter(',')
      ->allow_extra_args(false);

  run->add_option("--hardware", words.hardware,
                  "what to drive: sim (default), replay:RECORDING, device:CONFIG");
  run->add_option("--render-threads", words.render_threads,
                  "threads that draw for the cameras beside the physics (default 2; 0: none "
                  "beside it); results are the same");
  run->add_flag("--record", words.record, "write every reading and command as a ROS bag");

  CLI::App* firmware =
      command("firmware",
              "Play the robot's processors and cameras, with the twin behind them, for a host.");
  firmware->add_option("SCENARIO", words.file, "scenario file")->required();
  firmware->add_option("--seed", words.seed, "what the conditions are drawn from (default 1)");
  firmware->add_option("--out", words.out,
                       "folder of device.yaml and the cameras (default runs/NAME/firmware-N)");
  firmware->add_option("--controller", words.controller, "where to link the controller's line");
  firmware->add_option("--laser", words.laser, "where to link the laser's line");
  firmware->add_option("--pace", words.pace,
                       "real (default), or lockstep: time goes on as the host acknowledges");
  firmware->add_option("--noise", words.noise,
                       "share of frames to lose, to double and to corrupt on both lines");
  firmware->add_option("--cut-controller", words.cut_controller, "pull its cable at this time [s]");
  firmware->add_option("--cut-laser", words.cut_laser, "pull the laser's");
  firmware->add_option("--cut-front", words.cut_front, "pull the front camera's");

  CLI::App* replay = command(
      "replay", "Play a recording back to perception and navigation, and compare to the bit.");
  replay->add_option("RECORDING", words.file, "recording.bag of a run")->required();
  replay->add_option("--robot", words.other_robot,
                     "a robot's folder with other parameters: tells what they change");
  replay->add_option("--out", words.out, "folder for the replay's report");

  CLI::App* suite = command(
      "suite", "Run many missions, each in a process of its own, and compare with a baseline.");
  suite->add_option("PATH", words.paths, "scenario files, or folders of them")->required();
  suite->add_option("--seeds", words.seeds, "run seeds 1 to K of each (default 1)");
  suite->add_option("--jobs", words.jobs, "missions at once (default: one for each core)");
  suite->add_option("--junit", words.junit, "write JUnit XML here");
  suite->add_option("--baseline", words.baseline, "suite.json of an earlier suite");
  suite->add_option("--out", words.out,
                    "folder of suite.json, suite.html and the run folders (default runs/suite)");
  suite
      ->add_option("--blind", words.blind,
                   "sensors to take from the robot, such as laser,infrared,cameras")
      ->delimiter(',')
      ->allow_extra_args(false);

  CLI::App* network = command("network", "Check, describe and convert a sewer network.");
  network->add_option("FILE", words.file, "a network: the project's .yaml, or EPA SWMM .inp")
      ->required();
  network->add_option("--to", words.to, "write it as the project's YAML here");

  CLI::App* generate = command("generate", "Make a test network from a seed.");
  generate->add_option("LAYOUT", words.file, "grid, tree or city")->required();
  CLI::Option* pipes = generate->add_option("--pipes", words.pipes, "how many pipes (default 100)");
  generate->add_option("--length-km", words.length, "or how long they are in all")->excludes(pipes);
  generate->add_option("--spacing-m", words.spacing,
                       "mean distance of manholes (default 35.8, as in Kitakyushu)");
  generate->add_option("--seed", words.seed, "what it is drawn from (default 1)");
  generate->add_option("--to", words.to, "the .yaml to write")->required();

  CLI::App* render =
      command("render", "Show what each camera sees at a place, with depth and ground truth.");
  render->add_option("SCENARIO", words.file, "scenario file")->required();
  render->add_option("--pipe", words.pipe, "pipe to stand in")->required();
  render->add_option("--chainage", words.chainage, "place in it, m from its upstream manhole")
      ->required();
  render->add_option("--seed", words.seed, "what the conditions are drawn from (default 1)");
  render->add_option("--out", words.out,
                     "folder for the pictures (default runs/NAME/view-PIPE-CHAINAGE)");

  CLI::App* calibrate = command(
      "calibrate", "Learn from training views of the twin what distances of landmarks need.");
  calibrate->add_option("--seed", words.seed, "what the views are drawn from (default 1)");
  calibrate->add_option("--views", words.count, "training views of each set and camera");
  calibrate->add_option("--jobs", words.jobs, "threads (default: one for each core)");
  calibrate->add_option("--robot", words.robot, "the robot's folder (default models/kantaro)");
  calibrate->add_option("--only", words.only, "thesis: keep what the method ours has learnt");
  calibrate->add_option("--from", words.from,
                        "a recording to learn from, for the thesis' method alone");
  calibrate->add_option("--to", words.to, "the .yaml to write (default landmarks.yaml there)");

  CLI::App* experiment =
      command("experiment", "Repeat the thesis' experiments on the twin, beside its figures.");
  std::string known = "all, or one of:";
  for (const scenarios::Experiment& one : scenarios::Experiments())
    known += fmt::format("\n{}: {}", one.name, one.summary);
  experiment->add_option("NAME", words.file, known)->required();
  experiment->add_option("--seed", words.seed, "what the variation is drawn from (default 1)");
  experiment->add_option("--count", words.count,
                         "runs of each row (default: the experiment's own)");
  experiment->add_option("--only", words.only, "cases to run, separated by commas (default: all)")
      ->delimiter(',')
      ->allow_extra_args(false);
  experiment->add_option("--jobs", words.jobs, "threads (default: one for each core)");
  experiment->add_option("--robot", words.robot, "the robot's folder (default models/kantaro)");
  experiment->add_option(
      "--photos", words.photos,
      "realism, ring-photographs: folder of photographs (default sewer_images in KANTARO_DATA)");
  experiment->add_option("--scans", words.scans,
                         "realism: folder of scans (default pipe_scans in KANTARO_DATA)");
  experiment->add_option("--out", words.out, "folder for NAME.json (default runs/experiments)");
  experiment->add_option("--from", words.from, "folder of NAME.json: show that, run nothing");
  experiment->add_option("--page", words.page, "write the page of results here");
}

/// CLI11 alone would say of an unknown command that one is required.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  const std::string given = argc > 1 ? argv[1] : "";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  if (given.starts_with('-') || std::find(names.begin(), names.end(), given) != names.end()) return;
  const std::string problem =
      given.empty() ? "none is given" : fmt::format("\"{}\" is not one", given);
  throw InputError("COMMAND", {}, "",
                   fmt::format("{}; known are {}", problem, fmt::join(names, ", ")));
}

/// One line, whatever names from files it quotes.
std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

int Complain(const std::string& what, int code) {
  std::cerr << "kantaro: " << OneLine(what) << '\n';
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // A world's megabytes go back to the system when it is done with. Left alone, glibc takes such
  // blocks from its heap after the first, and many worlds, one after the other, tear that to
  // pieces.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  CLI::App app("KANTARO Twin: rehearse the missions of a sewer inspection robot.", "kantaro");
  Words words;
  Declare(app, words);
  try {
    CheckCommand(app, argc, argv);
    app.parse(argc, argv);
    return Dispatch(app, words);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return Complain(error.what(), scenarios::kExitBadInput);
  } catch (const InputError& error) {
    return Complain(error.what(), scenarios::kExitBadInput);
  } catch (const std::exception& error) {
    return Complain(fmt::format("internal fault: {}", error.what()), scenarios::kExitInternalFault);
  }
}
