#include "scenarios/recorded_mission.hpp"

#include <charconv>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "network/formats.hpp"

namespace kantaro::scenarios {
namespace {

constexpr const char* kProgramFile = "program";
constexpr const char* kSeedFile = "seed";
constexpr const char* kScenarioFile = "scenario.yaml";
constexpr const char* kNetworkFile = "network.yaml";
constexpr const char* kPerceptionFile = "perception.yaml";
constexpr const char* kNavigationFile = "navigation.yaml";

std::uint64_t ParseSeed(const std::string& text, const std::filesystem::path& name) {
  std::uint64_t seed{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(name, {}, "", "\"" + text + "\" is no seed");
  return seed;
}

}  // namespace

robot::MissionFiles MissionFilesOf(const Scenario& scenario, std::uint64_t seed) {
  robot::MissionFiles files{{kProgramFile, "kantaro " KANTARO_VERSION},
                            {kSeedFile, std::to_string(seed)},
                            {kScenarioFile, ReadInputFile(scenario.file)},
                            {kNetworkFile, network::ToYaml(scenario.network)}};
  for (const char* name : {robot::kUrdfFile, robot::kCompanionFile, robot::kCamerasFile,
                           kPerceptionFile, kNavigationFile}) {
    files[name] = ReadInputFile(scenario.robot_folder / name);
  }
  return files;
}

RecordedMission MissionOf(const robot::Recording& recording) {
  const auto name = [&](const char* file) -> std::filesystem::path {
    return recording.file().string() + ": " + file;
  };
  const auto text = [&](const char* file) -> const std::string& {
    const auto found = recording.mission().find(file);
    if (found == recording.mission().end())
      throw InputError(name(file), {}, "", "the recording lacks this file");
    return found->second;
  };
  RecordedMission mission;
  mission.program = text(kProgramFile);
  mission.scenario =
      ParseScenario(text(kScenarioFile), name(kScenarioFile), [&](const std::filesystem::path&) {
        return network::ParseYaml(text(kNetworkFile), name(kNetworkFile));
      });
  mission.conditions =
      DrawConditions(mission.scenario, ParseSeed(text(kSeedFile), name(kSeedFile)));
  mission.robot = {recording.description(),
                   perception::ParseParameters(text(kPerceptionFile), name(kPerceptionFile)),
                   navigation::ParseParameters(text(kNavigationFile), name(kNavigationFile))};
  return mission;
}

}  // namespace kantaro::scenarios
