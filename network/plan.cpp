#include "network/plan.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

#include "base/random.hpp"

namespace kantaro::network {
namespace {

using Eigen::Vector2d;

constexpr double kSpread = 0.3;  // of the manholes' distances about their mean

Vector2d Rounded(const Vector2d& p_W) { return {Centimetres(p_W.x()), Centimetres(p_W.y())}; }

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
  Plan::Edge MakeEdge(const Plan& plan, std::size_t down) {
    Plan::Edge edge{plan.nodes.size() - 1, down, {}};
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

}  // namespace

double Length(const Plan& plan, const Plan::Edge& edge) {
  const Vector2d &up = plan.nodes[edge.up], &down = plan.nodes[edge.down];
  if (!edge.corner) return (down - up).norm();
  return (*edge.corner - up).norm() + (down - *edge.corner).norm();
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

}  // namespace kantaro::network
