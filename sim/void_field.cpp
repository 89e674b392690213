#include "sim/void_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 0.5;

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

/// Nearest point of the intersection of two half-spaces {distance <= 0}: its distance and
/// direction.
Wall NearestOfWedge(const Wall& a, const Wall& b) {
  const double c = a.normal_W.dot(b.normal_W);
  const Wall& further = a.distance_m > b.distance_m ? a : b;
  constexpr double kParallel = 0.99999;
  if (c > kParallel) return further;
  if (c < -kParallel) {
    return a.distance_m + b.distance_m > 0.0
               ? Wall{std::numeric_limits<double>::infinity(), further.normal_W}
               : further;
  }
  const double alpha = a.distance_m - c * b.distance_m;
  const double beta = b.distance_m - c * a.distance_m;
  if (alpha <= 0.0 || beta <= 0.0) return further;
  const Vector3d offset = (alpha * a.normal_W + beta * b.normal_W) / (1.0 - c * c);
  const double distance = offset.norm();
  return {distance, offset / distance};
}

/// Voids that reach into the sphere around a point, each with the walls that do.
struct Local {
  static constexpr std::size_t kMost = 8;
  std::array<Walls, kMost> voids;
  std::size_t count{};
};

/// Least over all choices of one wall from each void of the greatest over the pairs chosen.
void Choose(const Local& local, std::size_t depth, std::array<const Wall*, Local::kMost>& chosen,
            const Wall& so_far, Wall& best) {
  if (so_far.distance_m >= best.distance_m) return;
  if (depth == local.count) {
    best = so_far;
    return;
  }
  const Walls& walls = local.voids[depth];
  for (int i = 0; i < walls.count; ++i) {
    const Wall& wall = walls.wall[static_cast<std::size_t>(i)];
    Wall greatest = so_far;
    if (depth == 0) greatest = wall;
    for (std::size_t j = 0; j < depth; ++j) {
      const Wall pair = NearestOfWedge(*chosen[j], wall);
      if (pair.distance_m > greatest.distance_m) greatest = pair;
    }
    chosen[depth] = &wall;
    Choose(local, depth + 1, chosen, greatest, best);
  }
}

}  // namespace

VoidField::VoidField(std::vector<VoidPrimitive> voids) : voids_(std::move(voids)) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries;
  for (std::uint32_t i = 0; i < voids_.size(); ++i) {
    const Eigen::AlignedBox3d& box = boxes_.emplace_back(BoundingBox(voids_[i]));
    const Vector3d low = box.min().array() - kLargestReach_m;
    const Vector3d high = box.max().array() + kLargestReach_m;
    for (auto x = Coordinate(low.x()); x <= Coordinate(high.x()); ++x) {
      for (auto y = Coordinate(low.y()); y <= Coordinate(high.y()); ++y) {
        for (auto z = Coordinate(low.z()); z <= Coordinate(high.z()); ++z)
          entries.emplace_back(Key(x, y, z), i);
      }
    }
  }
  std::sort(entries.begin(), entries.end());
  for (std::uint32_t i = 0; i < entries.size(); ++i) {
    auto& run = cells_.try_emplace(entries[i].first, i, i).first->second;
    run.second = i + 1;
    members_.push_back(entries[i].second);
  }
}

std::uint64_t VoidField::Cell(const Vector3d& p_W) const {
  return Key(Coordinate(p_W.x()), Coordinate(p_W.y()), Coordinate(p_W.z()));
}

Nearby VoidField::Around(const Vector3d& p_W, double reach_m) const {
  Nearby nearby;
  const auto run = cells_.find(Cell(p_W));
  if (run == cells_.end()) return nearby;
  for (std::uint32_t i = run->second.first; i < run->second.second; ++i) {
    const std::uint32_t member = members_[i];
    if (boxes_[member].squaredExteriorDistance(p_W) > reach_m * reach_m) continue;
    if (InsideDistance(voids_[member], p_W) < -reach_m) continue;
    if (nearby.count_ == Nearby::kMost)
      throw std::length_error("more voids meet in one place than contact allows for");
    nearby.voids_[nearby.count_++] = &voids_[member];
  }
  return nearby;
}

Wall VoidField::NearestWall(const Nearby& nearby, const Vector3d& p_W, double cap_m) {
  Local local;
  Wall shallowest{-std::numeric_limits<double>::infinity(), Vector3d::UnitZ()};
  for (const VoidPrimitive* primitive : nearby.voids()) {
    const Walls all = WallsAround(*primitive, p_W);
    Walls near;
    const Wall* least = &all.wall[0];
    for (int i = 0; i < all.count; ++i) {
      const Wall& wall = all.wall[static_cast<std::size_t>(i)];
      if (wall.distance_m < least->distance_m) least = &wall;
      if (wall.distance_m < cap_m) near.wall[static_cast<std::size_t>(near.count++)] = wall;
    }
    if (near.count == 0) return {cap_m, least->normal_W};
    if (least->distance_m > shallowest.distance_m) shallowest = *least;
    if (least->distance_m <= -cap_m) continue;
    if (local.count == Local::kMost)
      throw std::length_error("more voids meet in one place than contact allows for");
    local.voids[local.count++] = near;
  }
  if (local.count == 0) return shallowest;
  if (local.count == 1) {
    const Walls& walls = local.voids[0];
    const Wall* least = &walls.wall[0];
    for (int i = 1; i < walls.count; ++i) {
      if (walls.wall[static_cast<std::size_t>(i)].distance_m < least->distance_m)
        least = &walls.wall[static_cast<std::size_t>(i)];
    }
    return *least;
  }
  Wall best{cap_m, shallowest.normal_W};
  std::array<const Wall*, Local::kMost> chosen{};
  Choose(local, 0, chosen, {-std::numeric_limits<double>::infinity(), Vector3d::UnitZ()}, best);
  return best;
}

}  // namespace kantaro::sim
