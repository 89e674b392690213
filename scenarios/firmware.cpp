#include "scenarios/firmware.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "robot/device/emulator.hpp"
#include "scenarios/body.hpp"
#include "scenarios/commands.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using robot::RunTime;

/// A base slower than this stands still; its wheels turn by less than half a degree in 0.1 s.
constexpr double kStill_m_s = 0.003;

/// What is noted down of the truth while the host drives.
struct Watched {
  RunTime now{};
  RunTime moved_at{};  ///< last time that the base moved
  sim::GroundTruth truth;
};

std::optional<RunTime> At(const std::optional<double>& time_s) {
  if (!time_s) return std::nullopt;
  return RunTime(std::llround(*time_s * 1e9));
}

robot::EmulatorOptions OptionsOf(const FirmwareRequest& request, const Scenario& scenario) {
  robot::EmulatorOptions options;
  options.folder = request.out.value_or(std::filesystem::path("runs") / scenario.name /
                                        fmt::format("firmware-{}", request.seed));
  options.controller = request.controller.value_or("");
  options.laser = request.laser.value_or("");
  options.cameras =
      scenario.Has(robot::Sensor::kFrontCamera) || scenario.Has(robot::Sensor::kStereoCameras);
  options.lockstep = request.lockstep;
  options.faults = {request.noise, request.noise, request.noise};
  options.seed = request.seed;
  options.cut_controller_at = At(request.cut_controller_s);
  options.cut_laser_at = At(request.cut_laser_s);
  options.cut_front_at = At(request.cut_front_s);
  return options;
}

std::string PlaceOf(const sim::GroundTruth& truth, const network::Network& network) {
  if (truth.pipe) {
    return fmt::format("in pipe {} at {:.2f} m", network.pipes[*truth.pipe].name, truth.chainage_m);
  }
  if (truth.manhole) return "in manhole " + network.manholes[*truth.manhole].name;
  return "outside every pipe and manhole";
}

Json Outcome(const Scenario& scenario, const FirmwareRequest& request,
             const robot::Emulator& emulator, const Watched& watched) {
  Json json{{"scenario", scenario.name},
            {"seed", request.seed},
            {"end_s", robot::Seconds(watched.now)},
            {"place", PlaceOf(watched.truth, scenario.network)},
            {"goal", scenario.goal},
            {"moved_until_s", robot::Seconds(watched.moved_at)},
            {"watchdog_tripped", emulator.controller().watchdog_tripped()},
            {"stopped_by_host", emulator.controller().stopped()},
            {"corrupt_frames_from_host", emulator.controller().received().corrupt}};
  if (emulator.lost_at()) json["host_lost_s"] = robot::Seconds(*emulator.lost_at());
  return json;
}

std::string InWords(const Json& outcome) {
  std::string text = fmt::format(
      "{:.2f} s: the robot stands {}; its goal was manhole {}\n", outcome["end_s"].get<double>(),
      outcome["place"].get<std::string>(), outcome["goal"].get<std::string>());
  if (outcome.contains("host_lost_s")) {
    text +=
        fmt::format("host lost at {:.2f} s; {}; the robot last moved at {:.2f} s\n",
                    outcome["host_lost_s"].get<double>(),
                    outcome["stopped_by_host"].get<bool>()    ? "it had said stop"
                    : outcome["watchdog_tripped"].get<bool>() ? "the watchdog stopped the wheels"
                                                              : "the wheels stood already",
                    outcome["moved_until_s"].get<double>());
  }
  return text;
}

}  // namespace

int PlayFirmware(const FirmwareRequest& request, std::ostream& out) {
  const Scenario scenario = AroundItsRoute(ReadScenario(request.scenario));
  const robot::Description description = robot::ReadDescription(scenario.robot_folder);
  const Body body = MakeBody({}, scenario, DrawConditions(scenario, request.seed), description, 2);
  robot::Emulator emulator(*body.hardware, description, OptionsOf(request, scenario));
  if (!request.json) {
    out << fmt::format("waiting for: kantaro run {} --seed {} --hardware device:{}\n",
                       request.scenario.string(), request.seed, emulator.config().string())
        << std::flush;
  }
  Watched watched;
  emulator.Serve([&](RunTime now) {
    watched.now = now;
    watched.truth = body.truth();
    if (std::abs(watched.truth.speed_m_s) > kStill_m_s) watched.moved_at = now;
  });
  const Json outcome = Outcome(scenario, request, emulator, watched);
  out << (request.json ? outcome.dump(2) + "\n" : InWords(outcome));
  return kExitPassed;
}

}  // namespace kantaro::scenarios
