#include "sim/surface_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

#include "sim/polyhedron.hpp"

namespace kantaro::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;  // convex, planar, counter-clockwise seen from the void

// Facets and planes closer than this coincide.
constexpr double kTie = 2e-6;
// How far facets reach into each other at an edge, so that rounding opens no crack.
constexpr double kSeal = 2e-5;
// Cosine of the angle below which a facet and a plane count as parallel: less than a facet's turn.
const double kParallel = std::cos(std::numbers::pi / 180.0);
// Points closer than this are one.
constexpr double kWeld = 1e-7;
// A cut that takes less is not worth making.
constexpr double kLeastArea = 1e-10;

void Check(const VoidPrimitive& primitive, std::size_t index) {
  const double turn = primitive.length_m * std::abs(primitive.curvature);
  const bool sound =
      primitive.length_m > 0.0 && primitive.radius_m > 0.0 && std::isfinite(primitive.length_m) &&
      std::isfinite(primitive.radius_m) &&
      std::abs(primitive.curvature) * primitive.radius_m < 1.0 && turn < 2.0 * std::numbers::pi &&
      primitive.X_WS.matrix().allFinite() &&
      (primitive.profile == Profile::kRound ||
       (primitive.wall_height_m > -primitive.radius_m && std::isfinite(primitive.wall_height_m)));
  if (!sound) {
    throw std::invalid_argument(fmt::format(
        "primitive {} cannot be tessellated: length {} m, radius {} m, curvature {} 1/m, wall {} m",
        index, primitive.length_m, primitive.radius_m, primitive.curvature,
        primitive.wall_height_m));
  }
}

// Twice the area vector of a planar polygon.
Vector3d AreaVector(const Polygon& polygon) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  }
  return sum;
}

// What of the polygon lies where plane.Distance is above `cut` (side 1) or below it (side -1).
Polygon Clip(const Polygon& polygon, const Plane& plane, double cut, double side) {
  Polygon kept;
  const auto height = [&](const Vector3d& p) { return side * (plane.Distance(p) - cut); };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& p = polygon[i];
    const Vector3d& q = polygon[(i + 1) % polygon.size()];
    const double at_p = height(p);
    const double at_q = height(q);
    if (at_p >= 0.0) kept.push_back(p);
    if ((at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0)) {
      // Always from the same end, so that both neighbours of an edge find the same point.
      kept.push_back(side * at_p > 0.0 ? p + (q - p) * (at_p / (at_p - at_q))
                                       : q + (p - q) * (at_q / (at_q - at_p)));
    }
  }
  return kept;
}

struct Cut {
  const Plane* plane{};
  double at{};
};

// What a slab does to a facet.
enum class Effect : std::uint8_t {
  kOpens,          // it is void: a void's wall in it is gone. Of walls that coincide, one stays
  kOpensLater,     // the same, for a slab whose primitive comes after the facet's
  kFills,          // it is solid: a void's wall in it is hidden, one that it is flush with stays
  kSwallows,       // it is solid, and so is the facet's body: what faces it is hidden
  kSwallowsLater,  // the same, for a slab whose primitive comes after the facet's
  kBares           // it is void: a solid's facet shows in it, if it does more than touch
};

// Where a slab's plane cuts a facet, and the distance above which it leaves it whole.
std::pair<double, double> CutAndSlack(const Plane& plane, const Vector3d& normal, Effect effect) {
  const auto at = [](double distance) { return std::pair(distance, distance); };
  if (plane.internal) return at(-kSeal);
  const double cosine = plane.normal.dot(normal);
  const bool same = cosine > kParallel;
  if (!same && cosine >= -kParallel)
    return effect == Effect::kBares ? at(-kSeal) : std::pair(kSeal, -kTie);
  switch (effect) {
    case Effect::kOpens:
      return at(same ? -kTie : -kMembrane_m);
    case Effect::kOpensLater:
      return at(same ? kTie : -kMembrane_m);
    case Effect::kFills:
      return at(same ? -kTie : kTie);
    case Effect::kSwallows:
      return at(same ? -kMembrane_m : -kTie);
    case Effect::kSwallowsLater:
      return at(same ? -kMembrane_m : kTie);
    case Effect::kBares:
      break;
  }
  return at(kTie);
}

// Splits a polygon: appends what of it lies outside the slab to `outside`, and returns the rest.
Polygon Split(const Polygon& polygon, const Vector3d& normal, const Slab& slab, Effect effect,
              std::vector<Polygon>& outside) {
  std::vector<Cut> cuts;
  for (const Plane& plane : slab.planes) {
    const auto [cut, slack] = CutAndSlack(plane, normal, effect);
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Vector3d& p : polygon) {
      const double distance = plane.Distance(p);
      lowest = std::min(lowest, distance);
      highest = std::max(highest, distance);
    }
    if (lowest >= slack) continue;
    if (highest <= cut) {
      outside.push_back(polygon);
      return {};
    }
    if (lowest < cut) cuts.push_back({&plane, cut});
  }
  Polygon inside = polygon;
  for (const Cut& cut : cuts) {
    inside = Clip(inside, *cut.plane, cut.at, 1.0);
    if (inside.size() < 3) break;
  }
  if (inside.size() < 3 || 0.5 * AreaVector(inside).norm() < kLeastArea) {
    outside.push_back(polygon);
    return {};
  }
  // Only planes that bound the inside may cut, lest the rest falls to splinters.
  Polygon rest = polygon;
  for (const Cut& cut : cuts) {
    const auto on_plane = [&](const Vector3d& p) {
      return std::abs(cut.plane->Distance(p) - cut.at) < 1e-9;
    };
    if (std::count_if(inside.begin(), inside.end(), on_plane) < 2) continue;
    Polygon piece = Clip(rest, *cut.plane, cut.at, -1.0);
    if (piece.size() >= 3) outside.push_back(std::move(piece));
    rest = Clip(rest, *cut.plane, cut.at, 1.0);
  }
  return inside;
}

// Points of one primitive, each place once.
class PointSet {
 public:
  explicit PointSet(const std::vector<Vector3d>& points) : points_(points) {
    for (std::uint32_t i = 0; i < points.size(); ++i) grid_[KeyOf(Corner(points[i]))].push_back(i);
  }

  std::uint32_t Find(const Vector3d& p) {
    const std::array<std::int64_t, 3> low = Corner(p - Vector3d::Constant(kWeld));
    const std::array<std::int64_t, 3> high = Corner(p + Vector3d::Constant(kWeld));
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto bucket = grid_.find(KeyOf({x, y, z}));
          if (bucket == grid_.end()) continue;
          for (const std::uint32_t i : bucket->second) {
            if ((points_[i] - p).norm() <= kWeld) return i;
          }
        }
      }
    }
    const auto index = static_cast<std::uint32_t>(points_.size());
    points_.push_back(p);
    grid_[KeyOf(Corner(p))].push_back(index);
    return index;
  }
  const Vector3d& operator[](std::uint32_t index) const { return points_[index]; }

 private:
  static std::array<std::int64_t, 3> Corner(const Vector3d& p) {
    constexpr double kBucket = 1e-3;
    return {static_cast<std::int64_t>(std::floor(p.x() / kBucket)),
            static_cast<std::int64_t>(std::floor(p.y() / kBucket)),
            static_cast<std::int64_t>(std::floor(p.z() / kBucket))};
  }
  static std::uint64_t KeyOf(const std::array<std::int64_t, 3>& corner) {
    // Buckets that share a key only cost a comparison.
    return static_cast<std::uint64_t>(corner[0]) * 0x9E3779B97F4A7C15U ^
           static_cast<std::uint64_t>(corner[1]) * 0xC2B2AE3D27D4EB4FU ^
           static_cast<std::uint64_t>(corner[2]) * 0x165667B19E3779F9U;
  }

  std::vector<Vector3d> points_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> grid_;
};

using Loop = std::vector<std::uint32_t>;  // a polygon's points

// A facet, and what is left of it.
struct Cell {
  const Facet* facet{};
  std::vector<Loop> loops;
  bool whole{true};
};

double DistanceToSegment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - (a + t * (b - a))).norm();
}

// Splits a convex loop, which may have corners of 180°, into triangles of positive area.
void Triangulate(const PointSet& points, Loop loop,
                 std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const auto twice_area = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return (points[b] - points[a]).cross(points[c] - points[a]).norm();
  };
  double left = 0.0;
  for (std::size_t i = 2; i < loop.size(); ++i) left += twice_area(loop[0], loop[i - 1], loop[i]);
  while (loop.size() > 3) {
    const std::size_t n = loop.size();
    // The ear with the shortest cut, among those that leave neither a flat ear nor a flat rest.
    std::size_t best = n;
    double best_length = std::numeric_limits<double>::infinity();
    double best_area = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t a = loop[(i + n - 1) % n];
      const std::uint32_t c = loop[(i + 1) % n];
      const double area = twice_area(a, loop[i], c);
      const double length = (points[c] - points[a]).norm();
      const double flat = 1e-9 * length;
      if (area <= flat || left - area <= flat || length >= best_length) continue;
      best = i;
      best_length = length;
      best_area = area;
    }
    if (best == n) return;  // all on one line
    triangles.push_back({loop[(best + n - 1) % n], loop[best], loop[(best + 1) % n]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(best));
    left -= best_area;
  }
  if (loop.size() == 3) triangles.push_back({loop[0], loop[1], loop[2]});
}

// Trims one body's facets and appends them to the mesh.
class Trimmer {
 public:
  struct Cutter {
    const Slab* slab{};
    Effect effect{};
  };

  // The body stands in a frame O of W's axes.
  Trimmer(const Polyhedron& body, const Vector3d& p_WO, std::vector<Cutter> cutters)
      : body_(body), p_WO_(p_WO), cutters_(std::move(cutters)), points_(body.points) {}

  void Run(std::uint32_t owner, SurfaceMesh& mesh) {
    std::vector<Cell> cells;
    for (const Facet& facet : body_.facets) cells.push_back({&facet, {}, true});
    for (Cell& cell : cells) Trim(cell);
    for (const Cell& cell : cells) Emit(cell, owner, mesh);
  }

 private:
  void Trim(Cell& cell) {
    Polygon facet;
    AlignedBox3d box;
    for (const std::uint32_t corner : cell.facet->corners) {
      facet.push_back(points_[corner]);
      box.extend(facet.back());
    }
    const Vector3d normal = AreaVector(facet).normalized();
    // A void's facets show from the first, a solid's once a void bares them.
    const bool bared = std::any_of(cutters_.begin(), cutters_.end(), [](const Cutter& cutter) {
      return cutter.effect == Effect::kBares;
    });
    std::vector<Polygon> pieces{facet};
    std::vector<Polygon> next;
    if (bared) {
      std::vector<Polygon> shown;
      for (const Cutter& cutter : cutters_) {
        if (cutter.effect != Effect::kBares || !cutter.slab->box.intersects(box)) continue;
        next.clear();
        for (const Polygon& piece : pieces) {
          Polygon inside = Split(piece, normal, *cutter.slab, cutter.effect, next);
          if (inside.size() >= 3) shown.push_back(std::move(inside));
        }
        std::swap(pieces, next);
      }
      pieces = std::move(shown);
    }
    for (const Cutter& cutter : cutters_) {
      if (pieces.empty()) break;
      if (cutter.effect == Effect::kBares || !cutter.slab->box.intersects(box)) continue;
      next.clear();
      for (const Polygon& piece : pieces)
        (void)Split(piece, normal, *cutter.slab, cutter.effect, next);
      std::swap(pieces, next);
    }
    cell.whole = pieces.size() == 1 && pieces[0] == facet;
    if (cell.whole) {
      cell.loops.push_back(cell.facet->corners);
      return;
    }
    for (const Polygon& piece : pieces) AddLoop(piece, cell);
  }

  void AddLoop(const Polygon& piece, Cell& cell) {
    Loop loop;
    for (const Vector3d& p : piece) {
      const std::uint32_t index = points_.Find(p);
      if (loop.empty() || loop.back() != index) loop.push_back(index);
    }
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() < 3) return;
    for (const std::uint32_t index : loop) NoteOnEdges(index, cell);
    cell.loops.push_back(std::move(loop));
  }

  // Tells the neighbours of a new point on a shared edge.
  void NoteOnEdges(std::uint32_t index, const Cell& cell) {
    if (index < body_.points.size()) return;
    for (std::size_t i = 0; i < cell.facet->corners.size(); ++i) {
      const Vector3d& a = points_[cell.facet->corners[i]];
      const Vector3d& b = points_[cell.facet->corners[(i + 1) % cell.facet->corners.size()]];
      if (DistanceToSegment(points_[index], a, b) <= kWeld) {
        on_edge_[cell.facet->edges[i]].push_back(index);
      }
    }
  }

  // The loop with every point that lies on one of its edges.
  [[nodiscard]] Loop Complete(const Loop& loop, const Loop& candidates) const {
    Loop complete;
    std::vector<std::pair<double, std::uint32_t>> between;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t from = loop[i];
      const std::uint32_t to = loop[(i + 1) % loop.size()];
      const Vector3d& a = points_[from];
      const Vector3d edge = points_[to] - a;
      const double squared = edge.squaredNorm();
      between.clear();
      for (const std::uint32_t index : candidates) {
        const Vector3d ahead = points_[index] - a;
        const double t = ahead.dot(edge);
        if (t <= 0.0 || t >= squared || index == from || index == to) continue;
        if (ahead.cross(edge).squaredNorm() <= kWeld * kWeld * squared) {
          between.emplace_back(t, index);
        }
      }
      std::sort(between.begin(), between.end());
      complete.push_back(from);
      for (const auto& [t, index] : between) complete.push_back(index);
    }
    return complete;
  }

  void Emit(const Cell& cell, std::uint32_t owner, SurfaceMesh& mesh) {
    if (cell.loops.empty()) return;
    Loop candidates;
    for (const std::size_t edge : cell.facet->edges) {
      const auto found = on_edge_.find(edge);
      if (found != on_edge_.end()) {
        candidates.insert(candidates.end(), found->second.begin(), found->second.end());
      }
    }
    if (!cell.whole) {
      for (const Loop& loop : cell.loops) {
        candidates.insert(candidates.end(), loop.begin(), loop.end());
      }
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const Loop& loop : cell.loops) {
      Triangulate(points_, candidates.empty() ? loop : Complete(loop, candidates), triangles);
    }
    for (const auto& [a, b, c] : triangles) {
      mesh.triangles.push_back(
          {Vertex(a, cell, mesh), Vertex(b, cell, mesh), Vertex(c, cell, mesh)});
      mesh.owner.push_back(owner);
    }
  }

  std::uint32_t Vertex(std::uint32_t point, const Cell& cell, SurfaceMesh& mesh) {
    const std::uint64_t key = std::uint64_t{point} << 32 | cell.facet->shade;
    const auto [entry, is_new] =
        vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) {
      const VertexLook look = body_.look(points_[point], *cell.facet);
      mesh.positions.emplace_back(p_WO_ + points_[point]);
      mesh.normals.emplace_back(look.normal.cast<float>());
      mesh.surface_m.emplace_back(look.surface_m.cast<float>());
    }
    return entry->second;
  }

  const Polyhedron& body_;
  const Vector3d p_WO_;
  std::vector<Cutter> cutters_;
  PointSet points_;
  std::unordered_map<std::size_t, Loop> on_edge_;              // looked up only
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;  // looked up only
};

// For each body the others whose boxes meet its own, in order.
std::vector<std::vector<std::uint32_t>> Neighbours(const std::vector<Polyhedron>& solids) {
  std::vector<std::uint32_t> order(solids.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(solids[a].box.min().x(), a) < std::pair(solids[b].box.min().x(), b);
  });
  std::vector<std::vector<std::uint32_t>> neighbours(solids.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const AlignedBox3d& box = solids[order[i]].box;
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const AlignedBox3d& other = solids[order[j]].box;
      if (other.min().x() > box.max().x()) break;
      if (!box.intersects(other)) continue;
      neighbours[order[i]].push_back(order[j]);
      neighbours[order[j]].push_back(order[i]);
    }
  }
  for (auto& list : neighbours) std::sort(list.begin(), list.end());
  return neighbours;
}

// What a body does to another's facets; solids are numbered after the voids.
Effect EffectOf(std::uint32_t body, std::uint32_t facets, std::uint32_t first_solid) {
  const bool earlier = body < facets;
  if (body < first_solid) {
    if (facets >= first_solid) return Effect::kBares;
    return earlier ? Effect::kOpens : Effect::kOpensLater;
  }
  if (facets < first_solid) return Effect::kFills;
  return earlier ? Effect::kSwallows : Effect::kSwallowsLater;
}

// A point near the first primitive; whole kilometres subtract without rounding.
Vector3d Origin(std::span<const VoidPrimitive> primitives) {
  if (primitives.empty()) return Vector3d::Zero();
  return (primitives[0].X_WS.translation() / 1000.0).array().round() * 1000.0;
}

}  // namespace

SurfaceMesh Tessellate(std::span<const VoidPrimitive> voids, const TessellationOptions& options) {
  return Tessellate(voids, {}, options);
}

SurfaceMesh Tessellate(std::span<const VoidPrimitive> voids, std::span<const SolidPrimitive> solids,
                       const TessellationOptions& options) {
  if (!(options.tolerance_m > 0.0) || !(options.max_cell_m > 0.0)) {
    throw std::invalid_argument("tessellation tolerance and cell length must be above 0");
  }
  for (std::size_t i = 0; i < voids.size(); ++i) Check(voids[i], i);
  // Near the origin, so that a map's coordinates of hundreds of kilometres cost no precision.
  const Vector3d p_WO = Origin(voids);
  std::vector<Polyhedron> bodies;
  for (VoidPrimitive primitive : voids) {
    primitive.X_WS.translation() -= p_WO;
    bodies.push_back(PolyhedronOf(primitive, options.tolerance_m, options.max_cell_m));
  }
  for (const SolidPrimitive& solid : solids) {
    bodies.push_back(PolyhedronOf(Moved(solid, -p_WO), options.tolerance_m, options.max_cell_m));
  }
  const std::vector<std::vector<std::uint32_t>> neighbours = Neighbours(bodies);
  SurfaceMesh mesh;
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    std::vector<Trimmer::Cutter> cutters;
    for (const std::uint32_t other : neighbours[i]) {
      const Effect effect = EffectOf(other, i, static_cast<std::uint32_t>(voids.size()));
      for (const Slab& slab : bodies[other].slabs) {
        if (slab.box.intersects(bodies[i].box)) cutters.push_back({&slab, effect});
      }
    }
    // A solid that meets no void is nowhere seen.
    const auto bares = [](const Trimmer::Cutter& c) { return c.effect == Effect::kBares; };
    if (i >= voids.size() && std::none_of(cutters.begin(), cutters.end(), bares)) continue;
    Trimmer(bodies[i], p_WO, std::move(cutters)).Run(i, mesh);
  }
  return mesh;
}

SurfaceMesh Extract(const SurfaceMesh& mesh, std::uint32_t first_owner, std::uint32_t end_owner) {
  const auto first = std::lower_bound(mesh.owner.begin(), mesh.owner.end(), first_owner);
  const auto end = std::lower_bound(first, mesh.owner.end(), end_owner);
  SurfaceMesh part;
  part.owner.assign(first, end);
  std::unordered_map<std::uint32_t, std::uint32_t> index_of;  // looked up only
  for (auto i = first - mesh.owner.begin(); i < end - mesh.owner.begin(); ++i) {
    std::array<std::uint32_t, 3> triangle = mesh.triangles[static_cast<std::size_t>(i)];
    for (std::uint32_t& corner : triangle) {
      const auto [entry, is_new] =
          index_of.try_emplace(corner, static_cast<std::uint32_t>(part.positions.size()));
      if (is_new) {
        part.positions.push_back(mesh.positions[corner]);
        part.normals.push_back(mesh.normals[corner]);
        part.surface_m.push_back(mesh.surface_m[corner]);
      }
      corner = entry->second;
    }
    part.triangles.push_back(triangle);
  }
  return part;
}

}  // namespace kantaro::sim
