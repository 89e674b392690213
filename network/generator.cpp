#include "network/generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "base/random.hpp"
#include "network/joints.hpp"
#include "network/network_index.hpp"
#include "network/pipe_axis.hpp"
#include "network/plan.hpp"

namespace kantaro::network {
namespace {

using Eigen::Vector2d;

double Millimetres(double value_m) { return std::round(value_m * 1000.0) / 1000.0; }

// ------------------------------------------------------------------------------------- dimensions

/// Length of pipe that drains through each edge, its own included.
std::vector<double> Catchments(const Plan& plan) {
  std::vector<double> catchment_m;
  for (const Plan::Edge& edge : plan.edges) catchment_m.push_back(Length(plan, edge));
  for (std::size_t k = plan.edges.size(); k-- > 0;) {
    const std::size_t down = plan.edges[k].down;
    if (down > 0) catchment_m[down - 1] += catchment_m[k];
  }
  return catchment_m;
}

/// A pipe that drains more gets no smaller a diameter than one that drains less: so none narrows
/// downstream, and each size gets its share of the length.
std::vector<double> MixedDiameters(const Plan& plan,
                                   const std::vector<std::pair<double, double>>& mix) {
  const std::vector<double> catchment_m = Catchments(plan);
  std::vector<std::size_t> order(plan.edges.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return catchment_m[a] < catchment_m[b]; });
  double whole_m = 0.0, mix_m = 0.0;
  for (const Plan::Edge& edge : plan.edges) whole_m += Length(plan, edge) - kShafts_m;
  for (const auto& [diameter_m, length_m] : mix) mix_m += length_m;

  std::vector<double> diameters_m(plan.edges.size());
  std::size_t size = 0;
  double gone_m = 0.0, end_m = mix[0].second / mix_m * whole_m;
  for (const std::size_t k : order) {
    const double length_m = Length(plan, plan.edges[k]) - kShafts_m;
    while (size + 1 < mix.size() && gone_m + length_m / 2.0 > end_m) {
      end_m += mix[++size].second / mix_m * whole_m;
    }
    diameters_m[k] = mix[size].first;
    gone_m += length_m;
  }
  return diameters_m;
}

/// 200 mm for up to ten pipes' length, then as the flow asks for at equal grade: by Manning's
/// formula it goes with the diameter to the power of 8/3.
std::vector<double> GrownDiameters(const Plan& plan, double spacing_m) {
  constexpr std::array kSizes_m{0.200, 0.250, 0.300, 0.350, 0.400, 0.450, 0.500, 0.600, 0.700};
  std::vector<double> diameters_m;
  for (const double catchment_m : Catchments(plan)) {
    const double wanted_m = kSizes_m[0] * std::pow(catchment_m / (10.0 * spacing_m), 3.0 / 8.0);
    const auto* const size = std::lower_bound(kSizes_m.begin(), kSizes_m.end() - 1, wanted_m);
    diameters_m.push_back(*size);
  }
  return diameters_m;
}

/// Every street has one of three sizes that KANTARO enters.
std::vector<double> StreetDiameters(const Plan& plan, std::uint64_t seed) {
  constexpr std::array kSizes_m{0.200, 0.250, 0.300};
  std::vector<double> diameters_m;
  for (const Plan::Edge& edge : plan.edges) {
    const Vector2d &up = plan.nodes[edge.up], &down = plan.nodes[edge.down];
    const bool along_x = up.y() == down.y();
    RandomStream street(seed, fmt::format("street {} {}", along_x, along_x ? up.y() : up.x()));
    diameters_m.push_back(kSizes_m[street.Index(kSizes_m.size())]);
  }
  return diameters_m;
}

std::vector<double> Diameters(const GeneratorOptions& options, const Plan& plan) {
  switch (options.layout) {
    case Layout::kGrid:
      return StreetDiameters(plan, options.seed);
    case Layout::kTree:
      return GrownDiameters(plan, options.spacing_m);
    case Layout::kCity:
      break;
  }
  return MixedDiameters(plan, KitakyushuMix());
}

// ---------------------------------------------------------------------------------------- in space

/// Gives a plan heights, walls, joints and inlets.
class Dresser {
 public:
  Dresser(const GeneratorOptions& options, const Plan& plan, const std::vector<double>& diameters_m)
      : plan_(plan), diameters_m_(diameters_m), random_(options.seed, "generator dress") {
    network_.name = fmt::format("{} {} seed {}", plan.edges.size(),
                                options.layout == Layout::kGrid   ? "pipes in a grid"
                                : options.layout == Layout::kTree ? "pipes in a tree"
                                                                  : "pipes of a city",
                                options.seed);
  }

  Network Dress(bool falls_like_a_plane) {
    for (std::size_t i = 0; i < plan_.nodes.size(); ++i) AddManhole(i);
    for (std::size_t k = 0; k < plan_.edges.size(); ++k) AddPipe(k);
    if (falls_like_a_plane) {
      LayOnAPlane();
    } else {
      LayFromTheOutfall();
    }
    Deepen();
    Furnish();
    return std::move(network_);
  }

 private:
  void AddManhole(std::size_t i) {
    Manhole manhole;
    manhole.name = fmt::format("M{}", i + 1);
    manhole.p_WM.head<2>() = plan_.nodes[i];
    manhole.depth_m = Centimetres(random_.Uniform(1.5, 4.0));
    manhole.bench_height = random_.Index(3) == 0 ? BenchHeight::kAxis : BenchHeight::kCrown;
    network_.manholes.push_back(std::move(manhole));
  }

  void AddPipe(std::size_t k) {
    const Plan::Edge& edge = plan_.edges[k];
    Pipe pipe;
    pipe.name = fmt::format("P{}", k + 1);
    pipe.upstream = network_.manholes[edge.up].name;
    pipe.downstream = network_.manholes[edge.down].name;
    pipe.diameter_m = diameters_m_[k];
    pipe.material = DrawMaterial(pipe.diameter_m);
    // Three diameters: as tight as a pipe is ever laid round something in a street.
    if (edge.corner) pipe.bends.push_back({*edge.corner, Millimetres(3.0 * pipe.diameter_m)});
    network_.pipes.push_back(std::move(pipe));
  }

  /// Assumed, for want of figures: plastic and clay for small pipes, concrete for large ones, and
  /// one in twenty relined.
  Material DrawMaterial(double diameter_m) {
    const double draw = random_.Uniform(0.0, 1.0);
    if (draw < 0.05) return Material::kLined;
    const double plastic = diameter_m < 0.4 ? 0.55 : 0.20, clay = diameter_m < 0.4 ? 0.20 : 0.05;
    if (draw < 0.05 + plastic) return Material::kPvc;
    return draw < 0.05 + plastic + clay ? Material::kClay : Material::kConcrete;
  }

  /// Between shaft walls, where the fall is.
  [[nodiscard]] double GradeFor(double diameter_m) {
    return SelfCleaningGrade(diameter_m) * random_.Uniform(1.1, 3.0);
  }

  /// In a forest the pipe below each is known before it. Crowns meet where a pipe flows into a
  /// wider one, as the rules of design have it; one in twelve side pipes drops further.
  void LayFromTheOutfall() {
    std::vector<std::size_t> into(plan_.nodes.size(), 0);
    for (std::size_t k = 0; k < plan_.edges.size(); ++k) {
      const Plan::Edge& edge = plan_.edges[k];
      Pipe& pipe = network_.pipes[k];
      const double below_m = edge.down > 0 ? diameters_m_[edge.down - 1] : pipe.diameter_m;
      pipe.downstream_offset_m = Millimetres(below_m - pipe.diameter_m);
      const bool drops = ++into[edge.down] > 1 && random_.Index(12) == 0;
      const double drop_m = Centimetres(random_.Uniform(0.05, 0.60));
      if (drops) pipe.downstream_offset_m = Millimetres(pipe.downstream_offset_m + drop_m);
      const double rise_m = GradeFor(pipe.diameter_m) * Length(plan_, edge);
      network_.manholes[edge.up].p_WM.z() =
          Millimetres(network_.manholes[edge.down].p_WM.z() + pipe.downstream_offset_m + rise_m);
    }
  }

  /// With loops all ways from a manhole must agree on its height: one even slope does, and it
  /// cleans the smallest pipe.
  void LayOnAPlane() {
    const double smallest_m = *std::min_element(diameters_m_.begin(), diameters_m_.end());
    const double along_x = GradeFor(smallest_m), along_y = GradeFor(smallest_m);
    for (Manhole& manhole : network_.manholes) {
      manhole.p_WM.z() = Millimetres(along_x * manhole.p_WM.x() + along_y * manhole.p_WM.y());
    }
  }

  void Deepen() {
    for (std::size_t k = 0; k < plan_.edges.size(); ++k) {
      const Pipe& pipe = network_.pipes[k];
      for (const auto& [node, offset_m] :
           {std::pair(plan_.edges[k].up, pipe.upstream_offset_m),
            std::pair(plan_.edges[k].down, pipe.downstream_offset_m)}) {
        double& depth_m = network_.manholes[node].depth_m;
        depth_m = std::max(depth_m, Centimetres(offset_m + pipe.diameter_m + 0.80));
      }
    }
  }

  /// Joints and inlets, for which the pipes' lengths must be known.
  void Furnish() {
    const NetworkIndex index(network_);
    for (std::size_t k = 0; k < network_.pipes.size(); ++k) {
      Pipe& pipe = network_.pipes[k];
      const double length_m = PipeAxis(network_, index, k).length_m();
      const double spacing_m = LaidLength(pipe.material);
      pipe.joints = LayJoints({spacing_m, spacing_m, 0.008, 0.006}, length_m);
      if (pipe.diameter_m < 0.4 && random_.Index(2) == 0) AddInlet(pipe, length_m, spacing_m);
    }
  }

  /// As pipes are sold: plastic 4 m, clay 2 m, concrete 2.43 m. A liner runs through them.
  static double LaidLength(Material material) {
    switch (material) {
      case Material::kPvc:
        return 4.0;
      case Material::kClay:
        return 2.0;
      case Material::kConcrete:
      case Material::kLined:
        break;
    }
    return 2.43;
  }

  /// In the middle of a length, from the upper left or right.
  void AddInlet(Pipe& pipe, double pipe_length_m, double laid_m) {
    const auto lengths = static_cast<std::uint64_t>(pipe_length_m / laid_m);
    const double hours_up = random_.Uniform(0.0, 2.0);
    const bool left = random_.Index(2) == 0;
    const bool wide = pipe.diameter_m > 0.15 && random_.Index(2) == 0;
    if (lengths == 0) return;
    Inlet inlet;
    inlet.name = pipe.name + "_house";
    inlet.chainage_m = Centimetres((static_cast<double>(random_.Index(lengths)) + 0.5) * laid_m);
    inlet.diameter_m = wide ? 0.150 : 0.100;
    inlet.clock_h = std::round((left ? 9.0 + hours_up : 3.0 - hours_up) * 10.0) / 10.0;
    pipe.inlets.push_back(std::move(inlet));
  }

  const Plan& plan_;
  const std::vector<double>& diameters_m_;
  RandomStream random_;
  Network network_;
};

void Demand(const GeneratorOptions& options) {
  if (options.pipes.has_value() == options.length_m.has_value()) {
    throw std::invalid_argument("either the number of pipes or their length is wanted");
  }
  if (options.pipes && (*options.pipes == 0 || *options.pipes > kMostGeneratedPipes)) {
    throw std::invalid_argument(fmt::format("from 1 to {} pipes are made", kMostGeneratedPipes));
  }
  if (!(options.spacing_m >= kShortestManholeSpacing_m &&
        options.spacing_m <= kLongestManholeSpacing_m)) {
    throw std::invalid_argument(fmt::format("manholes stand {} to {} m apart",
                                            kShortestManholeSpacing_m, kLongestManholeSpacing_m));
  }
  if (!options.length_m) return;
  const double most_m = LongestGenerated(options.spacing_m);
  if (!(*options.length_m > 0.0 && *options.length_m <= most_m)) {
    throw std::invalid_argument(
        fmt::format("the length must be above 0 and at most {:.0f} m", most_m));
  }
}

}  // namespace

std::optional<Layout> LayoutNamed(const std::string& word) {
  if (word == "grid") return Layout::kGrid;
  if (word == "tree") return Layout::kTree;
  if (word == "city") return Layout::kCity;
  return std::nullopt;
}

double LongestGenerated(double spacing_m) { return kMostGeneratedPipes * (spacing_m - kShafts_m); }

const std::vector<std::pair<double, double>>& KitakyushuMix() {
  static const std::vector<std::pair<double, double>> kMix{
      {0.150, 210'424}, {0.200, 2'074'502}, {0.250, 329'528}, {0.300, 144'505},
      {0.350, 81'914},  {0.380, 18'099},    {0.400, 64'869},  {0.450, 61'921},
      {0.480, 102},     {0.500, 65'141},    {0.600, 85'373},  {0.700, 64'983}};
  return kMix;
}

double SelfCleaningGrade(double diameter_m) {
  constexpr double kSpeed_m_s = 0.6, kManning = 0.013;
  return std::pow(kSpeed_m_s * kManning / std::pow(diameter_m / 4.0, 2.0 / 3.0), 2.0);
}

Network Generate(const GeneratorOptions& options) {
  Demand(options);
  const Plan plan = MakePlan(options);
  return Dresser(options, plan, Diameters(options, plan)).Dress(options.layout == Layout::kGrid);
}

}  // namespace kantaro::network
