#include "sim/surface_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

namespace kantaro::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;  // convex, planar, counter-clockwise seen from the void
constexpr double kPi = std::numbers::pi;

// Facets and planes closer than this coincide.
constexpr double kTie = 2e-6;
// Facing caps closer than this have no wall between them.
constexpr double kMembrane = 1e-5;
// How far facets reach into each other at an edge, so that rounding opens no crack.
constexpr double kSeal = 2e-5;
// Cosine of the angle below which a facet and a plane count as parallel: less than a facet's turn.
const double kParallel = std::cos(kPi / 180.0);
// Points closer than this are one.
constexpr double kWeld = 1e-7;
// A cut that takes less is not worth making.
constexpr double kLeastArea = 1e-10;

struct Plane {
  Vector3d normal;  // into the void
  double offset{};
  bool internal{};  // between two slabs of one primitive: no wall

  [[nodiscard]] double Distance(const Vector3d& p) const { return normal.dot(p) - offset; }
};

Plane PlaneThrough(const Vector3d& p, const Vector3d& normal) {
  return {normal.normalized(), normal.normalized().dot(p), false};
}

// A convex piece of a primitive's polyhedron.
struct Slab {
  std::vector<Plane> planes;
  AlignedBox3d box;
};

enum class Group : std::uint8_t { kSide, kTop, kStart, kEnd };

// A primitive's polyhedron: profile polygons at stations along the axis, joined by flat facets.
struct Solid {
  std::size_t around{};          // corners of the profile, clockwise looking along the axis
  std::size_t stations{};        // at least 2
  std::vector<Vector3d> points;  // station by station
  std::vector<Group> groups;     // of the facet behind each corner
  std::vector<double> angles;    // of the middle of that facet, from the crown
  std::vector<Slab> slabs;
  AlignedBox3d box;

  [[nodiscard]] std::size_t Index(std::size_t station, std::size_t corner) const {
    return station * around + corner % around;
  }
  [[nodiscard]] const Vector3d& Point(std::size_t station, std::size_t corner) const {
    return points[Index(station, corner)];
  }
};

void Check(const VoidPrimitive& primitive, std::size_t index) {
  const double turn = primitive.length_m * std::abs(primitive.curvature);
  const bool sound = primitive.length_m > 0.0 && primitive.radius_m > 0.0 &&
                     std::isfinite(primitive.length_m) && std::isfinite(primitive.radius_m) &&
                     std::abs(primitive.curvature) * primitive.radius_m < 1.0 && turn < 2.0 * kPi &&
                     primitive.X_WS.matrix().allFinite() &&
                     (primitive.profile == Profile::kRound ||
                      (primitive.wall_height_m >= 0.0 && std::isfinite(primitive.wall_height_m)));
  if (!sound) {
    throw std::invalid_argument(fmt::format(
        "primitive {} cannot be tessellated: length {} m, radius {} m, curvature {} 1/m, wall {} m",
        index, primitive.length_m, primitive.radius_m, primitive.curvature,
        primitive.wall_height_m));
  }
}

// Of a full circle, a multiple of 4: so a kU's lower half has the same corners.
std::size_t SegmentsAround(double radius_m, double tolerance_m) {
  const double half = std::atan(std::sqrt(0.5 * tolerance_m / radius_m));
  return 4 * std::max<std::size_t>(2, static_cast<std::size_t>(std::ceil(kPi / (8.0 * half))));
}

std::size_t CellsAlong(const VoidPrimitive& primitive, const TessellationOptions& options) {
  double step = options.max_cell_m;
  if (primitive.curvature != 0.0) {
    const double outer = 1.0 / std::abs(primitive.curvature) + primitive.radius_m;
    const double turn = 2.0 * std::acos(std::max(0.5, 1.0 - 0.5 * options.tolerance_m / outer));
    step = std::min(step, turn / std::abs(primitive.curvature));
  }
  return static_cast<std::size_t>(std::max(1.0, std::ceil(primitive.length_m / step - 1e-9)));
}

// Corners (left, up), with the facets behind them. The polygon runs half inside and half outside
// the circle: facets deviate by half the sagitta, and wall areas are true.
std::vector<Vector2d> ProfileCorners(const VoidPrimitive& primitive, double tolerance_m,
                                     Solid& solid) {
  const std::size_t n = SegmentsAround(primitive.radius_m, tolerance_m);
  const double step = 2.0 * kPi / static_cast<double>(n);
  const double radius = primitive.radius_m * 2.0 / (1.0 + std::cos(0.5 * step));
  const bool round = primitive.profile == Profile::kRound;
  std::vector<Vector2d> corners;
  const auto add = [&](const Vector2d& corner, Group group, double angle) {
    corners.push_back(corner);
    solid.groups.push_back(group);
    solid.angles.push_back(angle);
  };
  const bool walls = !round && primitive.wall_height_m > kMembrane;
  if (walls) add({-radius, primitive.wall_height_m}, Group::kSide, 0.5 * kPi);
  const std::size_t first = round ? 0 : n / 4;
  const std::size_t last = round ? n - 1 : 3 * n / 4;
  for (std::size_t i = first; i <= last; ++i) {
    const double angle = static_cast<double>(i) * step;
    add({-radius * std::sin(angle), radius * std::cos(angle)}, Group::kSide, angle + 0.5 * step);
  }
  if (walls) add({radius, primitive.wall_height_m}, Group::kTop, 0.0);
  if (!round && !walls) solid.groups.back() = Group::kTop;
  return corners;
}

Slab SlabBetween(const Solid& solid, std::size_t first, std::size_t last, const Vector3d& start,
                 const Vector3d& end) {
  Slab slab;
  for (std::size_t j = 0; j < solid.around; ++j) {
    const Vector3d& p = solid.Point(first, j);
    slab.planes.push_back(
        PlaneThrough(p, (solid.Point(last, j) - p).cross(solid.Point(first, j + 1) - p)));
    slab.box.extend(p);
    slab.box.extend(solid.Point(last, j));
  }
  slab.planes.push_back(PlaneThrough(solid.Point(first, 0), start));
  slab.planes.back().internal = first > 0;
  slab.planes.push_back(PlaneThrough(solid.Point(last, 0), end));
  slab.planes.back().internal = last + 1 < solid.stations;
  slab.box.min().array() -= kMembrane;
  slab.box.max().array() += kMembrane;
  return slab;
}

Solid MakeSolid(const VoidPrimitive& primitive, const TessellationOptions& options) {
  Solid solid;
  const std::vector<Vector2d> corners = ProfileCorners(primitive, options.tolerance_m, solid);
  const std::size_t cells = CellsAlong(primitive, options);
  solid.around = corners.size();
  solid.stations = cells + 1;
  std::vector<Vector3d> forward;
  for (std::size_t i = 0; i <= cells; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(cells);
    const Eigen::Isometry3d X_WA = AxisPose(primitive, primitive.length_m * share);
    forward.emplace_back(X_WA.linear().col(0));
    for (const Vector2d& corner : corners) {
      solid.points.emplace_back(X_WA * Vector3d(0.0, corner.x(), corner.y()));
    }
  }
  const std::size_t step = primitive.curvature == 0.0 ? cells : 1;
  for (std::size_t i = 0; i < cells; i += step) {
    solid.slabs.push_back(SlabBetween(solid, i, i + step, forward[i], -forward[i + step]));
    solid.box.extend(solid.slabs.back().box);
  }
  return solid;
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

// Where a slab's plane cuts a facet (see Tessellate), and the distance above which it leaves it
// whole.
std::pair<double, double> CutAndSlack(const Plane& plane, const Vector3d& normal, bool earlier) {
  if (plane.internal) return {-kSeal, -kSeal};
  const double cosine = plane.normal.dot(normal);
  if (cosine > kParallel) return earlier ? std::pair(-kTie, -kTie) : std::pair(kTie, kTie);
  if (cosine < -kParallel) return {-kMembrane, -kMembrane};
  return {kSeal, -kTie};
}

// Appends what of the polygon lies outside the slab. `earlier`: the slab's primitive comes first.
void Subtract(const Polygon& polygon, const Vector3d& normal, const Slab& slab, bool earlier,
              std::vector<Polygon>& pieces) {
  std::vector<Cut> cuts;
  for (const Plane& plane : slab.planes) {
    const auto [cut, slack] = CutAndSlack(plane, normal, earlier);
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Vector3d& p : polygon) {
      const double distance = plane.Distance(p);
      lowest = std::min(lowest, distance);
      highest = std::max(highest, distance);
    }
    if (lowest >= slack) continue;
    if (highest <= cut) {
      pieces.push_back(polygon);
      return;
    }
    if (lowest < cut) cuts.push_back({&plane, cut});
  }
  Polygon inside = polygon;
  for (const Cut& cut : cuts) {
    inside = Clip(inside, *cut.plane, cut.at, 1.0);
    if (inside.size() < 3) break;
  }
  if (inside.size() < 3 || 0.5 * AreaVector(inside).norm() < kLeastArea) {
    pieces.push_back(polygon);
    return;
  }
  // Only planes that bound what is taken away may cut, lest the rest falls to splinters.
  Polygon rest = polygon;
  for (const Cut& cut : cuts) {
    const auto on_plane = [&](const Vector3d& p) {
      return std::abs(cut.plane->Distance(p) - cut.at) < 1e-9;
    };
    if (std::count_if(inside.begin(), inside.end(), on_plane) < 2) continue;
    Polygon piece = Clip(rest, *cut.plane, cut.at, -1.0);
    if (piece.size() >= 3) pieces.push_back(std::move(piece));
    rest = Clip(rest, *cut.plane, cut.at, 1.0);
  }
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

// One facet before and after trimming.
struct Cell {
  Group group{};
  double angle{};  // of its middle from the crown, for the seam
  Loop corners;
  std::vector<std::size_t>
      edges;                // numbers of the edges behind the corners, shared with neighbours
  std::vector<Loop> loops;  // what is left
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

// Trims one primitive's facets and appends them to the mesh.
class Trimmer {
 public:
  struct Obstacle {
    const Slab* slab{};
    bool earlier{};
  };

  // Primitive and solid stand in a frame O of W's axes.
  Trimmer(const VoidPrimitive& primitive, const Solid& solid, const Vector3d& p_WO,
          std::vector<Obstacle> obstacles)
      : primitive_(primitive),
        solid_(solid),
        p_WO_(p_WO),
        obstacles_(std::move(obstacles)),
        points_(solid.points) {}

  void Run(std::uint32_t owner, SurfaceMesh& mesh) {
    std::vector<Cell> cells = Facets();
    for (Cell& cell : cells) Trim(cell);
    for (const Cell& cell : cells) Emit(cell, owner, mesh);
  }

 private:
  [[nodiscard]] std::vector<Cell> Facets() const {
    const std::size_t n = solid_.around;
    const auto ring_edge = [&](std::size_t i, std::size_t j) { return 2 * solid_.Index(i, j); };
    const auto axis_edge = [&](std::size_t i, std::size_t j) { return 2 * solid_.Index(i, j) + 1; };
    const auto point = [&](std::size_t i, std::size_t j) {
      return static_cast<std::uint32_t>(solid_.Index(i, j));
    };
    std::vector<Cell> cells;
    for (std::size_t i = 0; i + 1 < solid_.stations; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        Cell& cell = cells.emplace_back();
        cell.group = solid_.groups[j];
        cell.angle = solid_.angles[j];
        cell.corners = {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
        cell.edges = {axis_edge(i, j), ring_edge(i + 1, j), axis_edge(i, j + 1), ring_edge(i, j)};
      }
    }
    const std::size_t end = solid_.stations - 1;
    Cell start_cap{Group::kStart, 0.0, {}, {}, {}};
    Cell end_cap{Group::kEnd, 0.0, {}, {}, {}};
    for (std::size_t j = 0; j < n; ++j) {
      start_cap.corners.push_back(point(0, j));
      start_cap.edges.push_back(ring_edge(0, j));
      end_cap.corners.push_back(point(end, n - j));
      end_cap.edges.push_back(ring_edge(end, n - j - 1));
    }
    cells.push_back(std::move(start_cap));
    cells.push_back(std::move(end_cap));
    return cells;
  }

  void Trim(Cell& cell) {
    Polygon facet;
    AlignedBox3d box;
    for (const std::uint32_t corner : cell.corners) {
      facet.push_back(points_[corner]);
      box.extend(facet.back());
    }
    const Vector3d normal = AreaVector(facet).normalized();
    std::vector<Polygon> pieces{facet};
    std::vector<Polygon> next;
    for (const Obstacle& obstacle : obstacles_) {
      if (pieces.empty() || !obstacle.slab->box.intersects(box)) continue;
      next.clear();
      for (const Polygon& piece : pieces) {
        Subtract(piece, normal, *obstacle.slab, obstacle.earlier, next);
      }
      std::swap(pieces, next);
    }
    cell.whole = pieces.size() == 1 && pieces[0] == facet;
    if (cell.whole) {
      cell.loops.push_back(cell.corners);
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
    if (index < solid_.points.size()) return;
    for (std::size_t i = 0; i < cell.corners.size(); ++i) {
      const Vector3d& a = points_[cell.corners[i]];
      const Vector3d& b = points_[cell.corners[(i + 1) % cell.corners.size()]];
      if (DistanceToSegment(points_[index], a, b) <= kWeld) {
        on_edge_[cell.edges[i]].push_back(index);
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
    for (const std::size_t edge : cell.edges) {
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
    // Points on the crown's seam have two texture coordinates.
    const std::uint64_t key = std::uint64_t{point} << 3 |
                              static_cast<std::uint64_t>(cell.group) << 1 |
                              (cell.angle > kPi ? 1U : 0U);
    const auto [entry, is_new] =
        vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) AddVertex(points_[point], cell, mesh);
    return entry->second;
  }

  void AddVertex(const Vector3d& p_O, const Cell& cell, SurfaceMesh& mesh) const {
    const SweepPoint s = ToSweep(primitive_, p_O);
    const Eigen::Matrix3d R_WA = AxisPose(primitive_, s.along_m).linear();
    const double along = std::clamp(s.along_m, 0.0, primitive_.length_m);
    const double radius = primitive_.radius_m;
    Vector3d normal_A;
    Vector2d coordinates(primitive_.start_chainage_m + along, s.left_m);
    switch (cell.group) {
      case Group::kStart:
      case Group::kEnd:
        normal_A = cell.group == Group::kStart ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX());
        coordinates.x() += s.up_m;
        break;
      case Group::kTop:
        normal_A = -Vector3d::UnitZ();
        break;
      case Group::kSide:
        if (primitive_.profile == Profile::kU && s.up_m > 0.0) {
          normal_A = {0.0, s.left_m > 0.0 ? -1.0 : 1.0, 0.0};
          coordinates.y() =
              radius * kPi + (s.left_m > 0.0 ? 1.0 : -1.0) * (0.5 * kPi * radius + s.up_m);
        } else {
          normal_A = Vector3d(0.0, -s.left_m, -s.up_m).normalized();
          double angle = std::atan2(-s.left_m, s.up_m);
          angle += 2.0 * kPi * std::round((cell.angle - angle) / (2.0 * kPi));
          coordinates.y() = radius * angle;
        }
        break;
    }
    mesh.positions.emplace_back(p_WO_ + p_O);
    mesh.normals.emplace_back((R_WA * normal_A).cast<float>());
    mesh.surface_m.emplace_back(coordinates.cast<float>());
  }

  const VoidPrimitive& primitive_;
  const Solid& solid_;
  const Vector3d p_WO_;
  std::vector<Obstacle> obstacles_;
  PointSet points_;
  std::unordered_map<std::size_t, Loop> on_edge_;              // looked up only
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;  // looked up only
};

// For each solid the others whose boxes meet its own, in order.
std::vector<std::vector<std::uint32_t>> Neighbours(const std::vector<Solid>& solids) {
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

// A point near the first primitive; whole kilometres subtract without rounding.
Vector3d Origin(std::span<const VoidPrimitive> primitives) {
  if (primitives.empty()) return Vector3d::Zero();
  return (primitives[0].X_WS.translation() / 1000.0).array().round() * 1000.0;
}

}  // namespace

SurfaceMesh Tessellate(std::span<const VoidPrimitive> primitives,
                       const TessellationOptions& options) {
  if (!(options.tolerance_m > 0.0) || !(options.max_cell_m > 0.0)) {
    throw std::invalid_argument("tessellation tolerance and cell length must be above 0");
  }
  for (std::size_t i = 0; i < primitives.size(); ++i) Check(primitives[i], i);
  // Near the origin, so that a map's coordinates of hundreds of kilometres cost no precision.
  const Vector3d p_WO = Origin(primitives);
  std::vector<VoidPrimitive> local(primitives.begin(), primitives.end());
  std::vector<Solid> solids;
  for (VoidPrimitive& primitive : local) {
    primitive.X_WS.translation() -= p_WO;
    solids.push_back(MakeSolid(primitive, options));
  }
  const std::vector<std::vector<std::uint32_t>> neighbours = Neighbours(solids);
  SurfaceMesh mesh;
  for (std::uint32_t i = 0; i < solids.size(); ++i) {
    std::vector<Trimmer::Obstacle> obstacles;
    for (const std::uint32_t other : neighbours[i]) {
      for (const Slab& slab : solids[other].slabs) {
        if (slab.box.intersects(solids[i].box)) obstacles.push_back({&slab, other < i});
      }
    }
    Trimmer(local[i], solids[i], p_WO, std::move(obstacles)).Run(i, mesh);
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
