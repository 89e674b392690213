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

namespace kantaro::network {
namespace {

// ---------------------------------------------------------------------------------------- reading

double Millimetres(const YamlNode& node) { return node.Number() / 1000.0; }

std::optional<double> MillimetresIfGiven(const YamlNode& node, std::string_view key) {
  const auto found = node.Find(key);
  return found ? std::optional<double>(Millimetres(*found)) : std::nullopt;
}

template <typename Enum>
Enum Word(const YamlNode& node) {
  if (const auto value = FromWord<Enum>(node.Text())) return *value;
  throw node.Error(fmt::format("\"{}\" is none of {}", node.Text().substr(0, 40),
                               fmt::join(kWords<Enum>, ", ")));
}

std::vector<YamlNode> ElementsIfGiven(const YamlNode& node, std::string_view key) {
  const auto found = node.Find(key);
  return found ? found->Elements() : std::vector<YamlNode>{};
}

Manhole ReadManhole(const YamlNode& node) {
  node.AllowOnly(
      {"name", "position_m", "depth_m", "shaft_diameter_mm", "bench_height", "channel_radius_mm"});
  Manhole manhole;
  manhole.name = node["name"].Text();
  const std::vector<double> position_m = node["position_m"].Numbers(3);
  manhole.p_WM = {position_m[0], position_m[1], position_m[2]};
  if (const auto depth = node.Find("depth_m")) manhole.depth_m = depth->Number();
  manhole.shaft_diameter_m = MillimetresIfGiven(node, "shaft_diameter_mm");
  manhole.channel_radius_m = MillimetresIfGiven(node, "channel_radius_mm");
  if (const auto bench = node.Find("bench_height"))
    manhole.bench_height = Word<BenchHeight>(*bench);
  return manhole;
}

Bend ReadBend(const YamlNode& node) {
  node.AllowOnly({"at_m", "radius_mm"});
  const std::vector<double> at_m = node["at_m"].Numbers(2);
  return {{at_m[0], at_m[1]}, Millimetres(node["radius_mm"])};
}

Joint ReadJoint(const YamlNode& node) {
  node.AllowOnly({"at_m", "gap_mm", "depth_mm"});
  Joint joint;
  joint.chainage_m = node["at_m"].Number();
  joint.gap_m = MillimetresIfGiven(node, "gap_mm").value_or(joint.gap_m);
  joint.depth_m = MillimetresIfGiven(node, "depth_mm").value_or(joint.depth_m);
  return joint;
}

Inlet ReadInlet(const YamlNode& node) {
  node.AllowOnly({"name", "at_m", "diameter_mm", "clock"});
  return {node["name"].Text(), node["at_m"].Number(), Millimetres(node["diameter_mm"]),
          node["clock"].Number()};
}

Fault ReadFault(const YamlNode& node) {
  node.AllowOnly({"name", "category", "rank", "at_m", "clock", "length_mm", "width_mm"});
  return {node["name"].Text(),           Word<FaultCategory>(node["category"]),
          Word<FaultRank>(node["rank"]), node["at_m"].Number(),
          node["clock"].Number(),        Millimetres(node["length_mm"]),
          Millimetres(node["width_mm"])};
}

Pipe ReadPipe(const YamlNode& node) {
  node.AllowOnly({"name", "from", "to", "diameter_mm", "material", "from_offset_mm", "to_offset_mm",
                  "bends", "joints", "inlets", "faults"});
  Pipe pipe;
  pipe.name = node["name"].Text();
  pipe.upstream = node["from"].Text();
  pipe.downstream = node["to"].Text();
  pipe.diameter_m = Millimetres(node["diameter_mm"]);
  pipe.material = Word<Material>(node["material"]);
  pipe.upstream_offset_m = MillimetresIfGiven(node, "from_offset_mm").value_or(0.0);
  pipe.downstream_offset_m = MillimetresIfGiven(node, "to_offset_mm").value_or(0.0);
  for (const YamlNode& bend : ElementsIfGiven(node, "bends")) pipe.bends.push_back(ReadBend(bend));
  for (const YamlNode& inlet : ElementsIfGiven(node, "inlets")) {
    pipe.inlets.push_back(ReadInlet(inlet));
  }
  for (const YamlNode& fault : ElementsIfGiven(node, "faults")) {
    pipe.faults.push_back(ReadFault(fault));
  }
  if (const auto joints = node.Find("joints"); joints && joints->IsSequence()) {
    for (const YamlNode& joint : joints->Elements()) pipe.joints.push_back(ReadJoint(joint));
  }
  return pipe;
}

/// Joints by pattern: they need the pipe's length, so the network must stand (and be checked)
/// first.
std::vector<Joint> ReadJointPattern(const YamlNode& node, double pipe_length_m) {
  node.AllowOnly({"first_m", "spacing_m", "gap_mm", "depth_mm"});
  JointPattern pattern;
  pattern.gap_m = MillimetresIfGiven(node, "gap_mm").value_or(pattern.gap_m);
  pattern.depth_m = MillimetresIfGiven(node, "depth_mm").value_or(pattern.depth_m);
  pattern.first_m = node["first_m"].Number(0.0, pipe_length_m);
  pattern.spacing_m = node["spacing_m"].Number();
  if (pattern.spacing_m < kShortestSpacing_m) {
    throw node["spacing_m"].Error(
        fmt::format("joints stand at least {} m apart", kShortestSpacing_m));
  }
  return LayJoints(pattern, pipe_length_m);
}

void ReadJointPatterns(const std::vector<YamlNode>& pipes, Network& network) {
  const NetworkIndex index(network);
  std::size_t joints = 0;
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    const auto node = pipes[i].Find("joints");
    if (!node || node->IsSequence()) continue;
    Pipe& pipe = network.pipes[i];
    const PipeAxis axis(network, index, i);
    pipe.joints = ReadJointPattern(*node, axis.length_m());
    joints += pipe.joints.size();
    if (joints > kMostJoints) {
      throw node->Error(fmt::format("a network has at most {} joints", kMostJoints));
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

/// A number of millimetres that reads back as the same number of metres.
std::string MillimetreText(double value_m) {
  double value_mm = value_m * 1000.0;
  for (const double candidate :
       {value_mm, std::nextafter(value_mm, -HUGE_VAL), std::nextafter(value_mm, HUGE_VAL)}) {
    if (candidate / 1000.0 == value_m) value_mm = candidate;
  }
  return fmt::format("{}", value_mm);
}

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
  text += fmt::format(", bench_height: {}", WordFor(manhole.bench_height));
  if (manhole.channel_radius_m) {
    text += fmt::format(", channel_radius_mm: {}", MillimetreText(*manhole.channel_radius_m));
  }
  return text + "}";
}

std::string BendText(const Bend& bend) {
  return fmt::format("{{at_m: [{}, {}], radius_mm: {}}}", bend.p_W.x(), bend.p_W.y(),
                     MillimetreText(bend.radius_m));
}

std::string JointText(const Joint& joint) {
  return fmt::format("{{at_m: {}, gap_mm: {}, depth_mm: {}}}", joint.chainage_m,
                     MillimetreText(joint.gap_m), MillimetreText(joint.depth_m));
}

std::string InletText(const Inlet& inlet) {
  return fmt::format("{{name: {}, at_m: {}, diameter_mm: {}, clock: {}}}", NameText(inlet.name),
                     inlet.chainage_m, MillimetreText(inlet.diameter_m), inlet.clock_h);
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
  const std::vector<Joint> laid = LayJoints(pattern, pipe_length_m);
  return std::equal(
      laid.begin(), laid.end(), joints.begin(), joints.end(), [](const Joint& a, const Joint& b) {
        return a.chainage_m == b.chainage_m && a.gap_m == b.gap_m && a.depth_m == b.depth_m;
      });
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

void WritePipe(std::string& text, const Pipe& pipe, double length_m) {
  text +=
      fmt::format("  - name: {}\n    from: {}\n    to: {}\n    diameter_mm: {}\n    material: {}\n",
                  NameText(pipe.name), NameText(pipe.upstream), NameText(pipe.downstream),
                  MillimetreText(pipe.diameter_m), WordFor(pipe.material));
  if (pipe.upstream_offset_m != 0.0) {
    text += fmt::format("    from_offset_mm: {}\n", MillimetreText(pipe.upstream_offset_m));
  }
  if (pipe.downstream_offset_m != 0.0) {
    text += fmt::format("    to_offset_mm: {}\n", MillimetreText(pipe.downstream_offset_m));
  }
  WriteList(text, "bends", pipe.bends, BendText);
  WriteJoints(text, pipe, length_m);
  WriteList(text, "inlets", pipe.inlets, InletText);
  WriteList(text, "faults", pipe.faults, FaultText);
}

/// What the format has no place for, as a comment: a reader of the file should still know.
std::string Preamble(const Network& network) {
  std::string text;
  const auto comment = [&](std::string line) {
    std::replace_if(
        line.begin(), line.end(),
        [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
    text += "# " + line + "\n";
  };
  for (const Remark& remark : network.remarks) comment(remark.subject + ": " + remark.text);
  for (const SkippedLink& link : network.skipped) {
    comment(fmt::format("left out {}: {}", link.name, link.reason));
  }
  return text;
}

}  // namespace

Network ParseYaml(const std::string& text, const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"name", "manholes", "pipes"});
  Network network;
  network.name = root["name"].Text();
  for (const YamlNode& manhole : root["manholes"].Elements()) {
    network.manholes.push_back(ReadManhole(manhole));
  }
  const std::vector<YamlNode> pipes = root["pipes"].Elements();
  for (const YamlNode& pipe : pipes) network.pipes.push_back(ReadPipe(pipe));
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
  std::string text = Preamble(network);
  text += fmt::format("name: {}\nmanholes:\n", NameText(network.name));
  for (const Manhole& manhole : network.manholes) {
    text += fmt::format("  - {}\n", ManholeText(manhole));
  }
  text += "pipes:\n";
  const NetworkIndex index(network);
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const PipeAxis axis(network, index, i);
    WritePipe(text, network.pipes[i], axis.length_m());
  }
  return text;
}

}  // namespace kantaro::network
