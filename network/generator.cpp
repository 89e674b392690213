#include "network/generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <stdexcept>
#include <tuple>

#include "base/random.hpp"
#include "network/joints.hpp"
#include "network/network_index.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::network {
namespace {

using Eigen::Vector2d;

constexpr double kSpread = 0.3;     // of the manholes' distances about their mean
constexpr double kShafts_m = 0.75;  // that the shafts of 200 mm pipes and some larger take

/// A pipe from above, drawn towards the outfall.
struct Edge {
  std::size_t up{}, down{};
  std::optional<Vector2d> corner;
};

/// A network from above. Edges stand in an order of growth: each starts or ends at a node that an
/// earlier one reached, so that any first few make a whole. In a forest edge k leads down from
/// node k + 1.
struct Plan {
  std::vector<Vector2d> nodes;
  std::vector<Edge> edges;
};

double Centimetres(double value_m) { return std::round(value_m * 100.0) / 100.0; }
double Millimetres(double value_m) { return std::round(value_m * 1000.0) / 1000.0; }
Vector2d Rounded(const Vector2d& p_W) { return {Centimetres(p_W.x()), Centimetres(p_W.y())}; }

double Length(const Plan& plan, const Edge& edge) {
  const Vector2d &up = plan.nodes[edge.up], &down = plan.nodes[edge.down];
  if (!edge.corner) return (down - up).norm();
  return (*edge.corner - up).norm() + (down - *edge.corner).norm();
}

/// How much is wanted, and whether it is there.
class Quota {
 public:
  explicit Quota(const GeneratorOptions& options) : options_(options) {}
  [[nodiscard]] bool Filled(const Plan& plan) {
    for (; counted_ < plan.edges.size(); ++counted_) {
      length_m_ += Length(plan, plan.edges[counted_]) - kShafts_m;
    }
    return options_.pipes ? counted_ >= *options_.pipes : length_m_ >= *options_.length_m;
  }
  /// About how many pipes it will be.
  [[nodiscard]] double Pipes() const {
    if (options_.pipes) return static_cast<double>(*options_.pipes);
    return *options_.length_m / (options_.spacing_m - kShafts_m) + 1.0;
  }

 private:
  const GeneratorOptions& options_;
  std::size_t counted_{};
  double length_m_{};
};

/// Ascending positions of parallel streets.
std::vector<double> Lines(std::size_t count, double spacing_m, RandomStream& random) {
  std::vector<double> lines{0.0};
  while (lines.size() < count) {
    const double step_m = spacing_m * random.Uniform(1.0 - kSpread, 1.0 + kSpread);
    lines.push_back(Centimetres(lines.back() + step_m));
  }
  return lines;
}

// ------------------------------------------------------------------------------------------- grid

/// Corner by corner outwards from the outfall: each adds its pipes to the corners before it.
Plan PlanGrid(const GeneratorOptions& options) {
  Quota quota(options);
  RandomStream random(options.seed, "generator grid");
  const auto side = static_cast<std::size_t>(std::sqrt(quota.Pipes() / 2.0) * 1.5) + 3;
  const std::vector<double> x_m = Lines(side, options.spacing_m, random),
                            y_m = Lines(side, options.spacing_m, random);
  std::vector<std::vector<std::size_t>> at(side, std::vector<std::size_t>(side));
  Plan plan;
  const auto add = [&](std::size_t i, std::size_t j) {
    at[i][j] = plan.nodes.size();
    plan.nodes.emplace_back(x_m[i], y_m[j]);
    if (i > 0 && !quota.Filled(plan)) plan.edges.push_back({at[i][j], at[i - 1][j], {}});
    if (j > 0 && !quota.Filled(plan)) plan.edges.push_back({at[i][j], at[i][j - 1], {}});
  };
  add(0, 0);
  for (std::size_t shell = 1; shell < side; ++shell) {
    for (std::size_t k = 0; k <= shell; ++k) {
      if (quota.Filled(plan)) return plan;
      add(shell, k);
      if (k < shell && !quota.Filled(plan)) add(k, shell);
    }
  }
  return plan;
}

// ------------------------------------------------------------------------------------------- tree

/// Grows branches on a trunk along x. On the left they join at 45°, on the right at 90°, so that
/// branches of one side are parallel; every third manhole of the trunk has one, and every second of
/// a branch a single pipe that is too short to reach the next branch.
class TreePlanner {
 public:
  explicit TreePlanner(const GeneratorOptions& options)
      : quota_(options), random_(options.seed, "generator tree"), spacing_m_(options.spacing_m) {}

  Plan Grow() {
    const auto longest = static_cast<std::size_t>(std::sqrt(quota_.Pipes() / 2.0)) + 1;
    plan_.nodes.emplace_back(0.0, 0.0);
    std::size_t trunk = 0;
    for (std::size_t i = 1; !quota_.Filled(plan_); ++i) {
      trunk = Add(trunk, Vector2d::UnitX());
      if (i % 3 == 1) AddBranch(trunk, Vector2d(1.0, 1.0).normalized(), longest);
      if (i % 3 == 2) AddBranch(trunk, -Vector2d::UnitY(), longest);
    }
    return plan_;
  }

 private:
  std::size_t Add(std::size_t from, const Vector2d& direction) {
    const double step_m = spacing_m_ * random_.Uniform(1.0 - kSpread, 1.0 + kSpread);
    plan_.nodes.push_back(Rounded(plan_.nodes[from] + step_m * direction));
    plan_.edges.push_back({plan_.nodes.size() - 1, from, {}});
    return plan_.nodes.size() - 1;
  }

  void AddBranch(std::size_t root, const Vector2d& direction, std::size_t longest) {
    const std::size_t count = 1 + longest / 2 + random_.Index(longest / 2 + 1);
    std::size_t end = root;
    for (std::size_t i = 1; i <= count && !quota_.Filled(plan_); ++i) {
      end = Add(end, direction);
      if (i % 2 == 0 && !quota_.Filled(plan_)) Add(end, Vector2d::UnitX());
    }
  }

  Quota quota_;
  RandomStream random_;
  double spacing_m_;
  Plan plan_;
};

// ------------------------------------------------------------------------------------------- city

/// Manholes stand on the streets around blocks of 2 by 3 spans. From the outfall in the middle the
/// cheapest ways are laid to more and more of them: a tree, in which broad streets every sixth
/// block carry the collectors.
class CityPlanner {
 public:
  explicit CityPlanner(const GeneratorOptions& options)
      : quota_(options), random_(options.seed, "generator city"), spacing_m_(options.spacing_m) {
    // 4 manholes for a block; half as wide again as a square would be, for the ragged edge.
    const double blocks = std::sqrt(quota_.Pipes() / 4.0) * 1.5 + 4.0;
    columns_ = kAcross * static_cast<std::size_t>(blocks) + 1;
    rows_ = kUp * static_cast<std::size_t>(blocks * kAcross / kUp + 1.0) + 1;
  }

  Plan Grow() {
    LayStreets();
    struct Step {
      double cost;
      std::size_t site, from;
      bool operator>(const Step& other) const {
        return std::tie(cost, site, from) > std::tie(other.cost, other.site, other.from);
      }
    };
    std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
    std::vector<std::size_t> node_at(sites_.size(), kNone);
    Plan plan;
    // Both counts are of crossings: the middle one is a crossing too.
    const std::size_t middle = Site(columns_ / kAcross / 2 * kAcross, rows_ / kUp / 2 * kUp);
    open.push({0.0, middle, kNone});
    while (!open.empty() && !quota_.Filled(plan)) {
      const Step step = open.top();
      open.pop();
      if (node_at[step.site] != kNone) continue;
      node_at[step.site] = plan.nodes.size();
      plan.nodes.push_back(sites_[step.site]);
      if (step.from != kNone) plan.edges.push_back(MakeEdge(plan, node_at[step.from]));
      for (const std::size_t next : Neighbours(step.site)) {
        if (node_at[next] == kNone) {
          open.push({step.cost + Cost(step.site, next), next, step.site});
        }
      }
    }
    return plan;
  }

 private:
  static constexpr std::size_t kAcross = 3, kUp = 2;  // spans of a block
  static constexpr std::size_t kBroad = 6;            // blocks between broad streets
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] std::size_t Site(std::size_t column, std::size_t row) const {
    return row * columns_ + column;
  }
  [[nodiscard]] bool OnStreet(std::size_t column, std::size_t row) const {
    return column % kAcross == 0 || row % kUp == 0;
  }

  void LayStreets() {
    const std::vector<double> x_m = Lines(columns_, spacing_m_, random_),
                              y_m = Lines(rows_, spacing_m_, random_);
    const double jitter_m = 0.04 * spacing_m_;
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t column = 0; column < columns_; ++column) {
        const double aside_m = random_.Uniform(-jitter_m, jitter_m);
        const double along_m = random_.Uniform(-jitter_m, jitter_m);
        sites_.push_back(Rounded({x_m[column] + aside_m, y_m[row] + along_m}));
        hindrance_.push_back(random_.Uniform(1.0, 1.6));
      }
    }
  }

  [[nodiscard]] std::vector<std::size_t> Neighbours(std::size_t site) const {
    const std::size_t column = site % columns_, row = site / columns_;
    std::vector<std::size_t> found;
    const auto add = [&](std::size_t c, std::size_t r) {
      if (c < columns_ && r < rows_ && OnStreet(c, r)) found.push_back(Site(c, r));
    };
    if (row % kUp == 0) {  // along the street; below 0 wraps to beyond the last
      add(column - 1, row);
      add(column + 1, row);
    }
    if (column % kAcross == 0) {
      add(column, row - 1);
      add(column, row + 1);
    }
    return found;
  }

  [[nodiscard]] double Cost(std::size_t from, std::size_t to) const {
    const bool across = from / columns_ == to / columns_;
    const bool broad =
        across ? from / columns_ % (kUp * kBroad) == 0 : from % columns_ % (kAcross * kBroad) == 0;
    const double length_m = (sites_[to] - sites_[from]).norm();
    return length_m * (broad ? 0.5 : std::max(hindrance_[from], hindrance_[to]));
  }

  /// One in thirty goes round something in the street.
  Edge MakeEdge(const Plan& plan, std::size_t down) {
    Edge edge{plan.nodes.size() - 1, down, {}};
    const bool bent = random_.Uniform(0.0, 1.0) < 1.0 / 30.0;
    const double aside = random_.Uniform(0.05, 0.09) * (random_.Index(2) == 0 ? 1.0 : -1.0);
    if (!bent) return edge;
    const Vector2d &up_p = plan.nodes[edge.up], along = plan.nodes[down] - up_p;
    edge.corner = Rounded(up_p + 0.5 * along + aside * Vector2d(-along.y(), along.x()));
    return edge;
  }

  Quota quota_;
  RandomStream random_;
  double spacing_m_;
  std::size_t columns_{}, rows_{};
  std::vector<Vector2d> sites_;
  std::vector<double> hindrance_;
};

// ------------------------------------------------------------------------------------- dimensions

/// Length of pipe that drains through each edge, its own included.
std::vector<double> Catchments(const Plan& plan) {
  std::vector<double> catchment_m;
  for (const Edge& edge : plan.edges) catchment_m.push_back(Length(plan, edge));
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
  for (const Edge& edge : plan.edges) whole_m += Length(plan, edge) - kShafts_m;
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
  for (const Edge& edge : plan.edges) {
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
    const Edge& edge = plan_.edges[k];
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
      const Edge& edge = plan_.edges[k];
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

Plan MakePlan(const GeneratorOptions& options) {
  switch (options.layout) {
    case Layout::kGrid:
      return PlanGrid(options);
    case Layout::kTree:
      return TreePlanner(options).Grow();
    case Layout::kCity:
      break;
  }
  return CityPlanner(options).Grow();
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
