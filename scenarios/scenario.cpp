#include "scenarios/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/files.hpp"
#include "base/yaml.hpp"
#include "network/formats.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string ParseName(const YamlNode& node) {
  const std::string name = node.Text();
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
  if (!plain || name.starts_with('.') || name.size() > 100) {
    throw node.Error(
        "a name has up to 100 letters, digits, '_', '-' and '.', because it also names folders");
  }
  return name;
}

std::filesystem::path ParsePath(const YamlNode& node) {
  const std::filesystem::path given = node.Text();
  return given.is_absolute() ? given : (node.file().parent_path() / given).lexically_normal();
}

Interval ParseInterval(const YamlNode& node, double lowest, double highest) {
  const std::vector<YamlNode> ends = node.Elements();
  if (ends.size() != 2) throw node.Error("two numbers are wanted here, [low, high]");
  const Interval interval{ends[0].Number(lowest, highest), ends[1].Number(lowest, highest)};
  if (interval.low > interval.high) throw node.Error("the low end comes first");
  return interval;
}

template <typename Value, typename Read>
void ReadIfGiven(const YamlNode& map, std::string_view key, Value& value, const Read& read) {
  if (const auto node = map.Find(key)) value = read(*node);
}

Variation ParseVariation(const YamlNode& node) {
  node.AllowOnly({"start_offset_mm", "start_yaw_deg", "friction", "friction_factor",
                  "motor_mismatch_percent", "map_error_percent", "texture", "light",
                  "stereo_yaw_error_deg"});
  Variation variation;
  ReadIfGiven(node, "start_offset_mm", variation.start_offset_m,
              [](const YamlNode& n) { return n.Number(0.0, 10000.0) / 1000.0; });
  ReadIfGiven(node, "start_yaw_deg", variation.start_yaw_rad,
              [](const YamlNode& n) { return n.Number(0.0, 45.0) * kDegree; });
  ReadIfGiven(node, "friction", variation.friction,
              [](const YamlNode& n) { return ParseInterval(n, 0.01, 2.0); });
  ReadIfGiven(node, "friction_factor", variation.friction_factor,
              [](const YamlNode& n) { return ParseInterval(n, 0.1, 10.0); });
  if (variation.friction && node.Find("friction_factor")) {
    throw node["friction_factor"].Error(
        "\"friction\" already sets the friction everywhere: give one of the two");
  }
  ReadIfGiven(node, "motor_mismatch_percent", variation.motor_mismatch,
              [](const YamlNode& n) { return n.Number(0.0, 20.0) / 100.0; });
  ReadIfGiven(node, "map_error_percent", variation.map_error,
              [](const YamlNode& n) { return n.Number(0.0, 50.0) / 100.0; });
  ReadIfGiven(node, "texture", variation.texture, [](const YamlNode& n) { return n.Boolean(); });
  ReadIfGiven(node, "light", variation.light,
              [](const YamlNode& n) { return ParseInterval(n, 0.0, 1.0); });
  ReadIfGiven(node, "stereo_yaw_error_deg", variation.stereo_yaw_error_rad,
              [](const YamlNode& n) { return n.Number(0.0, 1.0) * kDegree; });
  return variation;
}

double ParseIllumination(const YamlNode& node) {
  if (node.Text() == "bright") return 1.0;
  if (node.Text() == "dimmed") return kDimmed;
  throw node.Error(
      fmt::format("\"{:.40}\" is no illumination; known are bright and dimmed", node.Text()));
}

CameraSettings ParseCameras(const YamlNode& node) {
  node.AllowOnly(
      {"illumination", "exposure_factor", "gain_dB", "drops_on_lens", "dropped_frames_percent"});
  CameraSettings cameras;
  ReadIfGiven(node, "illumination", cameras.illumination, ParseIllumination);
  ReadIfGiven(node, "exposure_factor", cameras.exposure_factor,
              [](const YamlNode& n) { return n.Number(0.01, 10.0); });
  ReadIfGiven(node, "gain_dB", cameras.gain_factor,
              [](const YamlNode& n) { return std::pow(10.0, n.Number(-40.0, 40.0) / 20.0); });
  ReadIfGiven(node, "drops_on_lens", cameras.drops_on_lens,
              [](const YamlNode& n) { return static_cast<int>(n.Integer(0, 100)); });
  ReadIfGiven(node, "dropped_frames_percent", cameras.dropped_share,
              [](const YamlNode& n) { return n.Number(0.0, 100.0) / 100.0; });
  return cameras;
}

Limits ParseLimits(const YamlNode& node) {
  node.AllowOnly({"speed_m_s", "position_error_m", "final_position_error_m", "goal_tolerance_m",
                  "heading_deg"});
  Limits limits;
  const auto positive = [](const YamlNode& n) { return n.Positive(); };
  ReadIfGiven(node, "speed_m_s", limits.speed_m_s, positive);
  ReadIfGiven(node, "position_error_m", limits.position_error_m, positive);
  ReadIfGiven(node, "final_position_error_m", limits.final_position_error_m, positive);
  ReadIfGiven(node, "goal_tolerance_m", limits.goal_tolerance_m, positive);
  ReadIfGiven(node, "heading_deg", limits.heading_rad,
              [](const YamlNode& n) { return n.Number(1.0, 180.0) * kDegree; });
  return limits;
}

std::string ParseManhole(const YamlNode& node, const network::Network& network) {
  const std::string name = node.Text();
  if (!network.FindManhole(name))
    throw node.Error(fmt::format("the network has no manhole \"{}\"", name));
  return name;
}

const network::Pipe& ParsePipe(const YamlNode& node, const network::Network& network) {
  const std::string name = node.Text();
  const auto index = network.FindPipe(name);
  if (!index) throw node.Error(fmt::format("the network has no pipe \"{}\"", name));
  const network::Pipe& pipe = network.pipes[*index];
  if (!network::IsEnterable(pipe)) {
    std::string sizes = fmt::format("{:.0f}", pipe.diameter_m * 1000.0);
    for (const network::DiameterChange& change : pipe.diameter_changes) {
      sizes += fmt::format(", then {:.0f}", change.diameter_m * 1000.0);
    }
    throw node.Error(fmt::format(
        "pipe \"{}\" of {} mm is not one that KANTARO can enter ({:.0f} to {:.0f} mm)", name, sizes,
        network::kSmallestEnterable_m * 1000.0, network::kLargestEnterable_m * 1000.0));
  }
  return pipe;
}

const network::Pipe& OnlyPipeOf(const YamlNode& node, const network::Network& network,
                                const std::string& manhole) {
  std::vector<std::size_t> pipes = network.PipesAt(manhole);
  std::erase_if(pipes, [&](std::size_t i) { return !network::IsEnterable(network.pipes[i]); });
  if (pipes.size() == 1) return network.pipes[pipes.front()];
  throw node.Error(fmt::format(
      "{} pipes that KANTARO can enter end in manhole \"{}\": name one with the key \"pipe\"",
      pipes.size(), manhole));
}

Start ParseStart(const YamlNode& node, const network::Network& network) {
  node.AllowOnly({"manhole", "pipe", "chainage_m"});
  Start start;
  start.manhole = ParseManhole(node["manhole"], network);
  const auto given = node.Find("pipe");
  const network::Pipe& pipe =
      given ? ParsePipe(*given, network) : OnlyPipeOf(node, network, start.manhole);
  if (pipe.upstream != start.manhole && pipe.downstream != start.manhole) {
    throw given->Error(
        fmt::format("pipe \"{}\" runs from \"{}\" to \"{}\", not through the start manhole \"{}\"",
                    pipe.name, pipe.upstream, pipe.downstream, start.manhole));
  }
  start.pipe = pipe.name;
  const double length_m = network::PipeAxis(network, pipe).length_m();
  // Half a metre in: the robot, some 0.3 m long, stands wholly inside the pipe.
  start.chainage_m = pipe.upstream == start.manhole ? 0.5 : length_m - 0.5;
  ReadIfGiven(node, "chainage_m", start.chainage_m,
              [&](const YamlNode& n) { return n.Number(0.0, length_m); });
  return start;
}

std::string NoSensor(const std::string& word) {
  return fmt::format("\"{:.40}\" is no sensor; known are {}", word, robot::SensorWords());
}

std::vector<robot::Fault> ParseFaults(const YamlNode& root) {
  std::vector<robot::Fault> faults;
  if (const auto list = root.Find("faults")) faults = robot::ReadFaults(*list);
  if (const auto list = root.Find("blind")) {
    for (const YamlNode& word : list->Elements()) {
      const std::set<robot::Sensor> sensors = robot::SensorsNamed(word.Text());
      if (sensors.empty()) throw word.Error(NoSensor(word.Text()));
      for (const robot::Sensor sensor : sensors) faults.push_back(Blind(sensor));
    }
  }
  return faults;
}

/// There is no way: is there one but for the turns?
std::string WhyNoWay(const Scenario& scenario) {
  const network::Network& network = scenario.network;
  const auto route = network::ShortestRoute(network, RouteManholes(scenario), network::Turns::kAny);
  for (std::size_t i = 0; i + 1 < route.size(); ++i) {
    const network::Manhole& manhole = network.ManholeNamed(EndOf(network, route[i]));
    const double turn = std::abs(network::TurnInto(
        network, manhole, network.PipeNamed(route[i].pipe), network.PipeNamed(route[i + 1].pipe)));
    if (turn <= network::kSharpestTurn_rad) continue;
    return fmt::format(
        "the way there turns by {:.0f}° in manhole \"{}\", from pipe \"{}\" into pipe \"{}\": "
        "KANTARO turns by at most {:.0f}°",
        turn / kDegree, manhole.name, route[i].pipe, route[i + 1].pipe,
        network::kSharpestTurn_rad / kDegree);
  }
  return "no way leads there through pipes that KANTARO can enter";
}

void CheckRoute(const YamlNode& root, const Scenario& scenario) {
  const std::vector<network::RouteLeg> route = PlannedRoute(scenario);
  if (route.empty()) throw root["goal"].Error(WhyNoWay(scenario));
  if (route.front().pipe != scenario.start.pipe) {
    throw root["start"].Error(fmt::format(
        "pipe \"{}\" leads to the same manhole and is shorter: start there", route.front().pipe));
  }
}

}  // namespace

robot::Fault Blind(robot::Sensor sensor) {
  robot::Fault fault;
  fault.sensor = sensor;
  fault.kind = robot::FaultKind::kDead;
  return fault;
}

std::set<robot::Sensor> ParseBlind(const std::string& word, const std::filesystem::path& argument) {
  const std::set<robot::Sensor> sensors = robot::SensorsNamed(word);
  if (sensors.empty()) throw InputError(argument, {}, "", NoSensor(word));
  return sensors;
}

bool Scenario::Has(robot::Sensor sensor) const {
  return std::none_of(faults.begin(), faults.end(), [&](const robot::Fault& fault) {
    return fault.sensor == sensor && fault.kind == robot::FaultKind::kDead &&
           fault.from == robot::RunTime{} && !fault.until && fault.from_reading <= 1;
  });
}

std::vector<std::string> RouteManholes(const Scenario& scenario) {
  const network::Pipe& pipe = scenario.network.PipeNamed(scenario.start.pipe);
  std::vector<std::string> manholes{scenario.start.manhole, pipe.upstream == scenario.start.manhole
                                                                ? pipe.downstream
                                                                : pipe.upstream};
  manholes.insert(manholes.end(), scenario.via.begin(), scenario.via.end());
  manholes.push_back(scenario.goal);
  manholes.erase(std::unique(manholes.begin(), manholes.end()), manholes.end());
  return manholes;
}

std::vector<network::RouteLeg> PlannedRoute(const Scenario& scenario) {
  return network::ShortestRoute(scenario.network, RouteManholes(scenario));
}

Scenario AroundItsRoute(const Scenario& scenario) {
  constexpr std::size_t kSmall = 40;  // pipes
  constexpr double kReach_m = 10.0;   // twice as far as the cameras see
  if (scenario.network.pipes.size() <= kSmall) return scenario;
  std::vector<std::string> manholes = RouteManholes(scenario);
  for (const network::RouteLeg& leg : PlannedRoute(scenario)) {
    const network::Pipe& pipe = scenario.network.PipeNamed(leg.pipe);
    manholes.push_back(leg.downstream ? pipe.downstream : pipe.upstream);
  }
  Scenario cut = scenario;
  cut.network = network::Neighbourhood(scenario.network, manholes, kReach_m);
  return cut;
}

Scenario ParseScenario(const std::string& text, const std::filesystem::path& name,
                       const NetworkReader& read_network) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"name", "description", "network", "robot", "materials", "start", "goal", "via",
                  "time_limit_s", "variation", "cameras", "limits", "blind", "faults",
                  "battery_percent"});
  Scenario scenario;
  scenario.file = name;
  scenario.name = ParseName(root["name"]);
  ReadIfGiven(root, "description", scenario.description,
              [](const YamlNode& n) { return n.Text(); });
  scenario.network_file = ParsePath(root["network"]);
  scenario.robot_folder = (name.parent_path() / "../models/kantaro").lexically_normal();
  ReadIfGiven(root, "robot", scenario.robot_folder, ParsePath);
  scenario.materials_file = (scenario.robot_folder / "../materials.yaml").lexically_normal();
  ReadIfGiven(root, "materials", scenario.materials_file, ParsePath);
  scenario.time_limit_s = root["time_limit_s"].Number(1.0, 86400.0);
  ReadIfGiven(root, "variation", scenario.variation, ParseVariation);
  ReadIfGiven(root, "cameras", scenario.cameras, ParseCameras);
  ReadIfGiven(root, "limits", scenario.limits, ParseLimits);
  scenario.faults = ParseFaults(root);
  ReadIfGiven(root, "battery_percent", scenario.battery_charge,
              [](const YamlNode& n) { return n.Number(0.0, 100.0) / 100.0; });

  scenario.network = read_network(scenario.network_file);
  scenario.start = ParseStart(root["start"], scenario.network);
  root["goal"].AllowOnly({"manhole"});
  scenario.goal = ParseManhole(root["goal"]["manhole"], scenario.network);
  if (const auto via = root.Find("via")) {
    for (const YamlNode& manhole : via->Elements()) {
      scenario.via.push_back(ParseManhole(manhole, scenario.network));
    }
  }
  CheckRoute(root, scenario);
  return scenario;
}

Scenario ReadScenario(const std::filesystem::path& file) {
  const std::string text = ReadInputFile(file);
  return ParseScenario(text, file, [&](const std::filesystem::path& network_file) {
    std::error_code error;
    if (!std::filesystem::exists(network_file, error)) {
      throw YamlNode::Parse(text, file)["network"].Error(
          fmt::format("no such file: {}", network_file.string()));
    }
    return network::ReadNetwork(network_file);
  });
}

}  // namespace kantaro::scenarios
