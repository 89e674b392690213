#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <utility>

#include "network/formats.hpp"
#include "network/names.hpp"
#include "network/network_index.hpp"
#include "network/pipe_axis.hpp"
#include "network/topology.hpp"

namespace kantaro::network {
namespace {

constexpr std::size_t kNamedSubjects = 4;  // of a remark or reason that many things share

struct Extent {
  std::size_t pipes{};
  double length_m{};

  void Add(double more_m) {
    ++pipes;
    length_m += more_m;
  }
};

/// Things of which the same is said, in the order of first mention.
struct Group {
  std::string text;
  std::vector<std::string> subjects;
  double length_m{};
};

/// Things of one kind, with the smallest and largest of the size a person would ask for.
struct Element {
  const char* name;
  const char* size;  ///< what is measured
  const char* unit;
  double per_unit;  ///< of ours
  std::size_t count{};
  double smallest{}, largest{};

  void Add(double value) {
    smallest = count == 0 ? value : std::min(smallest, value);
    largest = count == 0 ? value : std::max(largest, value);
    ++count;
  }
  void AddIfAny(double value) {
    if (value > 0.0) Add(value);
  }
};

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Everything a sewer may hold besides pipes and manholes.
struct Elements {
  Element shafts{"given shafts", "diameter", "mm", 1000};
  Element channels{"given channels", "radius", "mm", 1000};
  Element benches{"given benches", "height", "mm", 1000};
  Element drops{"drops", "height", "mm", 1000};
  Element bends{"bends", "radius", "mm", 1000};
  Element changes{"diameter changes", "step", "mm", 1000};
  Element joints{"joints", "gap", "mm", 1000};
  Element offsets{"joint offsets", "offset", "mm", 1000};
  Element deflections{"joint deflections", "angle", "deg", kDegrees};
  Element sags{"sags", "depth", "mm", 1000};
  Element inlets{"inlets", "diameter", "mm", 1000};
  Element slanted{"slanted inlets", "angle", "deg", kDegrees};
  Element protruding{"protruding inlets", "protrusion", "mm", 1000};
  Element water{"pipes with water", "depth", "mm", 1000};
  std::array<Element, 4> obstacles{{{"sediment", "height", "mm", 1000},
                                    {"stones", "height", "mm", 1000},
                                    {"mortar ridges", "height", "mm", 1000},
                                    {"bricks", "height", "mm", 1000}}};

  void Add(const Manhole& manhole);
  void Add(const Pipe& pipe);
  [[nodiscard]] std::vector<const Element*> All() const {
    std::vector<const Element*> all{&shafts,  &channels, &benches,    &drops,       &bends,
                                    &changes, &joints,   &offsets,    &deflections, &sags,
                                    &inlets,  &slanted,  &protruding, &water};
    for (const Element& obstacle : obstacles) all.push_back(&obstacle);
    return all;
  }
};

void Elements::Add(const Manhole& manhole) {
  if (manhole.shaft_diameter_m) shafts.Add(*manhole.shaft_diameter_m);
  if (manhole.channel_radius_m) channels.Add(*manhole.channel_radius_m);
  if (manhole.bench_height == BenchHeight::kGiven) benches.Add(manhole.given_bench_m);
}

void Elements::Add(const Pipe& pipe) {
  drops.AddIfAny(pipe.upstream_offset_m);
  drops.AddIfAny(pipe.downstream_offset_m);
  for (const Bend& bend : pipe.bends) bends.Add(bend.radius_m);
  double diameter_m = pipe.diameter_m;
  for (const DiameterChange& change : pipe.diameter_changes) {
    changes.Add(std::abs(change.diameter_m - diameter_m));
    diameter_m = change.diameter_m;
  }
  for (const Joint& joint : pipe.joints) {
    joints.Add(joint.gap_m);
    offsets.AddIfAny(joint.offset_m);
    deflections.AddIfAny(joint.deflection_rad);
  }
  for (const Sag& sag : pipe.sags) sags.Add(sag.depth_m);
  for (const Inlet& inlet : pipe.inlets) {
    inlets.Add(inlet.diameter_m);
    if (inlet.angle_rad != Inlet{}.angle_rad) slanted.Add(inlet.angle_rad);
    protruding.AddIfAny(inlet.protrusion_m);
  }
  water.AddIfAny(pipe.water_m);
  for (const Obstacle& obstacle : pipe.obstacles) {
    obstacles.at(static_cast<std::size_t>(obstacle.kind)).Add(obstacle.height_m);
  }
}

struct Summary {
  Extent all, enterable, not_enterable;
  std::map<long, Extent> by_diameter_mm;
  std::map<std::pair<Material, WallCondition>, Extent> by_wall;
  std::map<ManholeKind, std::size_t> manholes;
  std::map<BenchHeight, std::size_t> benching;
  std::map<FaultCategory, std::size_t> faults;
  std::size_t fault_count{};
  Elements elements;
  std::vector<Group> skipped, remarks;
};

void AddTo(std::vector<Group>& groups, std::map<std::string, std::size_t>& position,
           const std::string& text, const std::string& subject, double length_m = 0.0) {
  const auto [place, is_new] = position.emplace(text, groups.size());
  if (is_new) groups.push_back({text, {}, 0.0});
  groups[place->second].subjects.push_back(subject);
  groups[place->second].length_m += length_m;
}

/// A pipe counts for every diameter it has, with the length it has it over.
void AddByDiameter(const Pipe& pipe, double length_m, std::map<long, Extent>& by_diameter_mm) {
  std::map<long, double> lengths_m;
  double from_m = 0.0;
  long diameter_mm = std::lround(pipe.diameter_m * 1000);
  for (const DiameterChange& change : pipe.diameter_changes) {
    lengths_m[diameter_mm] += change.chainage_m - from_m;
    from_m = change.chainage_m;
    diameter_mm = std::lround(change.diameter_m * 1000);
  }
  lengths_m[diameter_mm] += length_m - from_m;
  for (const auto& [size_mm, part_m] : lengths_m) by_diameter_mm[size_mm].Add(part_m);
}

Summary Summarise(const Network& network) {
  Summary summary;
  const NetworkIndex index(network);
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const Pipe& pipe = network.pipes[i];
    const double length_m = PipeAxis(network, index, i).length_m();
    summary.all.Add(length_m);
    if (IsEnterable(pipe)) summary.enterable.Add(length_m);
    AddByDiameter(pipe, length_m, summary.by_diameter_mm);
    summary.by_wall[{pipe.material, pipe.condition}].Add(length_m);
    summary.elements.Add(pipe);
    summary.fault_count += pipe.faults.size();
    for (const Fault& fault : pipe.faults) ++summary.faults[fault.category];
  }
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    ++summary.manholes[KindOf(network, index, i)];
    ++summary.benching[network.manholes[i].bench_height];
    summary.elements.Add(network.manholes[i]);
  }
  std::map<std::string, std::size_t> reasons, texts;
  for (const SkippedLink& link : network.skipped) {
    // What follows the colon differs from link to link: "not circular: RECT_CLOSED".
    AddTo(summary.skipped, reasons, link.reason.substr(0, link.reason.find(':')), link.name,
          link.length_m);
    summary.not_enterable.Add(link.length_m);
  }
  for (const Remark& remark : network.remarks) {
    AddTo(summary.remarks, texts, remark.text, remark.subject);
  }
  return summary;
}

/// 47208.2 as "47.21 km", 29.3 as "29.3 m".
std::string LengthText(double length_m) {
  if (length_m >= 1000.0) return fmt::format("{:.2f} km", length_m / 1000.0);
  return fmt::format("{:.1f} m", length_m);
}

std::string SubjectsText(const std::vector<std::string>& subjects) {
  const auto named =
      subjects.begin() + static_cast<std::ptrdiff_t>(std::min(subjects.size(), kNamedSubjects));
  std::string text = fmt::format("{}", fmt::join(subjects.begin(), named, ", "));
  if (subjects.size() > kNamedSubjects) {
    text += fmt::format(" and {} more", subjects.size() - kNamedSubjects);
  }
  return text;
}

std::string_view BenchWord(BenchHeight height) {
  return height == BenchHeight::kGiven ? "given" : WordFor(height);
}

/// 10 as "10", 1.5 as "1.5", 32.73 as "32.7".
std::string SizeText(double value) { return fmt::format("{}", std::round(value * 10) / 10); }

std::string ElementText(const Element& element) {
  std::string text = fmt::format("  {:<18}{:>6}", element.name, element.count);
  if (element.count == 0) return text + "\n";
  const std::string from = SizeText(element.smallest * element.per_unit);
  const std::string to = SizeText(element.largest * element.per_unit);
  text += fmt::format("  {} {}", element.size, from);
  if (from != to) text += " to " + to;
  return text + fmt::format(" {}\n", element.unit);
}

std::string FaultsText(const Summary& summary) {
  std::string text = fmt::format("  {:<18}{:>6}", "planted faults", summary.fault_count);
  std::vector<std::string> parts;
  for (const auto& [category, count] : summary.faults) {
    parts.push_back(fmt::format("{} {}", count, WordFor(category)));
  }
  return parts.empty() ? text + "\n" : text + fmt::format("  {}\n", fmt::join(parts, ", "));
}

/// One row of the tables: a label, a count and a length, in columns.
std::string RowText(const std::string& label, const Extent& extent, const std::string& note = "") {
  const std::string row =
      fmt::format("  {:<16}{:>8} {} {:>12}", label, extent.pipes,
                  extent.pipes == 1 ? "pipe " : "pipes", LengthText(extent.length_m));
  return (note.empty() ? row : row + "  " + note) + "\n";
}

/// {"count": 3, "offset_mm": [6, 10]}
nlohmann::ordered_json ElementJson(const Element& element) {
  nlohmann::ordered_json json{{"count", element.count}};
  if (element.count > 0) {
    json[fmt::format("{}_{}", element.size, element.unit)] = {element.smallest * element.per_unit,
                                                              element.largest * element.per_unit};
  }
  return json;
}

std::string Key(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

nlohmann::ordered_json ExtentJson(const Extent& extent) {
  return {{"pipes", extent.pipes}, {"length_m", extent.length_m}};
}

}  // namespace

std::string Describe(const Network& network) {
  const Summary summary = Summarise(network);
  std::string text = network.name + "\n\n";
  text += RowText("in all", summary.all);
  text += RowText(
      "KANTARO enters", summary.enterable,
      fmt::format("{:.0f} to {:.0f} mm", kSmallestEnterable_m * 1000, kLargestEnterable_m * 1000));
  text += "\nby diameter\n";
  for (const auto& [diameter_mm, extent] : summary.by_diameter_mm) {
    text += RowText(fmt::format("{:>5} mm", diameter_mm), extent);
  }
  text += "\nby material\n";
  for (const auto& [wall, extent] : summary.by_wall) {
    text += RowText(fmt::format("{}, {}", WordFor(wall.first), WordFor(wall.second)), extent);
  }
  text += fmt::format("\nmanholes        {:>10}\n", network.manholes.size());
  for (const auto& [kind, count] : summary.manholes) {
    text += fmt::format("  {:<16}{:>8}\n", ToString(kind), count);
  }
  text += "\nbenching\n";
  for (const auto& [height, count] : summary.benching) {
    text += fmt::format("  {:<16}{:>8}\n", BenchWord(height), count);
  }
  text += "\nelements\n";
  for (const Element* element : summary.elements.All()) {
    if (element->count > 0) text += ElementText(*element);
  }
  text += FaultsText(summary);
  if (!network.skipped.empty()) {
    text += fmt::format("\nin the map, not built {:>5} {} {:>12}\n", network.skipped.size(),
                        network.skipped.size() == 1 ? "link " : "links",
                        LengthText(summary.not_enterable.length_m));
    for (const Group& group : summary.skipped) {
      text += fmt::format("  {:>6} {:>12}  {}: {}\n", group.subjects.size(),
                          LengthText(group.length_m), group.text, SubjectsText(group.subjects));
    }
  }
  if (!network.remarks.empty()) {
    text += "\nfilled in or changed\n";
    for (const Group& group : summary.remarks) {
      text += fmt::format("  {}: {}\n", SubjectsText(group.subjects), group.text);
    }
  }
  return text;
}

std::string DescribeJson(const Network& network) {
  const Summary summary = Summarise(network);
  nlohmann::ordered_json json;
  json["name"] = network.name;
  json["manholes"]["count"] = network.manholes.size();
  for (const auto& [kind, count] : summary.manholes) json["manholes"][ToString(kind)] = count;
  for (const auto& [height, count] : summary.benching) {
    json["manholes"]["bench_height"][std::string(BenchWord(height))] = count;
  }
  json["all"] = ExtentJson(summary.all);
  json["enterable"] = ExtentJson(summary.enterable);
  json["diameters"] = nlohmann::ordered_json::array();
  for (const auto& [diameter_mm, extent] : summary.by_diameter_mm) {
    nlohmann::ordered_json row = ExtentJson(extent);
    row["diameter_mm"] = diameter_mm;
    json["diameters"].push_back(row);
  }
  json["materials"] = nlohmann::ordered_json::array();
  for (const auto& [wall, extent] : summary.by_wall) {
    nlohmann::ordered_json row = ExtentJson(extent);
    row["material"] = WordFor(wall.first);
    row["condition"] = WordFor(wall.second);
    json["materials"].push_back(row);
  }
  for (const Element* element : summary.elements.All()) {
    json["elements"][Key(element->name)] = ElementJson(*element);
  }
  json["joints"] = summary.elements.joints.count;
  json["inlets"] = summary.elements.inlets.count;
  json["faults"] = {{"count", summary.fault_count}};
  for (const auto& [category, count] : summary.faults) {
    json["faults"][std::string(WordFor(category))] = count;
  }
  json["skipped"] = nlohmann::ordered_json::array();
  for (const SkippedLink& link : network.skipped) {
    nlohmann::ordered_json row = {{"name", link.name},
                                  {"from", link.upstream},
                                  {"to", link.downstream},
                                  {"reason", link.reason},
                                  {"length_m", link.length_m}};
    if (link.height_m > 0.0) row["height_mm"] = link.height_m * 1000.0;
    json["skipped"].push_back(row);
  }
  json["remarks"] = nlohmann::ordered_json::array();
  for (const Remark& remark : network.remarks) {
    nlohmann::ordered_json row = {{"subject", remark.subject}, {"text", remark.text}};
    if (remark.line) row["line"] = *remark.line;
    json["remarks"].push_back(row);
  }
  return json.dump(2) + "\n";
}

}  // namespace kantaro::network
