#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "base/yaml.hpp"
#include "network/check.hpp"
#include "network/formats.hpp"
#include "network/joints.hpp"
#include "network/names.hpp"
#include "network/network_index.hpp"
#include "network/yaml_notes.hpp"
#include "network/yaml_units.hpp"

namespace kantaro::network {
namespace {

// ---------------------------------------------------------------------------------------- reading

std::optional<double> MillimetresIfGiven(const YamlNode& node, std::string_view key) {
  const auto found = node.Find(key);
  return found ? std::optional<double>(Millimetres(*found)) : std::nullopt;
}

template <typename Function>
void ReadIfGiven(const YamlNode& node, std::string_view key, Function&& read) {
  if (const auto found = node.Find(key)) read(*found);
}

void ReadMillimetres(const YamlNode& node, std::string_view key, double& value_m) {
  ReadIfGiven(node, key, [&](const YamlNode& found) { value_m = Millimetres(found); });
}

void ReadDegrees(const YamlNode& node, std::string_view key, double& value_rad) {
  ReadIfGiven(node, key, [&](const YamlNode& found) { value_rad = Degrees(found); });
}

void ReadNumber(const YamlNode& node, std::string_view key, double& value) {
  ReadIfGiven(node, key, [&](const YamlNode& found) { value = found.Number(); });
}

template <typename Enum>
Enum Word(const YamlNode& node) {
  if (const auto value = FromWord<Enum>(node.Text())) return *value;
  throw node.Error(fmt::format("\"{}\" is none of {}", node.Text().substr(0, 40),
                               fmt::join(kWords<Enum>, ", ")));
}

template <typename Item>
void ReadList(const YamlNode& node, std::string_view key, std::vector<Item>& items,
              Item (*read)(const YamlNode&)) {
  ReadIfGiven(node, key, [&](const YamlNode& list) {
    for (const YamlNode& element : list.Elements()) items.push_back(read(element));
  });
}

/// A word, or a number of millimetres.
void ReadBenchHeight(const YamlNode& node, Manhole& manhole) {
  const std::string text = node.Text();
  if (const auto word = FromWord<BenchHeight>(text)) {
    manhole.bench_height = *word;
    return;
  }
  if (std::isalpha(static_cast<unsigned char>(text.front())) != 0) {
    throw node.Error(fmt::format("\"{}\" is none of {}, nor a number of millimetres",
                                 text.substr(0, 40), fmt::join(kWords<BenchHeight>, ", ")));
  }
  manhole.bench_height = BenchHeight::kGiven;
  manhole.given_bench_m = Millimetres(node);
}

Manhole ReadManhole(const YamlNode& node) {
  node.AllowOnly(
      {"name", "position_m", "depth_m", "shaft_diameter_mm", "bench_height", "channel_radius_mm"});
  Manhole manhole;
  manhole.name = node["name"].Text();
  const std::vector<double> position_m = node["position_m"].Numbers(3);
  manhole.p_WM = {position_m[0], position_m[1], position_m[2]};
  ReadNumber(node, "depth_m", manhole.depth_m);
  manhole.shaft_diameter_m = MillimetresIfGiven(node, "shaft_diameter_mm");
  manhole.channel_radius_m = MillimetresIfGiven(node, "channel_radius_mm");
  ReadIfGiven(node, "bench_height",
              [&](const YamlNode& bench) { ReadBenchHeight(bench, manhole); });
  return manhole;
}

Bend ReadBend(const YamlNode& node) {
  node.AllowOnly({"at_m", "radius_mm"});
  const std::vector<double> at_m = node["at_m"].Numbers(2);
  return {{at_m[0], at_m[1]}, Millimetres(node["radius_mm"])};
}

Joint ReadJoint(const YamlNode& node) {
  node.AllowOnly({"at_m", "gap_mm", "depth_mm", "offset_mm", "offset_clock", "deflection_deg",
                  "deflection_clock"});
  Joint joint;
  joint.chainage_m = node["at_m"].Number();
  ReadMillimetres(node, "gap_mm", joint.gap_m);
  ReadMillimetres(node, "depth_mm", joint.depth_m);
  ReadMillimetres(node, "offset_mm", joint.offset_m);
  ReadNumber(node, "offset_clock", joint.offset_clock_h);
  ReadDegrees(node, "deflection_deg", joint.deflection_rad);
  ReadNumber(node, "deflection_clock", joint.deflection_clock_h);
  return joint;
}

Sag ReadSag(const YamlNode& node) {
  node.AllowOnly({"from_m", "to_m", "depth_mm"});
  return {node["from_m"].Number(), node["to_m"].Number(), Millimetres(node["depth_mm"])};
}

DiameterChange ReadDiameterChange(const YamlNode& node) {
  node.AllowOnly({"at_m", "diameter_mm", "align"});
  DiameterChange change{node["at_m"].Number(), Millimetres(node["diameter_mm"])};
  ReadIfGiven(node, "align",
              [&](const YamlNode& word) { change.alignment = Word<Alignment>(word); });
  return change;
}

Inlet ReadInlet(const YamlNode& node) {
  node.AllowOnly({"name", "at_m", "diameter_mm", "clock", "angle_deg", "protrusion_mm"});
  Inlet inlet{node["name"].Text(), node["at_m"].Number(), Millimetres(node["diameter_mm"]),
              node["clock"].Number()};
  ReadDegrees(node, "angle_deg", inlet.angle_rad);
  ReadMillimetres(node, "protrusion_mm", inlet.protrusion_m);
  return inlet;
}

Obstacle ReadObstacle(const YamlNode& node) {
  node.AllowOnly({"name", "kind", "at_m", "clock", "height_mm", "length_mm", "width_mm"});
  Obstacle obstacle;
  obstacle.name = node["name"].Text();
  obstacle.kind = Word<ObstacleKind>(node["kind"]);
  obstacle.chainage_m = node["at_m"].Number();
  ReadNumber(node, "clock", obstacle.clock_h);
  obstacle.height_m = Millimetres(node["height_mm"]);
  ReadMillimetres(node, "width_mm", obstacle.width_m);
  const bool is_stone = obstacle.kind == ObstacleKind::kStone;
  obstacle.length_m =
      is_stone && !node.Find("length_mm") ? obstacle.width_m : Millimetres(node["length_mm"]);
  return obstacle;
}

Fault ReadFault(const YamlNode& node) {
  node.AllowOnly({"name", "category", "rank", "at_m", "clock", "length_mm", "width_mm"});
  return {node["name"].Text(),           Word<FaultCategory>(node["category"]),
          Word<FaultRank>(node["rank"]), node["at_m"].Number(),
          node["clock"].Number(),        Millimetres(node["length_mm"]),
          Millimetres(node["width_mm"])};
}

bool HasJointPattern(const YamlNode& pipe) {
  const auto joints = pipe.Find("joints");
  return joints && !joints->IsSequence();
}

Pipe ReadPipe(const YamlNode& node) {
  node.AllowOnly({"name", "from", "to", "diameter_mm", "material", "condition", "water_mm",
                  "from_offset_mm", "to_offset_mm", "bends", "joints", "sags", "diameter_changes",
                  "inlets", "obstacles", "faults"});
  Pipe pipe;
  pipe.name = node["name"].Text();
  pipe.upstream = node["from"].Text();
  pipe.downstream = node["to"].Text();
  pipe.diameter_m = Millimetres(node["diameter_mm"]);
  pipe.material = Word<Material>(node["material"]);
  ReadIfGiven(node, "condition",
              [&](const YamlNode& word) { pipe.condition = Word<WallCondition>(word); });
  ReadMillimetres(node, "water_mm", pipe.water_m);
  ReadMillimetres(node, "from_offset_mm", pipe.upstream_offset_m);
  ReadMillimetres(node, "to_offset_mm", pipe.downstream_offset_m);
  ReadList(node, "bends", pipe.bends, ReadBend);
  ReadList(node, "diameter_changes", pipe.diameter_changes, ReadDiameterChange);
  ReadList(node, "inlets", pipe.inlets, ReadInlet);
  ReadList(node, "obstacles", pipe.obstacles, ReadObstacle);
  ReadList(node, "faults", pipe.faults, ReadFault);
  if (!HasJointPattern(node)) {
    ReadList(node, "joints", pipe.joints, ReadJoint);
    ReadList(node, "sags", pipe.sags, ReadSag);
  }
  return pipe;
}

std::vector<Joint> ReadJointPattern(const YamlNode& node, double pipe_length_m) {
  node.AllowOnly({"first_m", "spacing_m", "gap_mm", "depth_mm"});
  JointPattern pattern;
  ReadMillimetres(node, "gap_mm", pattern.gap_m);
  ReadMillimetres(node, "depth_mm", pattern.depth_m);
  pattern.first_m = node["first_m"].Number(0.0, pipe_length_m);
  pattern.spacing_m = node["spacing_m"].Number();
  if (pattern.spacing_m < kShortestSpacing_m) {
    throw node["spacing_m"].Error(
        fmt::format("joints stand at least {} m apart", kShortestSpacing_m));
  }
  return LayJoints(pattern, pipe_length_m);
}

double DesignLengthOf(const Network& network, const NetworkIndex& index, std::size_t pipe) {
  return DesignLength(EndAt(network, index, index.upstream[pipe]),
                      EndAt(network, index, index.downstream[pipe]), network.pipes[pipe]);
}

/// Joints by pattern, and the sags between them: they need the pipe's length, so the network must
/// stand (and be checked) without them first.
void ReadJointPatterns(const std::vector<YamlNode>& pipes, Network& network) {
  const NetworkIndex index(network);
  std::size_t joints = 0;
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    if (!HasJointPattern(pipes[i])) continue;
    const YamlNode node = pipes[i]["joints"];
    Pipe& pipe = network.pipes[i];
    pipe.joints = ReadJointPattern(node, DesignLengthOf(network, index, i));
    ReadList(pipes[i], "sags", pipe.sags, ReadSag);
    joints += pipe.joints.size();
    if (joints > kMostJoints) {
      throw node.Error(fmt::format("a network has at most {} joints", kMostJoints));
    }
  }
}

/// The node a flaw speaks of, or the nearest one above it that the file has.
YamlNode NodeOf(const YamlNode& node, std::string_view field) {
  if (field.starts_with('.')) field.remove_prefix(1);
  if (field.starts_with('[') && node.IsSequence()) {
    std::size_t position = 0;
    std::from_chars(field.data() + 1, field.data() + field.size(), position);
    const std::vector<YamlNode> elements = node.Elements();
    if (position >= elements.size()) return node;
    return NodeOf(elements[position], field.substr(field.find(']') + 1));
  }
  const std::string_view key = field.substr(0, field.find_first_of(".["));
  const auto next = node.IsMap() && !key.empty() ? node.Find(key) : std::nullopt;
  return next ? NodeOf(*next, field.substr(key.size())) : node;
}

// ---------------------------------------------------------------------------------------- writing

bool IsPlainWord(const std::string& name) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  static constexpr std::string_view kSpecial[] = {"null", "Null", "NULL"};
  return std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
         std::all_of(name.begin(), name.end(), is_plain) &&
         std::find(std::begin(kSpecial), std::end(kSpecial), name) == std::end(kSpecial);
}

std::string NameText(const std::string& name) {
  if (!name.empty() && IsPlainWord(name)) return name;
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string ManholeText(const Manhole& manhole) {
  std::string text =
      fmt::format("{{name: {}, position_m: [{}, {}, {}], depth_m: {}", NameText(manhole.name),
                  manhole.p_WM.x(), manhole.p_WM.y(), manhole.p_WM.z(), manhole.depth_m);
  if (manhole.shaft_diameter_m) {
    text += fmt::format(", shaft_diameter_mm: {}", MillimetreText(*manhole.shaft_diameter_m));
  }
  text += ", bench_height: ";
  text += manhole.bench_height == BenchHeight::kGiven ? MillimetreText(manhole.given_bench_m)
                                                      : WordFor(manhole.bench_height);
  if (manhole.channel_radius_m) {
    text += fmt::format(", channel_radius_mm: {}", MillimetreText(*manhole.channel_radius_m));
  }
  return text + "}";
}

std::string BendText(const Bend& bend) {
  return fmt::format("{{at_m: [{}, {}], radius_mm: {}}}", bend.p_W.x(), bend.p_W.y(),
                     MillimetreText(bend.radius_m));
}

/// ", key: text" unless the value is the one that is meant without it.
std::string IfOther(const char* key, double value, double usual, std::string (*write)(double)) {
  return value == usual ? "" : fmt::format(", {}: {}", key, write(value));
}

std::string NumberText(double value) { return fmt::format("{}", value); }

std::string JointText(const Joint& joint) {
  const Joint usual;
  return fmt::format("{{at_m: {}, gap_mm: {}, depth_mm: {}", joint.chainage_m,
                     MillimetreText(joint.gap_m), MillimetreText(joint.depth_m)) +
         IfOther("offset_mm", joint.offset_m, usual.offset_m, MillimetreText) +
         IfOther("offset_clock", joint.offset_clock_h, usual.offset_clock_h, NumberText) +
         IfOther("deflection_deg", joint.deflection_rad, usual.deflection_rad, DegreeText) +
         IfOther("deflection_clock", joint.deflection_clock_h, usual.deflection_clock_h,
                 NumberText) +
         "}";
}

std::string SagText(const Sag& sag) {
  return fmt::format("{{from_m: {}, to_m: {}, depth_mm: {}}}", sag.start_m, sag.end_m,
                     MillimetreText(sag.depth_m));
}

std::string DiameterChangeText(const DiameterChange& change) {
  return fmt::format("{{at_m: {}, diameter_mm: {}, align: {}}}", change.chainage_m,
                     MillimetreText(change.diameter_m), WordFor(change.alignment));
}

std::string InletText(const Inlet& inlet) {
  const Inlet usual;
  return fmt::format("{{name: {}, at_m: {}, diameter_mm: {}, clock: {}", NameText(inlet.name),
                     inlet.chainage_m, MillimetreText(inlet.diameter_m), inlet.clock_h) +
         IfOther("angle_deg", inlet.angle_rad, usual.angle_rad, DegreeText) +
         IfOther("protrusion_mm", inlet.protrusion_m, usual.protrusion_m, MillimetreText) + "}";
}

std::string ObstacleText(const Obstacle& obstacle) {
  return fmt::format("{{name: {}, kind: {}, at_m: {}, clock: {}, height_mm: {}, length_mm: {}",
                     NameText(obstacle.name), WordFor(obstacle.kind), obstacle.chainage_m,
                     obstacle.clock_h, MillimetreText(obstacle.height_m),
                     MillimetreText(obstacle.length_m)) +
         IfOther("width_mm", obstacle.width_m, 0.0, MillimetreText) + "}";
}

std::string FaultText(const Fault& fault) {
  return fmt::format(
      "{{name: {}, category: {}, rank: {}, at_m: {}, clock: {}, length_mm: {}, width_mm: {}}}",
      NameText(fault.name), WordFor(fault.category), WordFor(fault.rank), fault.chainage_m,
      fault.clock_h, MillimetreText(fault.length_m), MillimetreText(fault.width_m));
}

template <typename Item>
void WriteList(std::string& text, const char* key, const std::vector<Item>& items,
               std::string (*write)(const Item&)) {
  if (items.empty()) return;
  text += fmt::format("    {}:\n", key);
  for (const Item& item : items) text += fmt::format("      - {}\n", write(item));
}

bool Lays(const JointPattern& pattern, double pipe_length_m, const std::vector<Joint>& joints) {
  return LayJoints(pattern, pipe_length_m) == joints;
}

/// The pattern that lays exactly these joints, if there is one.
std::optional<JointPattern> PatternOf(const std::vector<Joint>& joints, double pipe_length_m) {
  if (joints.size() < 2) return std::nullopt;
  const double step_m = joints[1].chainage_m - joints[0].chainage_m;
  // The step that was written, 1.8, where the subtraction left 1.7999999999999998.
  const double spacing_m = std::round(step_m * 1e6) / 1e6;
  const JointPattern pattern{joints[0].chainage_m, spacing_m, joints[0].gap_m, joints[0].depth_m};
  if (spacing_m < kShortestSpacing_m || !Lays(pattern, pipe_length_m, joints)) return std::nullopt;
  return pattern;
}

void WriteJoints(std::string& text, const Pipe& pipe, double length_m) {
  const auto pattern = PatternOf(pipe.joints, length_m);
  if (!pattern) return WriteList(text, "joints", pipe.joints, JointText);
  text += fmt::format("    joints: {{first_m: {}, spacing_m: {}, gap_mm: {}, depth_mm: {}}}\n",
                      pattern->first_m, pattern->spacing_m, MillimetreText(pattern->gap_m),
                      MillimetreText(pattern->depth_m));
}

void WritePipe(std::string& text, const Pipe& pipe, double design_length_m) {
  text +=
      fmt::format("  - name: {}\n    from: {}\n    to: {}\n    diameter_mm: {}\n    material: {}\n",
                  NameText(pipe.name), NameText(pipe.upstream), NameText(pipe.downstream),
                  MillimetreText(pipe.diameter_m), WordFor(pipe.material));
  const auto write_millimetres = [&](const char* key, double value_m) {
    if (value_m != 0.0) text += fmt::format("    {}: {}\n", key, MillimetreText(value_m));
  };
  if (pipe.condition != WallCondition::kDry) {
    text += fmt::format("    condition: {}\n", WordFor(pipe.condition));
  }
  write_millimetres("water_mm", pipe.water_m);
  write_millimetres("from_offset_mm", pipe.upstream_offset_m);
  write_millimetres("to_offset_mm", pipe.downstream_offset_m);
  WriteList(text, "bends", pipe.bends, BendText);
  WriteList(text, "diameter_changes", pipe.diameter_changes, DiameterChangeText);
  WriteJoints(text, pipe, design_length_m);
  WriteList(text, "sags", pipe.sags, SagText);
  WriteList(text, "inlets", pipe.inlets, InletText);
  WriteList(text, "obstacles", pipe.obstacles, ObstacleText);
  WriteList(text, "faults", pipe.faults, FaultText);
}

}  // namespace

Network ParseYaml(const std::string& text, const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"name", "manholes", "pipes", "not_enterable", "remarks"});
  Network network;
  network.name = root["name"].Text();
  for (const YamlNode& manhole : root["manholes"].Elements()) {
    network.manholes.push_back(ReadManhole(manhole));
  }
  const std::vector<YamlNode> pipes = root["pipes"].Elements();
  for (const YamlNode& pipe : pipes) network.pipes.push_back(ReadPipe(pipe));
  ReadNotes(root, network);
  try {
    CheckNetwork(network);
    ReadJointPatterns(pipes, network);
    CheckNetwork(network);
  } catch (const Flaw& flaw) {
    throw InputError(name, NodeOf(root, flaw.field).line(), flaw.field, flaw.what());
  }
  return network;
}

std::string ToYaml(const Network& network) {
  std::string text = fmt::format("name: {}\nmanholes:\n", NameText(network.name));
  for (const Manhole& manhole : network.manholes) {
    text += fmt::format("  - {}\n", ManholeText(manhole));
  }
  text += "pipes:\n";
  const NetworkIndex index(network);
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    WritePipe(text, network.pipes[i], DesignLengthOf(network, index, i));
  }
  return text + NotesText(network);
}

}  // namespace kantaro::network
