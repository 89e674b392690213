#include "network/swmm_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace kantaro::network::swmm {
namespace {

using Eigen::Vector2d;

constexpr double kFoot_m = 0.3048;
constexpr std::size_t kMostVertices = 1000;

double ToTenths(double value_m) { return std::round(value_m * 1e4) / 1e4; }

class Reader {
 public:
  Reader(const Text& text, const std::filesystem::path& file) : text_(text), file_(file) {}

  Model Read(std::string_view whole) {
    ReadOptions();
    ReadNodes();
    ReadConduits();
    ReadDevices();
    ReadShapes();
    ReadVertices();
    for (const auto& [line, name] : text_.unknown) {
      AddRemark(line, fmt::format("section [{}]", name), "unknown to SWMM, passed over");
    }
    DemandShapes();
    DemandWholeMap(whole);
    return std::move(model_);
  }

 private:
  void AddRemark(std::optional<int> line, std::string subject, std::string text) {
    model_.remarks.push_back({line, std::move(subject), std::move(text)});
  }

  // ---- options
  void ReadOptions();
  void ReadFlowUnits(const Row& row);
  void ReadOffsetKind(const Row& row);
  void ReadMapUnits(const Row& row);

  // ---- nodes
  void ReadNodes();
  void AddNode(const Row& row, bool has_depth, bool is_storage);

  // ---- links
  void ReadConduits();
  [[nodiscard]] double ReadOffset(const Row& row, std::size_t position, const char* column,
                                  const std::string& node);
  void ReadDevices();
  void AddLink(const Row& row, Link link);
  void ReadShapes();
  void ReadVertices();

  // ---- whole?
  void DemandShapes() const;
  void DemandWholeMap(std::string_view whole) const;

  const Text& text_;
  const std::filesystem::path& file_;
  Model model_;
};

void Reader::ReadFlowUnits(const Row& row) {
  const std::string value = Upper(row.Word(1, "FLOW_UNITS"));
  const bool us = value == "CFS" || value == "GPM" || value == "MGD";
  const bool si = value == "CMS" || value == "LPS" || value == "MLD";
  if (!us && !si) {
    throw row.Error("FLOW_UNITS",
                    fmt::format("\"{}\" is none of CFS, GPM, MGD, CMS, LPS, MLD", value));
  }
  model_.options.unit_m = us ? kFoot_m : 1.0;
}

void Reader::ReadOffsetKind(const Row& row) {
  const std::string value = Upper(row.Word(1, "LINK_OFFSETS"));
  if (value != "DEPTH" && value != "ELEVATION") {
    throw row.Error("LINK_OFFSETS", fmt::format("\"{}\" is neither DEPTH nor ELEVATION", value));
  }
  model_.options.offsets_are_elevations = value == "ELEVATION";
}

void Reader::ReadMapUnits(const Row& row) {
  const std::string value = Upper(row.Word(1, "UNITS"));
  MapUnits& units = model_.options.map_units;
  if (value == "DEGREES") units = MapUnits::kDegrees;
  if (value == "METERS") units = MapUnits::kMetres;
  if (value == "FEET") units = MapUnits::kFeet;
}

void Reader::ReadOptions() {
  for (const Row& row : text_.Rows("OPTIONS")) {
    const std::string key = Upper(row.words[0]);
    if (key == "FLOW_UNITS") ReadFlowUnits(row);
    if (key == "LINK_OFFSETS") ReadOffsetKind(row);
  }
  if (model_.options.unit_m == 0.0) {
    model_.options.unit_m = kFoot_m;
    AddRemark({}, "units", "no FLOW_UNITS are given: feet, as SWMM has it");
  }
  for (const Row& row : text_.Rows("MAP")) {
    if (Upper(row.words[0]) == "UNITS") ReadMapUnits(row);
  }
}

void Reader::AddNode(const Row& row, bool has_depth, bool is_storage) {
  const double unit_m = model_.options.unit_m;
  Node node;
  node.name = row.Name(0, "Name");
  node.line = row.line;
  node.elevation_m = ToMillimetres(row.Number(1, "Elevation") * unit_m);
  if (has_depth && row.words.size() > 2) {
    node.depth_m = ToMillimetres(row.Number(2, "MaxDepth") * unit_m);
  }
  node.is_storage = is_storage;
  if (!model_.node_of.emplace(node.name, model_.nodes.size()).second) {
    throw row.Error("Name", fmt::format("the node \"{}\" stands here a second time", node.name));
  }
  model_.nodes.push_back(std::move(node));
}

void Reader::ReadNodes() {
  for (const Row& row : text_.Rows("JUNCTIONS")) AddNode(row, true, false);
  for (const Row& row : text_.Rows("OUTFALLS")) AddNode(row, false, false);
  for (const Row& row : text_.Rows("STORAGE")) AddNode(row, true, true);
  for (const Row& row : text_.Rows("DIVIDERS")) AddNode(row, false, false);
  if (model_.nodes.empty()) {
    throw InputError(file_, std::nullopt, "JUNCTIONS",
                     "the file describes no node: no junction, outfall, storage or divider");
  }
  for (const Row& row : text_.Rows("COORDINATES")) {
    const Vector2d drawn(row.Number(1, "X"), row.Number(2, "Y"));
    const auto node = model_.node_of.find(row.words[0]);
    if (node != model_.node_of.end()) model_.nodes[node->second].drawn = drawn;
  }
  if (std::none_of(model_.nodes.begin(), model_.nodes.end(),
                   [](const Node& node) { return node.drawn.has_value(); })) {
    throw InputError(file_, std::nullopt, "COORDINATES",
                     "no node has coordinates, so there is no map to be had from the file");
  }
}

/// An offset as given: a height above the node's invert, an elevation, or * or nothing for none.
double Reader::ReadOffset(const Row& row, std::size_t position, const char* column,
                          const std::string& node) {
  if (position >= row.words.size() || row.words[position] == "*") return 0.0;
  const double value_m = row.Number(position, column) * model_.options.unit_m;
  if (!model_.options.offsets_are_elevations) return ToMillimetres(value_m);
  const auto found = model_.node_of.find(node);
  if (found == model_.node_of.end()) return 0.0;
  return ToMillimetres(value_m - model_.nodes[found->second].elevation_m);
}

/// SWMM keeps all links under one roof, whatever their kind.
void Reader::AddLink(const Row& row, Link link) {
  link.name = row.Name(0, "Name");
  link.from = row.Name(1, "FromNode");
  link.to = row.Name(2, "ToNode");
  link.line = row.line;
  if (!model_.link_of.emplace(link.name, model_.links.size()).second) {
    throw row.Error("Name", fmt::format("the link \"{}\" stands here a second time", link.name));
  }
  model_.links.push_back(std::move(link));
}

void Reader::ReadConduits() {
  for (const Row& row : text_.Rows("CONDUITS")) {
    Link conduit;
    const std::string from = row.Word(1, "FromNode"), to = row.Word(2, "ToNode");
    conduit.length_m = row.Positive(3, "Length") * model_.options.unit_m;
    conduit.roughness = row.Number(4, "Roughness");
    conduit.from_offset_m = ReadOffset(row, 5, "InOffset", from);
    conduit.to_offset_m = ReadOffset(row, 6, "OutOffset", to);
    if (row.words.size() < 7) {
      AddRemark(row.line, "conduit " + row.Word(0, "Name"), "an offset is not given, 0 is assumed");
    }
    AddLink(row, std::move(conduit));
  }
  if (model_.links.empty()) {
    throw InputError(file_, std::nullopt, "CONDUITS", "the file describes no conduit");
  }
}

void Reader::ReadDevices() {
  static constexpr std::array<std::pair<std::string_view, const char*>, 4> kDevices{
      {{"PUMPS", "a pump"},
       {"ORIFICES", "an orifice"},
       {"WEIRS", "a weir"},
       {"OUTLETS", "an outlet"}}};
  for (const auto& [section, device] : kDevices) {
    for (const Row& row : text_.Rows(section)) {
      Link link;
      link.device = device;
      AddLink(row, std::move(link));
    }
  }
}

void Reader::ReadShapes() {
  static constexpr std::string_view kNamedShapes[] = {"IRREGULAR", "STREET"};  // by a transect
  for (const Row& row : text_.Rows("XSECTIONS")) {
    const std::string shape = Quotable(Upper(row.Word(1, "Shape")));
    const auto found = model_.link_of.find(row.words[0]);
    if (found == model_.link_of.end()) continue;
    Link& link = model_.links[found->second];
    if (!link.device.empty()) continue;  // the mouth of an orifice or a weir
    link.shape = shape;
    const double unit_m = model_.options.unit_m;
    if (shape == "CIRCULAR") {
      link.height_m = ToTenths(row.Positive(2, "Geom1") * unit_m);
    } else if (shape != "DUMMY" && row.words.size() > 2 &&
               std::find(std::begin(kNamedShapes), std::end(kNamedShapes), shape) ==
                   std::end(kNamedShapes)) {
      link.height_m = std::max(0.0, ToTenths(row.Number(2, "Geom1") * unit_m));
    }
    if (shape == "CIRCULAR" && row.words.size() > 6) link.barrels = row.Number(6, "Barrels");
  }
}

void Reader::ReadVertices() {
  for (const Row& row : text_.Rows("VERTICES")) {
    const Vector2d drawn(row.Number(1, "X"), row.Number(2, "Y"));
    const auto found = model_.link_of.find(row.words[0]);
    if (found == model_.link_of.end()) continue;
    std::vector<Vector2d>& vertices = model_.links[found->second].vertices;
    if (vertices.size() == kMostVertices) {
      throw row.Error("Link", fmt::format("a link has at most {} vertices", kMostVertices));
    }
    vertices.push_back(drawn);
  }
}

/// A conduit without a cross-section is an error in SWMM too, and the trace of a file cut short.
void Reader::DemandShapes() const {
  for (const Link& link : model_.links) {
    if (!link.device.empty() || !link.shape.empty()) continue;
    throw InputError(
        file_, link.line, "XSECTIONS",
        fmt::format("conduit \"{}\" has no cross-section: the file may have been cut", link.name));
  }
}

/// Coordinates come late in a file: one that stops in the middle of their rows was cut.
void Reader::DemandWholeMap(std::string_view whole) const {
  const bool all_drawn = std::all_of(model_.nodes.begin(), model_.nodes.end(),
                                     [](const Node& node) { return node.drawn.has_value(); });
  const std::size_t last = whole.rfind("\n[");
  if (all_drawn || whole.ends_with('\n') || last == std::string_view::npos) return;
  if (!Upper(whole.substr(last + 1, 6)).starts_with("[COORD")) return;
  throw InputError(file_, static_cast<int>(std::count(whole.begin(), whole.end(), '\n')) + 1,
                   "COORDINATES",
                   "the file stops here in the middle of a row, nodes lack coordinates");
}

}  // namespace

double ToMillimetres(double value_m) { return std::round(value_m * 1e3) / 1e3; }

const Node* Model::Drawn(std::string_view node) const {
  const auto found = node_of.find(node);
  if (found == node_of.end() || !nodes[found->second].drawn) return nullptr;
  return &nodes[found->second];
}

Model ReadModel(const Text& text, std::string_view whole, const std::filesystem::path& file) {
  return Reader(text, file).Read(whole);
}

}  // namespace kantaro::network::swmm
