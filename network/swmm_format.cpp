#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

#include "base/input_error.hpp"
#include "network/check.hpp"
#include "network/formats.hpp"
#include "network/joints.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {
namespace {

using Eigen::Vector2d;

constexpr double kFoot_m = 0.3048;
constexpr double kJointSpacing_m = 1.8;  // plastic and clay pipe come in lengths under 2 m
constexpr double kDefaultDepth_m = 2.0;
constexpr double kBendRadii = 1.5;  // of a vertex, in pipe diameters
constexpr double kSameScale =
    0.05;  // map and lengths may differ this much before the map is scaled
constexpr double kSmoothBelow = 0.012;   // Manning's n: plastic below, concrete above
constexpr double kSharpestVertex = 2.5;  // [rad]
constexpr std::size_t kMostVertices = 1000;

// ------------------------------------------------------------------------------------ the text
// file

/// One row of a section.
struct Row {
  const std::filesystem::path* file;
  std::string_view section;
  int line;
  std::vector<std::string_view> words;

  [[nodiscard]] InputError Error(std::string_view column, const std::string& problem) const {
    return InputError(*file, line, fmt::format("{}.{}", section, column), problem);
  }
  [[nodiscard]] std::string Word(std::size_t position, std::string_view column) const {
    if (position < words.size()) return std::string(words[position]);
    throw Error(column, fmt::format("the row ends before this column, it has {} of the {} wanted",
                                    words.size(), position + 1));
  }
  [[nodiscard]] double Number(std::size_t position, std::string_view column) const {
    const std::string word = Word(position, column);
    const char* first = word.data() + (word.starts_with('+') ? 1 : 0);
    double value = 0.0;
    const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
    // Beyond 1e9 in any unit it is no length, and sums of such would overflow.
    if (error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= 1e9)) {
      throw Error(column, fmt::format("\"{}\" is not a number", word.substr(0, 40)));
    }
    return value;
  }
  [[nodiscard]] double Positive(std::size_t position, std::string_view column) const {
    const double value = Number(position, column);
    if (value > 0.0) return value;
    throw Error(column, fmt::format("{} must be above 0", value));
  }
};

using Sections = std::map<std::string, std::vector<Row>, std::less<>>;

constexpr std::array<std::string_view, 14> kRead{
    "OPTIONS", "MAP",      "JUNCTIONS", "OUTFALLS", "STORAGE",   "DIVIDERS",    "CONDUITS",
    "PUMPS",   "ORIFICES", "WEIRS",     "OUTLETS",  "XSECTIONS", "COORDINATES", "VERTICES"};

std::string Upper(std::string_view word) {
  std::string upper(word);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return upper;
}

/// Words between blanks, or between double quotes, up to a semicolon.
std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size() && line[at] != ';';) {
    if (std::isspace(static_cast<unsigned char>(line[at])) != 0) {
      ++at;
      continue;
    }
    const bool quoted = line[at] == '"';
    if (quoted) ++at;
    const std::size_t end =
        std::min(line.find_first_of(quoted ? "\"" : " \t\r\f\v;", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = quoted ? std::min(end + 1, line.size()) : end;
  }
  return words;
}

std::string SectionName(std::string_view line, int number, const std::filesystem::path& file) {
  const std::size_t end = line.find(']');
  if (end == std::string_view::npos) {
    throw InputError(file, number, std::string(line.substr(0, 40)),
                     "a section's heading ends with ]: the file may have been cut here");
  }
  return Upper(line.substr(1, end - 1));
}

Sections Split(std::string_view text, const std::filesystem::path& file) {
  Sections sections;
  const std::string_view* section = nullptr;
  bool any = false;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with('[')) {
      const std::string name = SectionName(line, number, file);
      const auto known = std::find(kRead.begin(), kRead.end(), name);
      section = known == kRead.end() ? nullptr : &*known;
      any = true;
    } else if (section != nullptr) {
      std::vector<std::string_view> words = Words(line);
      if (!words.empty()) {
        sections[std::string(*section)].push_back({&file, *section, number, std::move(words)});
      }
    } else if (!any && !Words(line).empty()) {
      throw InputError(file, number, "",
                       "this is no SWMM file: it begins before the first [SECTION]");
    }
  }
  return sections;
}

const std::vector<Row>& RowsOf(const Sections& sections, std::string_view name) {
  static const std::vector<Row> kNone;
  const auto found = sections.find(name);
  return found == sections.end() ? kNone : found->second;
}

bool IsAscii(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// SWMM on Windows writes Latin-1: names are kept as UTF-8.
std::string FromLatin1(std::string_view text) {
  std::string utf8;
  utf8.reserve(text.size());
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      utf8 += c;
    } else {
      utf8 += static_cast<char>(0xC0 | (code >> 6));
      utf8 += static_cast<char>(0x80 | (code & 0x3F));
    }
  }
  return utf8;
}

std::string Cleaned(const std::string& text, const std::filesystem::path& file) {
  const auto control = std::find_if(text.begin(), text.end(), [](unsigned char c) {
    return (c < 0x20 && c != '\n' && c != '\r' && c != '\t' && c != '\f' && c != 0x1a) || c == 0x7f;
  });
  if (control != text.end()) {
    throw InputError(file, static_cast<int>(std::count(text.begin(), control, '\n')) + 1, "",
                     "holds a control character, so it is no SWMM text");
  }
  std::string clean = text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
  std::replace(clean.begin(), clean.end(), '\x1a',
               ' ');  // the end-of-file mark of old DOS programs
  return IsAscii(clean) || IsUtf8(clean) ? clean : FromLatin1(clean);
}

// -------------------------------------------------------------------------------- what it
// describes

struct Options {
  double unit_m{kFoot_m};  // length of the file's unit; SWMM's default is CFS, so feet
  bool offsets_are_elevations{};
};

Options ReadOptions(const Sections& sections) {
  Options options;
  for (const Row& row : RowsOf(sections, "OPTIONS")) {
    const std::string key = Upper(row.words[0]);
    if (key != "FLOW_UNITS" && key != "LINK_OFFSETS") continue;
    const std::string value = Upper(row.Word(1, key));
    if (key == "FLOW_UNITS") {
      const bool us = value == "CFS" || value == "GPM" || value == "MGD";
      const bool si = value == "CMS" || value == "LPS" || value == "MLD";
      if (!us && !si) {
        throw row.Error(key, fmt::format("\"{}\" is none of CFS, GPM, MGD, CMS, LPS, MLD", value));
      }
      options.unit_m = us ? kFoot_m : 1.0;
    } else {
      if (value != "DEPTH" && value != "ELEVATION") {
        throw row.Error(key, fmt::format("\"{}\" is neither DEPTH nor ELEVATION", value));
      }
      options.offsets_are_elevations = value == "ELEVATION";
    }
  }
  for (const Row& row : RowsOf(sections, "MAP")) {
    if (Upper(row.words[0]) == "UNITS" && Upper(row.Word(1, "UNITS")) == "DEGREES") {
      throw row.Error("UNITS",
                      "coordinates in degrees are not read, project them to metres or feet");
    }
  }
  return options;
}

struct Node {
  std::string name;
  int line{};
  double elevation_m{};
  double depth_m{};               // 0: not given
  std::optional<Vector2d> drawn;  // map units
};

struct Conduit {
  std::string name, from, to;
  int line{};
  double length_m{};
  double roughness{};
  double from_offset_m{}, to_offset_m{};
  std::string shape;
  double diameter_m{};             // if the shape is CIRCULAR
  std::vector<Vector2d> vertices;  // map units
};

struct Model {
  std::vector<Node> nodes;
  std::map<std::string, std::size_t, std::less<>> node_of;
  std::vector<Conduit> conduits;
  std::map<std::string, std::size_t, std::less<>> conduit_of;
};

/// To the nearest tenth of a millimetre or millimetre, as the decimal number that a person would
/// write.
double ToTenths(double value_m) { return std::round(value_m * 1e4) / 1e4; }
double ToMillimetres(double value_m) { return std::round(value_m * 1e3) / 1e3; }

void ReadNodes(const Sections& sections, const Options& options, Model& model) {
  for (const std::string_view section : {"JUNCTIONS", "OUTFALLS", "STORAGE", "DIVIDERS"}) {
    const bool has_depth = section == "JUNCTIONS" || section == "STORAGE";
    for (const Row& row : RowsOf(sections, section)) {
      Node node;
      node.name = row.Word(0, "Name");
      node.line = row.line;
      node.elevation_m = ToMillimetres(row.Number(1, "Elevation") * options.unit_m);
      if (has_depth && row.words.size() > 2) {
        node.depth_m = ToMillimetres(row.Number(2, "MaxDepth") * options.unit_m);
      }
      if (!model.node_of.emplace(node.name, model.nodes.size()).second) {
        throw row.Error("Name",
                        fmt::format("the node \"{}\" stands here a second time", node.name));
      }
      model.nodes.push_back(std::move(node));
    }
  }
  for (const Row& row : RowsOf(sections, "COORDINATES")) {
    const Vector2d drawn(row.Number(1, "X"), row.Number(2, "Y"));
    const auto node = model.node_of.find(row.words[0]);
    if (node != model.node_of.end()) model.nodes[node->second].drawn = drawn;
  }
}

/// An offset as given: a height above the node's invert, an elevation, or * for none.
double ReadOffset(const Row& row, std::size_t position, const char* column, const std::string& node,
                  const Options& options, const Model& model) {
  if (row.Word(position, column) == "*") return 0.0;
  const double value_m = row.Number(position, column) * options.unit_m;
  if (!options.offsets_are_elevations) return ToMillimetres(value_m);
  const auto found = model.node_of.find(node);
  if (found == model.node_of.end()) return 0.0;
  return ToMillimetres(value_m - model.nodes[found->second].elevation_m);
}

void ReadConduits(const Sections& sections, const Options& options, Model& model) {
  for (const Row& row : RowsOf(sections, "CONDUITS")) {
    Conduit conduit;
    conduit.name = row.Word(0, "Name");
    conduit.from = row.Word(1, "FromNode");
    conduit.to = row.Word(2, "ToNode");
    conduit.line = row.line;
    conduit.length_m = row.Positive(3, "Length") * options.unit_m;
    conduit.roughness = row.Number(4, "Roughness");
    conduit.from_offset_m = ReadOffset(row, 5, "InOffset", conduit.from, options, model);
    conduit.to_offset_m = ReadOffset(row, 6, "OutOffset", conduit.to, options, model);
    if (!model.conduit_of.emplace(conduit.name, model.conduits.size()).second) {
      throw row.Error("Name",
                      fmt::format("the conduit \"{}\" stands here a second time", conduit.name));
    }
    model.conduits.push_back(std::move(conduit));
  }
  for (const Row& row : RowsOf(sections, "XSECTIONS")) {
    const std::string shape = Upper(row.Word(1, "Shape"));
    const auto found = model.conduit_of.find(row.words[0]);
    if (found == model.conduit_of.end()) continue;  // of an orifice or a weir
    Conduit& conduit = model.conduits[found->second];
    conduit.shape = shape;
    if (shape == "CIRCULAR") {
      conduit.diameter_m = ToTenths(row.Positive(2, "Geom1") * options.unit_m);
    }
  }
  for (const Row& row : RowsOf(sections, "VERTICES")) {
    const Vector2d drawn(row.Number(1, "X"), row.Number(2, "Y"));
    const auto found = model.conduit_of.find(row.words[0]);
    if (found == model.conduit_of.end()) continue;
    std::vector<Vector2d>& vertices = model.conduits[found->second].vertices;
    if (vertices.size() == kMostVertices) {
      throw row.Error("Link", fmt::format("a conduit has at most {} vertices", kMostVertices));
    }
    vertices.push_back(drawn);
  }
}

/// A conduit without a cross-section is an error in SWMM too, and the trace of a file cut short.
void DemandShapes(const Model& model, const std::filesystem::path& file) {
  if (model.conduits.empty()) {
    throw InputError(file, std::nullopt, "CONDUITS", "the file describes no conduit");
  }
  for (const Conduit& conduit : model.conduits) {
    if (conduit.shape.empty()) {
      throw InputError(
          file, conduit.line, "XSECTIONS",
          fmt::format("conduit \"{}\" has no cross-section: the file may have been cut",
                      conduit.name));
    }
  }
}

/// Coordinates come late in a file: one that stops in the middle of their rows was cut.
void DemandWholeMap(const Model& model, std::string_view text, const std::filesystem::path& file) {
  const bool all_drawn = std::all_of(model.nodes.begin(), model.nodes.end(),
                                     [](const Node& node) { return node.drawn.has_value(); });
  const std::size_t last = text.rfind("\n[");
  if (all_drawn || text.ends_with('\n') || last == std::string_view::npos) return;
  if (!Upper(text.substr(last + 1, 12)).starts_with("[COORDINATES")) return;
  throw InputError(file, static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 1,
                   "COORDINATES",
                   "the file stops here in the middle of a row, nodes lack coordinates");
}

// ------------------------------------------------------------------------------------ the network

/// From map units to metres around the map's middle.
struct MapScale {
  Vector2d middle{Vector2d::Zero()};
  double metres_per_unit{1.0};

  [[nodiscard]] Vector2d ToWorld(const Vector2d& drawn) const {
    const Vector2d p_W = (drawn - middle) * metres_per_unit;
    return {ToMillimetres(p_W.x()), ToMillimetres(p_W.y())};
  }
};

/// Builds the network from the model, keeping account of every repair.
class Builder {
 public:
  Builder(const Model& model, const Options& options) : model_(model), options_(options) {}

  Network Build(const Sections& sections, const std::filesystem::path& file);

 private:
  void AddRemark(std::optional<int> line, std::string subject, std::string text) {
    network_.remarks.push_back({line, std::move(subject), std::move(text)});
  }
  void Skip(const Conduit& conduit, std::string reason) {
    network_.skipped.push_back({conduit.name, conduit.from, conduit.to, std::move(reason)});
  }
  [[nodiscard]] const Node* Drawn(const std::string& name) const;
  [[nodiscard]] std::optional<double> DrawnLength(const Conduit& conduit) const;
  void ChooseScale();
  void AddManholes();
  [[nodiscard]] bool CanBePipe(const Conduit& conduit);
  void AddPipes();
  [[nodiscard]] Pipe MakePipe(const Conduit& conduit);
  void AddBends(const Conduit& conduit, const ShaftEnd& from, const ShaftEnd& to, Pipe& pipe);
  void KeepSoundPipes();
  void DeepenManholes();
  void LayAllJoints();
  void SkipOtherLinks(const Sections& sections);

  const Model& model_;
  const Options& options_;
  MapScale scale_;
  Network network_;
  std::vector<const Conduit*> conduit_of_pipe_;
};

const Node* Builder::Drawn(const std::string& name) const {
  const auto found = model_.node_of.find(name);
  if (found == model_.node_of.end() || !model_.nodes[found->second].drawn) return nullptr;
  return &model_.nodes[found->second];
}

/// Along the vertices, in map units.
std::optional<double> Builder::DrawnLength(const Conduit& conduit) const {
  const Node *from = Drawn(conduit.from), *to = Drawn(conduit.to);
  if (from == nullptr || to == nullptr) return std::nullopt;
  double length = 0.0;
  Vector2d last = *from->drawn;
  for (const Vector2d& vertex : conduit.vertices) {
    length += (vertex - last).norm();
    last = vertex;
  }
  return length + (*to->drawn - last).norm();
}

void Builder::ChooseScale() {
  Eigen::AlignedBox2d box;
  for (const Node& node : model_.nodes) {
    if (node.drawn) box.extend(*node.drawn);
  }
  if (!box.isEmpty()) {
    scale_.middle = {std::round(box.center().x()), std::round(box.center().y())};
    AddRemark({}, "map",
              fmt::format("its point ({:.0f}, {:.0f}) is the origin here", scale_.middle.x(),
                          scale_.middle.y()));
  }
  scale_.metres_per_unit = options_.unit_m;
  std::vector<double> ratios;
  for (const Conduit& conduit : model_.conduits) {
    const auto drawn = DrawnLength(conduit);
    if (drawn && *drawn > 0.0) ratios.push_back(conduit.length_m / (*drawn * options_.unit_m));
  }
  if (ratios.empty()) return;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>((ratios.size() - 1) / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const double median = *middle;
  if (std::abs(median - 1.0) > kSameScale) {
    scale_.metres_per_unit *= median;
    AddRemark(
        {}, "map",
        fmt::format("conduits are {:.4g} times as long as drawn (median): the map is scaled by it",
                    median));
  }
  const double common = scale_.metres_per_unit / options_.unit_m;
  const auto differing = std::count_if(ratios.begin(), ratios.end(), [&](double ratio) {
    return std::abs(ratio / common - 1.0) > kSameScale;
  });
  if (differing > 0) {
    AddRemark(
        {}, "conduits",
        fmt::format(
            "the stated length of {} of {} is more than 5 % off the drawn one: the drawing rules",
            differing, ratios.size()));
  }
}

void Builder::AddManholes() {
  for (const Node& node : model_.nodes) {
    if (!node.drawn) {
      AddRemark(node.line, "node " + node.name, "left out, it has no coordinates");
      continue;
    }
    Manhole manhole;
    manhole.name = node.name;
    manhole.p_WM << scale_.ToWorld(*node.drawn), node.elevation_m;
    manhole.depth_m = node.depth_m > 0.0 ? node.depth_m : kDefaultDepth_m;
    if (node.depth_m <= 0.0) {
      AddRemark(node.line, "node " + node.name,
                fmt::format("no depth is given, {} m is assumed", kDefaultDepth_m));
    }
    network_.manholes.push_back(std::move(manhole));
  }
}

bool Builder::CanBePipe(const Conduit& conduit) {
  for (const std::string& end : {conduit.from, conduit.to}) {
    if (model_.node_of.count(end) == 0) {
      Skip(conduit, "undefined node: " + end);
      return false;
    }
    if (Drawn(end) == nullptr) {
      Skip(conduit, "no coordinates: node " + end);
      return false;
    }
  }
  if (conduit.from == conduit.to)
    Skip(conduit, "begins and ends in one node");
  else if (conduit.shape != "CIRCULAR")
    Skip(conduit, fmt::format("not circular ({})", conduit.shape));
  else
    return true;
  return false;
}

Pipe Builder::MakePipe(const Conduit& conduit) {
  Pipe pipe;
  pipe.name = conduit.name;
  pipe.upstream = conduit.from;
  pipe.downstream = conduit.to;
  pipe.diameter_m = conduit.diameter_m;
  pipe.material = conduit.roughness < kSmoothBelow ? Material::kPvc : Material::kConcrete;
  pipe.upstream_offset_m = std::max(0.0, conduit.from_offset_m);
  pipe.downstream_offset_m = std::max(0.0, conduit.to_offset_m);
  if (std::min(conduit.from_offset_m, conduit.to_offset_m) < 0.0) {
    AddRemark(conduit.line, "conduit " + conduit.name,
              "an end lies below its node's invert: raised to it, as SWMM does");
  }
  return pipe;
}

double TurnAt(const Vector2d& before, const Vector2d& corner, const Vector2d& after) {
  const Vector2d in = corner - before, out = after - corner;
  return std::abs(std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)));
}

/// Vertices become bends of 1.5 D. Those that do not fit between their neighbours and the shafts
/// go, the flatter one of two that crowd each other first, until the rest fits.
void Builder::AddBends(const Conduit& conduit, const ShaftEnd& from, const ShaftEnd& to,
                       Pipe& pipe) {
  if (conduit.vertices.empty()) return;
  const double radius_m = ToMillimetres(kBendRadii * pipe.diameter_m);
  std::vector<Vector2d> points{from.p_WM.head<2>()};
  for (const Vector2d& vertex : conduit.vertices) points.push_back(scale_.ToWorld(vertex));
  points.emplace_back(to.p_WM.head<2>());

  for (bool fits = false; !fits && points.size() > 2;) {
    const std::size_t last = points.size() - 1;
    std::vector<double> turn(points.size(), 0.0), cut_m(points.size(), 0.0);
    std::vector<bool> goes(points.size(), false);
    for (std::size_t i = 1; i < last; ++i) {
      turn[i] = TurnAt(points[i - 1], points[i], points[i + 1]);
      goes[i] = turn[i] > kSharpestVertex;
      cut_m[i] = radius_m * std::tan(std::min(turn[i], kSharpestVertex) / 2.0);
    }
    cut_m[0] = from.radius_m;
    cut_m[last] = to.radius_m;
    for (std::size_t i = 0; i < last; ++i) {
      if ((points[i + 1] - points[i]).norm() >= cut_m[i] + cut_m[i + 1] + 1e-3) continue;
      const bool first_goes = i + 1 == last || (i > 0 && turn[i] < turn[i + 1]);
      goes[first_goes ? i : i + 1] = true;
    }
    goes[0] = goes[last] = false;
    fits = std::none_of(goes.begin(), goes.end(), [](bool one) { return one; });
    std::vector<Vector2d> kept;
    for (std::size_t i = 0; i <= last; ++i) {
      if (!goes[i]) kept.push_back(points[i]);
    }
    points = std::move(kept);
  }
  for (std::size_t i = 1; i + 1 < points.size(); ++i) pipe.bends.push_back({points[i], radius_m});
  if (pipe.bends.size() < conduit.vertices.size()) {
    AddRemark(conduit.line, "conduit " + conduit.name,
              "vertices left out where a bend of 1.5 D does not fit");
  }
}

void Builder::AddPipes() {
  for (const Conduit& conduit : model_.conduits) {
    if (!CanBePipe(conduit)) continue;
    network_.pipes.push_back(MakePipe(conduit));
    conduit_of_pipe_.push_back(&conduit);
  }
}

/// Shafts are as wide as their widest pipe demands, so all pipes must be known before any is
/// judged. One that goes can only make shafts narrower: what fitted before still does.
void Builder::KeepSoundPipes() {
  const NetworkIndex index(network_);
  std::vector<Pipe> sound;
  for (std::size_t i = 0; i < network_.pipes.size(); ++i) {
    const Conduit& conduit = *conduit_of_pipe_[i];
    Pipe pipe = network_.pipes[i];
    const ShaftEnd from = EndAt(network_, index, index.upstream[i]),
                   to = EndAt(network_, index, index.downstream[i]);
    AddBends(conduit, from, to, pipe);
    const double apart_m = (to.p_WM - from.p_WM).head<2>().norm();
    if (pipe.bends.empty() && apart_m < from.radius_m + to.radius_m + kShortestPipe_m) {
      Skip(conduit, fmt::format("too short for the shafts at its ends: {:.2f} m", apart_m));
      continue;
    }
    try {
      CheckPipe(pipe, from, to);
      sound.push_back(std::move(pipe));
    } catch (const Flaw& flaw) {
      Skip(conduit, fmt::format("cannot be built: {}", flaw.what()));
    }
  }
  network_.pipes = std::move(sound);
}

void Builder::DeepenManholes() {
  const NetworkIndex index(network_);
  for (std::size_t i = 0; i < network_.manholes.size(); ++i) {
    Manhole& manhole = network_.manholes[i];
    const double given_m = manhole.depth_m;
    for (const std::size_t p : index.pipes_at[i]) {
      const Pipe& pipe = network_.pipes[p];
      const double offset_m =
          index.upstream[p] == i ? pipe.upstream_offset_m : pipe.downstream_offset_m;
      manhole.depth_m = std::max(manhole.depth_m, offset_m + pipe.diameter_m);
    }
    if (manhole.depth_m > given_m) {
      AddRemark(model_.nodes[model_.node_of.find(manhole.name)->second].line,
                "node " + manhole.name, "shallower than the crown of a pipe there: made as deep");
    }
  }
}

void Builder::LayAllJoints() {
  const NetworkIndex index(network_);
  std::size_t joints = 0, bare = 0;
  for (std::size_t i = 0; i < network_.pipes.size(); ++i) {
    Pipe& pipe = network_.pipes[i];
    if (!IsEnterable(pipe)) continue;
    if (joints > kMostJoints / 2) {
      ++bare;
      continue;
    }
    const PipeAxis axis(network_, index, i);
    pipe.joints = LayJoints({kJointSpacing_m, kJointSpacing_m}, axis.length_m());
    joints += pipe.joints.size();
  }
  AddRemark(
      {}, "joints",
      fmt::format("the file knows none: one every {} m is assumed in the pipes KANTARO can enter",
                  kJointSpacing_m));
  if (bare > 0)
    AddRemark({}, "joints", fmt::format("none in the last {} pipes, there are too many", bare));
  AddRemark({}, "materials",
            fmt::format("told from Manning's n: plastic below {}, else concrete", kSmoothBelow));
}

void Builder::SkipOtherLinks(const Sections& sections) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kOthers{
      {{"PUMPS", "a pump"},
       {"ORIFICES", "an orifice"},
       {"WEIRS", "a weir"},
       {"OUTLETS", "an outlet"}}};
  for (const auto& [section, reason] : kOthers) {
    for (const Row& row : RowsOf(sections, section)) {
      network_.skipped.push_back({row.Word(0, "Name"), row.Word(1, "FromNode"),
                                  row.Word(2, "ToNode"), std::string(reason)});
    }
  }
}

Network Builder::Build(const Sections& sections, const std::filesystem::path& file) {
  network_.name = file.stem().string();
  ChooseScale();
  AddManholes();
  AddPipes();
  KeepSoundPipes();
  SkipOtherLinks(sections);
  if (network_.pipes.empty()) {
    throw InputError(
        file, std::nullopt, "CONDUITS",
        fmt::format("none of the {} conduits can be used; the first, \"{}\": {}",
                    model_.conduits.size(), network_.skipped[0].name, network_.skipped[0].reason));
  }
  DeepenManholes();
  LayAllJoints();
  return std::move(network_);
}

}  // namespace

Network ParseSwmm(const std::string& text, const std::filesystem::path& name) {
  const std::string clean = Cleaned(text, name);
  const Sections sections = Split(clean, name);
  const Options options = ReadOptions(sections);
  Model model;
  ReadNodes(sections, options, model);
  ReadConduits(sections, options, model);
  DemandShapes(model, name);
  DemandWholeMap(model, clean, name);
  Network network = Builder(model, options).Build(sections, name);
  Check(network, name);
  return network;
}

}  // namespace kantaro::network
