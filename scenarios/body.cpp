#include "scenarios/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/input_error.hpp"
#include "robot/device/device.hpp"
#include "robot/recording/replay.hpp"
#include "scenarios/twin_conditions.hpp"

namespace kantaro::scenarios {
namespace {

Body MakeTwin(const Scenario& scenario, const Conditions& conditions,
              const robot::Description& description, int render_threads) {
  sim::Conditions twin_conditions = TwinConditions(scenario, conditions);
  twin_conditions.render_threads = render_threads;
  const bool seeing =
      scenario.Has(robot::Sensor::kFrontCamera) || scenario.Has(robot::Sensor::kStereoCameras);
  auto twin =
      std::make_unique<sim::Twin>(sim::BuildWorld(scenario.network, conditions.texture, seeing,
                                                  sim::ReadGripTable(scenario.materials_file)),
                                  description, twin_conditions);
  sim::Twin& known = *twin;
  return {std::move(twin), [&known] { return known.Truth(); }};
}

/// Opens hardware that is named by a file, of which nobody knows the truth.
struct FileBackEnd {
  const char* kind;
  const char* file;  ///< what it is, for the usage
  std::unique_ptr<robot::Hardware> (*open)(const std::filesystem::path&, const robot::Description&);
};
const std::vector<FileBackEnd> kFileBackEnds{
    {"replay", "RECORDING",
     [](const std::filesystem::path& file,
        const robot::Description&) -> std::unique_ptr<robot::Hardware> {
       return std::make_unique<robot::Replay>(robot::Recording(file));
     }},
    {"device", "CONFIG", &robot::OpenDevice}};

}  // namespace

HardwareChoice ParseHardware(const std::string& word) {
  const std::size_t colon = word.find(':');
  const HardwareChoice choice{word.substr(0, colon),
                              colon == std::string::npos ? "" : word.substr(colon + 1)};
  if (word == "sim") return choice;
  std::string known = "sim";
  for (const FileBackEnd& back_end : kFileBackEnds) {
    if (choice.kind == back_end.kind && !choice.file.empty()) return choice;
    known += fmt::format(", {}:{}", back_end.kind, back_end.file);
  }
  throw InputError("--hardware", {}, "", fmt::format("\"{}\" is none of {}", word, known));
}

Body MakeBody(const HardwareChoice& choice, const Scenario& scenario, const Conditions& conditions,
              const robot::Description& description, int render_threads) {
  const auto back_end =
      std::find_if(std::begin(kFileBackEnds), std::end(kFileBackEnds),
                   [&](const FileBackEnd& one) { return choice.kind == one.kind; });
  if (back_end != std::end(kFileBackEnds)) return {back_end->open(choice.file, description), {}};
  return MakeTwin(scenario, conditions, description, render_threads);
}

}  // namespace kantaro::scenarios
