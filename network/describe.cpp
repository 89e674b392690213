#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

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

struct Summary {
  Extent all, enterable, not_enterable;
  std::map<long, Extent> by_diameter_mm;
  std::map<ManholeKind, std::size_t> manholes;
  std::map<FaultCategory, std::size_t> faults;
  std::size_t joints{}, inlets{}, fault_count{};
  std::vector<Group> skipped, remarks;
};

void AddTo(std::vector<Group>& groups, std::map<std::string, std::size_t>& position,
           const std::string& text, const std::string& subject, double length_m = 0.0) {
  const auto [place, is_new] = position.emplace(text, groups.size());
  if (is_new) groups.push_back({text, {}, 0.0});
  groups[place->second].subjects.push_back(subject);
  groups[place->second].length_m += length_m;
}

Summary Summarise(const Network& network) {
  Summary summary;
  const NetworkIndex index(network);
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const Pipe& pipe = network.pipes[i];
    const double length_m = PipeAxis(network, index, i).length_m();
    summary.all.Add(length_m);
    if (IsEnterable(pipe)) summary.enterable.Add(length_m);
    summary.by_diameter_mm[std::lround(pipe.diameter_m * 1000)].Add(length_m);
    summary.joints += pipe.joints.size();
    summary.inlets += pipe.inlets.size();
    summary.fault_count += pipe.faults.size();
    for (const Fault& fault : pipe.faults) ++summary.faults[fault.category];
  }
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    ++summary.manholes[KindOf(network, index, i)];
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

std::string CountsText(const Summary& summary) {
  std::string text = fmt::format("joints {}, inlets {}, planted faults {}", summary.joints,
                                 summary.inlets, summary.fault_count);
  std::vector<std::string> parts;
  for (const auto& [category, count] : summary.faults) {
    parts.push_back(fmt::format("{} {}", count, WordFor(category)));
  }
  return parts.empty() ? text : text + fmt::format(" ({})", fmt::join(parts, ", "));
}

/// One row of the tables: a label, a count and a length, in columns.
std::string RowText(const std::string& label, const Extent& extent, const std::string& note = "") {
  const std::string row =
      fmt::format("  {:<16}{:>8} {} {:>12}", label, extent.pipes,
                  extent.pipes == 1 ? "pipe " : "pipes", LengthText(extent.length_m));
  return (note.empty() ? row : row + "  " + note) + "\n";
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
  text += fmt::format("\nmanholes        {:>10}\n", network.manholes.size());
  for (const auto& [kind, count] : summary.manholes) {
    text += fmt::format("  {:<16}{:>8}\n", ToString(kind), count);
  }
  text += "\n" + CountsText(summary) + "\n";
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
  json["all"] = ExtentJson(summary.all);
  json["enterable"] = ExtentJson(summary.enterable);
  json["diameters"] = nlohmann::ordered_json::array();
  for (const auto& [diameter_mm, extent] : summary.by_diameter_mm) {
    nlohmann::ordered_json row = ExtentJson(extent);
    row["diameter_mm"] = diameter_mm;
    json["diameters"].push_back(row);
  }
  json["joints"] = summary.joints;
  json["inlets"] = summary.inlets;
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
