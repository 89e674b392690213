#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/input_error.hpp"
#include "network/check.hpp"
#include "network/formats.hpp"
#include "network/joints.hpp"
#include "network/network_index.hpp"
#include "network/swmm_map.hpp"
#include "network/swmm_model.hpp"
#include "network/swmm_text.hpp"

namespace kantaro::network {
namespace {

using Eigen::Vector2d;
using swmm::Link;
using swmm::Model;
using swmm::Node;
using swmm::ToMillimetres;

constexpr double kJointSpacing_m = 1.8;  // plastic and clay pipe come in lengths under 2 m
constexpr double kDefaultDepth_m = 2.0;
constexpr double kBendRadii = 1.5;       // of a vertex, in pipe diameters
constexpr double kFarthest_m = 1e7;      // a course longer than that is none
constexpr double kSmoothBelow = 0.012;   // Manning's n: plastic below, concrete above
constexpr double kSharpestVertex = 2.5;  // [rad]

/// Builds the network from the model, keeping account of every repair.
class Builder {
 public:
  Builder(Model model, const std::filesystem::path& file)
      : model_(std::move(model)), file_(file), frame_(model_, file) {}

  Network Build();

 private:
  void AddRemark(std::optional<int> line, std::string subject, std::string text) {
    network_.remarks.push_back({line, std::move(subject), std::move(text)});
  }
  void Skip(const Link& link, std::string reason);
  void AddManholes();
  [[nodiscard]] std::optional<std::string> WhyNoPipe(const Link& link) const;
  void AddPipes();
  [[nodiscard]] Pipe MakePipe(const Link& conduit);
  void AddBends(const Link& conduit, const ShaftEnd& from, const ShaftEnd& to, Pipe& pipe);
  void KeepSoundPipes();
  void DeepenManholes();
  void LayAllJoints();

  Model model_;
  const std::filesystem::path& file_;
  swmm::MapFrame frame_;
  Network network_;
  std::vector<const Link*> link_of_pipe_;
};

/// It stays in the map with what is known of its shape.
void Builder::Skip(const Link& link, std::string reason) {
  SkippedLink skipped;
  skipped.name = link.name;
  skipped.upstream = link.from;
  skipped.downstream = link.to;
  skipped.reason = std::move(reason);
  skipped.height_m = link.height_m;
  for (const Vector2d& vertex : link.vertices) skipped.via_W.push_back(frame_.ToWorld(vertex));
  skipped.length_m = ToMillimetres(DrawnLength(model_, frame_, link).value_or(link.length_m));
  if (skipped.length_m > kFarthest_m) {  // a slip of the drawing
    skipped.via_W.clear();
    skipped.length_m = ToMillimetres(link.length_m);
  }
  network_.skipped.push_back(std::move(skipped));
}

void Builder::AddManholes() {
  for (const Node& node : model_.nodes) {
    if (!node.drawn) {
      AddRemark(node.line, "node " + node.name, "left out, it has no coordinates");
      continue;
    }
    Manhole manhole;
    manhole.name = node.name;
    manhole.p_WM << frame_.ToWorld(*node.drawn), node.elevation_m;
    manhole.depth_m = node.depth_m > 0.0 ? node.depth_m : kDefaultDepth_m;
    if (node.depth_m <= 0.0) {
      AddRemark(node.line, "node " + node.name,
                fmt::format("no depth is given, {} m is assumed", kDefaultDepth_m));
    }
    if (node.is_storage) {
      AddRemark(node.line, "node " + node.name,
                "a storage unit: only the shaft that its pipes need is built");
    }
    network_.manholes.push_back(std::move(manhole));
  }
}

std::optional<std::string> Builder::WhyNoPipe(const Link& link) const {
  for (const std::string& end : {link.from, link.to}) {
    if (model_.node_of.count(end) == 0) return "undefined node: " + end;
    if (model_.Drawn(end) == nullptr) return "no coordinates: node " + end;
  }
  if (!link.device.empty()) return link.device;
  if (link.from == link.to) return "begins and ends in one node";
  if (link.shape != "CIRCULAR") return fmt::format("not circular ({})", link.shape);
  // Before any shaft is made to its size, or its neighbours would have no room.
  if (link.height_m > kLargestDiameter_m) {
    return fmt::format("a diameter of more than {} m, a slip of the unit: {:.6g} m",
                       kLargestDiameter_m, link.height_m);
  }
  return std::nullopt;
}

void Builder::AddPipes() {
  for (const Link& link : model_.links) {
    if (auto reason = WhyNoPipe(link)) {
      Skip(link, std::move(*reason));
      continue;
    }
    network_.pipes.push_back(MakePipe(link));
    link_of_pipe_.push_back(&link);
  }
}

Pipe Builder::MakePipe(const Link& conduit) {
  Pipe pipe;
  pipe.name = conduit.name;
  pipe.upstream = conduit.from;
  pipe.downstream = conduit.to;
  pipe.diameter_m = conduit.height_m;
  pipe.material = conduit.roughness < kSmoothBelow ? Material::kPvc : Material::kConcrete;
  pipe.upstream_offset_m = std::max(0.0, conduit.from_offset_m);
  pipe.downstream_offset_m = std::max(0.0, conduit.to_offset_m);
  if (std::min(conduit.from_offset_m, conduit.to_offset_m) < 0.0) {
    AddRemark(conduit.line, "conduit " + conduit.name,
              "an end lies below its node's invert: raised to it, as SWMM does");
  }
  if (conduit.barrels > 1.0) {
    AddRemark(conduit.line, "conduit " + conduit.name,
              fmt::format("{:g} barrels side by side: one is laid", conduit.barrels));
  }
  return pipe;
}

double TurnAt(const Vector2d& before, const Vector2d& corner, const Vector2d& after) {
  const Vector2d in = corner - before, out = after - corner;
  return std::abs(std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)));
}

/// Vertices become bends of 1.5 D. Those that do not fit between their neighbours and the shafts
/// go, the flatter one of two that crowd each other first, until the rest fits.
void Builder::AddBends(const Link& conduit, const ShaftEnd& from, const ShaftEnd& to, Pipe& pipe) {
  if (conduit.vertices.empty()) return;
  const double radius_m = ToMillimetres(kBendRadii * pipe.diameter_m);
  std::vector<Vector2d> points{from.p_WM.head<2>()};
  for (const Vector2d& vertex : conduit.vertices) points.push_back(frame_.ToWorld(vertex));
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

/// Shafts are as wide as their widest pipe demands, so all pipes must be known before any is
/// judged. One that goes can only make shafts narrower: what fitted before still does.
void Builder::KeepSoundPipes() {
  const NetworkIndex index(network_);
  std::vector<Pipe> sound;
  for (std::size_t i = 0; i < network_.pipes.size(); ++i) {
    const Link& conduit = *link_of_pipe_[i];
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
      Skip(conduit, fmt::format("cannot be built: {}: {}", flaw.field, flaw.what()));
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
  AddRemark({}, "manholes",
            "the file knows no shafts: as wide as the widest pipe + 500 mm, benched to the crown");
  AddRemark(
      {}, "joints",
      fmt::format("the file knows none: one every {} m is assumed in the pipes KANTARO can enter",
                  kJointSpacing_m));
  if (bare > 0)
    AddRemark({}, "joints", fmt::format("none in the last {} pipes, there are too many", bare));
  AddRemark({}, "materials",
            fmt::format("told from Manning's n: plastic below {}, else concrete", kSmoothBelow));
}

Network Builder::Build() {
  network_.name = file_.stem().string();
  network_.remarks = std::move(model_.remarks);
  AddManholes();
  AddPipes();
  KeepSoundPipes();
  if (network_.pipes.empty()) {
    throw InputError(
        file_, std::nullopt, "CONDUITS",
        fmt::format("none of the {} links can be used; the first, \"{}\": {}", model_.links.size(),
                    network_.skipped[0].name, network_.skipped[0].reason));
  }
  DeepenManholes();
  LayAllJoints();
  return std::move(network_);
}

}  // namespace

Network ParseSwmm(const std::string& text, const std::filesystem::path& name) {
  const std::string clean = swmm::Cleaned(text, name);
  Network network = Builder(ReadModel(swmm::Split(clean, name), clean, name), name).Build();
  Check(network, name);
  return network;
}

}  // namespace kantaro::network
