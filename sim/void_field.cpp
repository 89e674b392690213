#include "sim/void_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace kantaro::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kCell_m = 0.5;
/// How far inside a void a point must lie for the void to take it away: where voids only touch,
/// their walls are one.
constexpr double kOpen_m = 1e-9;
/// Normals of walls that meet at less than this sine are one wall's.
constexpr double kParallel = 4.5e-3;
/// Edges of curved walls are found again from where they were found first, so often.
constexpr int kRefinements = 2;
/// The nearest point lies on no more walls than this; whatever is left then is a splinter.
constexpr std::size_t kMostWalls = 6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::uint64_t Key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  const auto part = [](std::int64_t v) {
    return static_cast<std::uint64_t>(v + (1 << 20)) & kMask;
  };
  return part(x) << 42 | part(y) << 21 | part(z);
}

std::int64_t Coordinate(double value) {
  return static_cast<std::int64_t>(std::floor(value / kCell_m));
}

/// One wall that the nearest point must lie behind, taken as flat: its distance is from the point
/// asked about, its normal that of the place where it was looked at last.
struct Constraint {
  const VoidPrimitive* primitive{};
  int index{};
  Wall plane;

  /// Takes the wall as it is at p + offset.
  void LookFrom(const Vector3d& p_W, const Vector3d& offset) {
    plane = WallAt(*primitive, index, p_W + offset);
    plane.distance_m -= plane.normal_W.dot(offset);
  }
  [[nodiscard]] bool Holds(const Vector3d& offset) const {
    return plane.distance_m + plane.normal_W.dot(offset) <= kOpen_m;
  }
};

/// Nearest point of what lies behind some walls, as an offset from the point asked about.
struct Foot {
  double distance_m{kInfinity};  ///< infinite if there is none
  Vector3d offset{Vector3d::Zero()};
};

/// The nearest point on one, two or three planes, if it is also the nearest behind them.
Foot FootOn(const Wall& a) {
  if (a.distance_m < 0.0) return {};
  return {a.distance_m, -a.distance_m * a.normal_W};
}

Foot FootOn(const Wall& a, const Wall& b) {
  const double c = a.normal_W.dot(b.normal_W);
  const double s2 = 1.0 - c * c;
  if (s2 < kParallel * kParallel) return {};
  const double alpha = (a.distance_m - c * b.distance_m) / s2;
  const double beta = (b.distance_m - c * a.distance_m) / s2;
  if (alpha < 0.0 || beta < 0.0) return {};
  const Vector3d offset = -(alpha * a.normal_W + beta * b.normal_W);
  return {offset.norm(), offset};
}

Foot FootOn(const Wall& a, const Wall& b, const Wall& c) {
  const Vector3d bc = b.normal_W.cross(c.normal_W);
  const Vector3d ca = c.normal_W.cross(a.normal_W);
  const Vector3d ab = a.normal_W.cross(b.normal_W);
  const double volume = a.normal_W.dot(bc);
  if (std::abs(volume) < kParallel) return {};
  const Vector3d offset = -(a.distance_m * bc + b.distance_m * ca + c.distance_m * ab) / volume;
  // The offset is a sum of the normals; all must push.
  const bool pushed = offset.dot(bc) / volume <= 0.0 && offset.dot(ca) / volume <= 0.0 &&
                      offset.dot(ab) / volume <= 0.0;
  if (!pushed) return {};
  return {offset.norm(), offset};
}

/// Looks for the nearest point of the ground to a point in the open.
class GroundSearch {
 public:
  GroundSearch(const Vector3d& p_W, double cap_m) : p_W_(p_W), cap_m_(cap_m) {}

  void Add(const VoidPrimitive* primitive) { voids_.push_back(primitive); }
  [[nodiscard]] std::size_t count() const { return voids_.size(); }

  /// @param around  the walls at the point of the void that it lies deepest in.
  Wall Nearest(const VoidPrimitive* deepest, const Walls& around) {
    best_ = {cap_m_, around.wall[static_cast<std::size_t>(around.least)].normal_W};
    Branch(0, deepest, around, Vector3d::Zero());
    return best_;
  }

 private:
  /// The first `count` constraints hold at the foot. Takes it if no void takes it away; else tries
  /// each wall of the void that does.
  void Descend(std::size_t count, const Foot& foot) {
    if (foot.distance_m >= best_.distance_m) return;
    const Vector3d p_WF = p_W_ + foot.offset;
    const VoidPrimitive* open = count < kMostWalls ? OpenAt(count, p_WF) : nullptr;
    if (open == nullptr) {
      best_.distance_m = foot.distance_m;
      best_.normal_W = foot.distance_m > 0.0 ? Vector3d(-foot.offset / foot.distance_m)
                                             : constraints_[count - 1].plane.normal_W;
      return;
    }
    Branch(count, open, WallsAround(*open, p_WF, cap_m_ + foot.distance_m), foot.offset);
  }

  void Branch(std::size_t count, const VoidPrimitive* primitive, const Walls& walls,
              const Vector3d& offset) {
    // The nearest first: then most of the others need no look.
    for (int i = 0; i < walls.count; ++i) {
      const int at = i == 0 ? walls.least : i <= walls.least ? i - 1 : i;
      const auto slot = static_cast<std::size_t>(at);
      Constraint& added = constraints_[count];
      added = {primitive, walls.index[slot], walls.wall[slot]};
      added.plane.distance_m -= added.plane.normal_W.dot(offset);
      Descend(count + 1, Project(count + 1));
    }
  }

  /// The void that the point lies deepest in.
  [[nodiscard]] const VoidPrimitive* OpenAt(std::size_t count, const Vector3d& p_W) const {
    const VoidPrimitive* open = nullptr;
    double deepest = kOpen_m;
    for (const VoidPrimitive* primitive : voids_) {
      const auto chosen = [&](const Constraint& c) { return c.primitive == primitive; };
      if (std::any_of(constraints_.begin(), constraints_.begin() + count, chosen)) continue;
      const double inside = InsideDistance(*primitive, p_W);
      if (inside > deepest) std::tie(open, deepest) = std::pair(primitive, inside);
    }
    return open;
  }

  /// The nearest point behind the first `count` constraints. It lies on the last of them: without
  /// it, the nearest lay in front of it.
  Foot Project(std::size_t count) {
    const std::size_t last = count - 1;
    Foot foot = FootOn(constraints_[last].plane);
    if (Hold(count, foot)) return foot;
    for (std::size_t i = 0; i < last; ++i) {
      foot = FootOn(constraints_[i].plane, constraints_[last].plane);
      if (Hold(count, foot)) return Refined(foot, last, i, i);
    }
    for (std::size_t i = 0; i < last; ++i) {
      for (std::size_t j = i + 1; j < last; ++j) {
        foot = FootOn(constraints_[i].plane, constraints_[j].plane, constraints_[last].plane);
        if (Hold(count, foot)) return Refined(foot, last, i, j);
      }
    }
    return {};
  }

  [[nodiscard]] bool Hold(std::size_t count, const Foot& foot) const {
    return foot.distance_m < kInfinity &&
           std::all_of(constraints_.begin(), constraints_.begin() + count,
                       [&](const Constraint& c) { return c.Holds(foot.offset); });
  }

  /// The same corner (of two walls if j is i) with the walls as they are there.
  [[nodiscard]] Foot Refined(Foot foot, std::size_t last, std::size_t i, std::size_t j) const {
    std::array<Constraint, 3> walls{constraints_[last], constraints_[i], constraints_[j]};
    const std::size_t count = i == j ? 2 : 3;
    for (int n = 0; n < kRefinements; ++n) {
      for (std::size_t k = 0; k < count; ++k) walls[k].LookFrom(p_W_, foot.offset);
      const Foot next = i == j ? FootOn(walls[0].plane, walls[1].plane)
                               : FootOn(walls[0].plane, walls[1].plane, walls[2].plane);
      if (next.distance_m == kInfinity) break;
      foot = next;
    }
    return foot;
  }

  const Vector3d& p_W_;
  double cap_m_;
  boost::container::small_vector<const VoidPrimitive*, 24> voids_;
  std::array<Constraint, kMostWalls> constraints_;
  Wall best_;
};

/// The stretch of a void from `start_m` on.
AlignedBox3d BoxOfStretch(const VoidPrimitive& primitive, double start_m, double length_m) {
  VoidPrimitive stretch = primitive;
  stretch.X_WS = AxisPose(primitive, start_m);
  stretch.length_m = length_m;
  return BoundingBox(stretch);
}

/// Grid cells that a box reaches into.
template <typename Visit>
void VisitCells(const AlignedBox3d& box, double reach_m, const Visit& visit) {
  const Vector3d low = box.min().array() - reach_m;
  const Vector3d high = box.max().array() + reach_m;
  for (auto x = Coordinate(low.x()); x <= Coordinate(high.x()); ++x) {
    for (auto y = Coordinate(low.y()); y <= Coordinate(high.y()); ++y) {
      for (auto z = Coordinate(low.z()); z <= Coordinate(high.z()); ++z)
        visit(Key(x, y, z),
              kCell_m * Vector3d(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5,
                                 static_cast<double>(z) + 0.5));
    }
  }
}

}  // namespace

VoidField::VoidField(std::vector<VoidPrimitive> voids, std::vector<SolidPrimitive> solids)
    : voids_(std::move(voids)), solids_(std::move(solids)) {
  for (const VoidPrimitive& primitive : voids_) void_boxes_.push_back(BoundingBox(primitive));
  for (const SolidPrimitive& solid : solids_) solid_boxes_.push_back(BoundingBox(solid));
  Index();
}

void VoidField::Index() {
  // By cell, voids before solids.
  std::vector<std::tuple<std::uint64_t, bool, std::uint32_t>> entries;
  const double half_diagonal = 0.5 * std::sqrt(3.0) * kCell_m;
  for (std::uint32_t i = 0; i < voids_.size(); ++i) {
    // Stretch by stretch: a box around a long pipe that lies askew is mostly empty.
    const double length = voids_[i].length_m;
    const int stretches = std::max(1, static_cast<int>(length / kCell_m));
    for (int k = 0; k < stretches; ++k) {
      const AlignedBox3d box = BoxOfStretch(voids_[i], k * length / stretches, length / stretches);
      VisitCells(box, kLargestReach_m, [&](std::uint64_t key, const Vector3d& p_WM) {
        if (InsideDistance(voids_[i], p_WM) > -kLargestReach_m - half_diagonal)
          entries.emplace_back(key, false, i);
      });
    }
  }
  for (std::uint32_t i = 0; i < solids_.size(); ++i) {
    VisitCells(solid_boxes_[i], kLargestReach_m,
               [&](std::uint64_t key, const Vector3d&) { entries.emplace_back(key, true, i); });
  }
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  members_.reserve(entries.size());
  for (std::uint32_t i = 0; i < entries.size(); ++i) {
    const auto& [key, solid, member] = entries[i];
    Cell& cell = cells_.try_emplace(key, Cell{i, i, i}).first->second;
    if (!solid) cell.first_solid = i + 1;
    cell.end = i + 1;
    members_.push_back(member);
  }
}

Nearby VoidField::Around(const Vector3d& p_W, double reach_m) const {
  Nearby nearby;
  const auto found =
      cells_.find(Key(Coordinate(p_W.x()), Coordinate(p_W.y()), Coordinate(p_W.z())));
  if (found == cells_.end()) return nearby;
  const Cell& cell = found->second;
  for (std::uint32_t i = cell.first_void; i < cell.first_solid; ++i) {
    const std::uint32_t member = members_[i];
    if (void_boxes_[member].squaredExteriorDistance(p_W) > reach_m * reach_m) continue;
    if (InsideDistance(voids_[member], p_W) < -reach_m) continue;
    nearby.voids_.push_back(&voids_[member]);
  }
  for (std::uint32_t i = cell.first_solid; i < cell.end; ++i) {
    const std::uint32_t member = members_[i];
    if (solid_boxes_[member].squaredExteriorDistance(p_W) > reach_m * reach_m) continue;
    nearby.solids_.push_back(&solids_[member]);
  }
  return nearby;
}

Wall VoidField::NearestWall(const Nearby& nearby, const Vector3d& p_W, double cap_m) {
  GroundSearch search(p_W, cap_m);
  const VoidPrimitive* deepest = nullptr;
  Walls walls;
  Wall ground{-kLargestReach_m, Vector3d::UnitZ()};
  bool far = false;
  for (const VoidPrimitive* primitive : nearby.voids_) {
    const Walls around = WallsAround(*primitive, p_W, cap_m);
    const Wall& least = around.wall[static_cast<std::size_t>(around.least)];
    if (least.distance_m > ground.distance_m) {
      ground = least;
      walls = around;
      deepest = primitive;
    }
    far = far || least.distance_m >= cap_m;
    if (far) break;
    if (least.distance_m > -cap_m) search.Add(primitive);
  }
  if (far) {
    ground.distance_m = cap_m;
  } else if (search.count() > 1 && ground.distance_m > 0.0) {
    ground = search.Nearest(deepest, walls);
  }
  for (const SolidPrimitive* solid : nearby.solids_) {
    const Wall surface = SurfaceOf(*solid, p_W);
    if (surface.distance_m < ground.distance_m) ground = surface;
  }
  return ground;
}

}  // namespace kantaro::sim
