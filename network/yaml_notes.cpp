#include "network/yaml_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "network/yaml_units.hpp"

namespace kantaro::network {
namespace {

constexpr double kLargest = 1e13;  // in any unit: beyond all that SWMM's numbers come to
constexpr std::size_t kLongestText = 2000;

std::string Words(const YamlNode& node) {
  std::string text = node.Text();
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
  });
  if (!printable || text.size() > kLongestText) {
    throw node.Error(fmt::format("up to {} printable characters are wanted here", kLongestText));
  }
  return text;
}

double LengthIfGiven(const YamlNode& node, std::string_view key) {
  const auto found = node.Find(key);
  return found ? found->Number(0.0, kLargest) : 0.0;
}

SkippedLink ReadSkippedLink(const YamlNode& node) {
  node.AllowOnly({"name", "from", "to", "reason", "length_m", "height_mm", "via_m"});
  SkippedLink link;
  link.name = Words(node["name"]);
  link.upstream = Words(node["from"]);
  link.downstream = Words(node["to"]);
  link.reason = Words(node["reason"]);
  link.length_m = LengthIfGiven(node, "length_m");
  if (LengthIfGiven(node, "height_mm") > 0.0) link.height_m = Millimetres(node["height_mm"]);
  if (const auto via = node.Find("via_m")) {
    for (const YamlNode& corner : via->Elements()) {
      const std::vector<double> p_W = corner.Numbers(2);
      link.via_W.emplace_back(p_W[0], p_W[1]);
    }
  }
  return link;
}

Remark ReadRemark(const YamlNode& node) {
  node.AllowOnly({"line", "about", "text"});
  Remark remark;
  if (const auto line = node.Find("line")) {
    remark.line = static_cast<int>(line->Integer(1, std::numeric_limits<int>::max()));
  }
  remark.subject = Words(node["about"]);
  remark.text = Words(node["text"]);
  return remark;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return quoted + '"';
}

std::string SkippedLinkText(const SkippedLink& link) {
  std::string text =
      fmt::format("  - {{name: {}, from: {}, to: {}, reason: {}", Quoted(link.name),
                  Quoted(link.upstream), Quoted(link.downstream), Quoted(link.reason));
  if (link.length_m > 0.0) text += fmt::format(", length_m: {}", link.length_m);
  if (link.height_m > 0.0) text += fmt::format(", height_mm: {}", MillimetreText(link.height_m));
  if (!link.via_W.empty()) {
    std::vector<std::string> corners;
    for (const Eigen::Vector2d& p_W : link.via_W) {
      corners.push_back(fmt::format("[{}, {}]", p_W.x(), p_W.y()));
    }
    text += fmt::format(", via_m: [{}]", fmt::join(corners, ", "));
  }
  return text + "}\n";
}

std::string RemarkText(const Remark& remark) {
  const std::string line = remark.line ? fmt::format("line: {}, ", *remark.line) : "";
  return fmt::format("  - {{{}about: {}, text: {}}}\n", line, Quoted(remark.subject),
                     Quoted(remark.text));
}

}  // namespace

void ReadNotes(const YamlNode& root, Network& network) {
  if (const auto links = root.Find("not_enterable")) {
    for (const YamlNode& link : links->Elements()) {
      network.skipped.push_back(ReadSkippedLink(link));
    }
  }
  if (const auto remarks = root.Find("remarks")) {
    for (const YamlNode& remark : remarks->Elements()) {
      network.remarks.push_back(ReadRemark(remark));
    }
  }
}

std::string NotesText(const Network& network) {
  std::string text;
  if (!network.skipped.empty()) text += "not_enterable:\n";
  for (const SkippedLink& link : network.skipped) text += SkippedLinkText(link);
  if (!network.remarks.empty()) text += "remarks:\n";
  for (const Remark& remark : network.remarks) text += RemarkText(remark);
  return text;
}

}  // namespace kantaro::network
