#include "sim/polyhedron.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/polyhedron_parts.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

enum class Group : std::uint8_t { kSide, kTop, kStart, kEnd };

// Profile polygons at stations along the axis.
struct Grid {
  std::size_t around{};           // corners of the profile, clockwise looking along the axis
  std::size_t stations{};         // at least 2
  std::vector<Group> groups;      // of the facet behind each corner
  std::vector<double> angles;     // of the middle of that facet, from the crown
  std::vector<Vector2d> corners;  // (left, up)

  [[nodiscard]] std::size_t Index(std::size_t station, std::size_t corner) const {
    return station * around + corner % around;
  }
};

Grid GridOf(const VoidPrimitive& primitive, double tolerance_m, double max_cell_m) {
  Grid grid;
  const std::size_t n = SegmentsAround(primitive.radius_m, tolerance_m);
  const double step = 2.0 * kPi / static_cast<double>(n);
  const double radius = CornerRadius(primitive.radius_m, step);
  const bool round = primitive.profile == Profile::kRound;
  const double wall = primitive.wall_height_m;
  const auto add = [&](const Vector2d& corner, Group group, double angle) {
    grid.corners.push_back(corner);
    grid.groups.push_back(group);
    grid.angles.push_back(angle);
  };
  const auto add_arc = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i <= last; ++i) {
      const double angle = static_cast<double>(i) * step;
      add({-radius * std::sin(angle), radius * std::cos(angle)}, Group::kSide, angle + 0.5 * step);
    }
  };
  if (round) {
    add_arc(0, n - 1);
  } else if (wall > kMembrane_m) {
    add({-radius, wall}, Group::kSide, 0.5 * kPi);
    add_arc(n / 4, 3 * n / 4);
    add({radius, wall}, Group::kTop, 0.0);
  } else {
    // Where the rim lies below the axis, the arc ends in its own facets' line.
    const double rim = std::acos(std::clamp(wall / radius, -1.0, 0.0));
    const auto first = static_cast<std::size_t>(std::floor(rim / step + 1e-9)) + 1;
    add({-radius * std::sin(rim), std::min(wall, 0.0)}, Group::kSide, rim);
    add_arc(first, n - first);
    add({radius * std::sin(rim), std::min(wall, 0.0)}, Group::kTop, 0.0);
  }
  grid.around = grid.corners.size();
  grid.stations = 1 + CellsAlong(primitive, primitive.radius_m, tolerance_m, max_cell_m);
  return grid;
}

Slab SlabBetween(const Polyhedron& solid, const Grid& grid, std::size_t first, std::size_t last,
                 const Vector3d& start, const Vector3d& end) {
  const auto point = [&](std::size_t station, std::size_t corner) {
    return solid.points[grid.Index(station, corner)];
  };
  Slab slab;
  for (std::size_t j = 0; j < grid.around; ++j) {
    const Vector3d p = point(first, j);
    slab.planes.push_back(PlaneThrough(p, (point(last, j) - p).cross(point(first, j + 1) - p)));
    slab.box.extend(p);
    slab.box.extend(point(last, j));
  }
  slab.planes.push_back(PlaneThrough(point(first, 0), start));
  slab.planes.back().internal = first > 0;
  slab.planes.push_back(PlaneThrough(point(last, 0), end));
  slab.planes.back().internal = last + 1 < grid.stations;
  Grow(slab);
  return slab;
}

// Points on the crown's seam have two texture coordinates.
std::uint32_t ShadeOf(Group group, double angle) {
  return static_cast<std::uint32_t>(group) << 1 | (angle > kPi ? 1U : 0U);
}

std::vector<Facet> FacetsOf(const Grid& grid) {
  const std::size_t n = grid.around;
  const auto ring_edge = [&](std::size_t i, std::size_t j) { return 2 * grid.Index(i, j); };
  const auto axis_edge = [&](std::size_t i, std::size_t j) { return 2 * grid.Index(i, j) + 1; };
  const auto point = [&](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(grid.Index(i, j));
  };
  std::vector<Facet> facets;
  for (std::size_t i = 0; i + 1 < grid.stations; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      Facet& facet = facets.emplace_back();
      facet.angle = grid.angles[j];
      facet.shade = ShadeOf(grid.groups[j], facet.angle);
      facet.corners = {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
      facet.edges = {axis_edge(i, j), ring_edge(i + 1, j), axis_edge(i, j + 1), ring_edge(i, j)};
    }
  }
  const std::size_t end = grid.stations - 1;
  Facet start_cap, end_cap;
  start_cap.shade = ShadeOf(Group::kStart, 0.0);
  end_cap.shade = ShadeOf(Group::kEnd, 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    start_cap.corners.push_back(point(0, j));
    start_cap.edges.push_back(ring_edge(0, j));
    end_cap.corners.push_back(point(end, n - j));
    end_cap.edges.push_back(ring_edge(end, n - j - 1));
  }
  facets.push_back(std::move(start_cap));
  facets.push_back(std::move(end_cap));
  return facets;
}

VertexLook LookOf(const VoidPrimitive& primitive, const Vector3d& p, const Facet& facet) {
  const SweepPoint s = ToSweep(primitive, p);
  const Eigen::Matrix3d R_WA = AxisPose(primitive, s.along_m).linear();
  const double along = std::clamp(s.along_m, 0.0, primitive.length_m);
  const double radius = primitive.radius_m;
  Vector3d normal_A = Vector3d::UnitX();
  Vector2d coordinates(primitive.start_chainage_m + along, s.left_m);
  switch (static_cast<Group>(facet.shade >> 1)) {
    case Group::kStart:
      coordinates.x() += s.up_m;
      break;
    case Group::kEnd:
      normal_A = -Vector3d::UnitX();
      coordinates.x() += s.up_m;
      break;
    case Group::kTop:
      normal_A = -Vector3d::UnitZ();
      break;
    case Group::kSide:
      if (primitive.profile == Profile::kU && s.up_m > 0.0) {
        normal_A = {0.0, s.left_m > 0.0 ? -1.0 : 1.0, 0.0};
        coordinates.y() =
            radius * kPi + (s.left_m > 0.0 ? 1.0 : -1.0) * (0.5 * kPi * radius + s.up_m);
      } else {
        normal_A = Vector3d(0.0, -s.left_m, -s.up_m).normalized();
        double angle = std::atan2(-s.left_m, s.up_m);
        angle += 2.0 * kPi * std::round((facet.angle - angle) / (2.0 * kPi));
        coordinates.y() = radius * angle;
      }
      break;
  }
  return {R_WA * normal_A, coordinates};
}

}  // namespace

Polyhedron PolyhedronOf(const VoidPrimitive& primitive, double tolerance_m, double max_cell_m) {
  Polyhedron body;
  const Grid grid = GridOf(primitive, tolerance_m, max_cell_m);
  const std::size_t cells = grid.stations - 1;
  std::vector<Vector3d> forward;
  for (std::size_t i = 0; i <= cells; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(cells);
    const Isometry3d X_WA = AxisPose(primitive, primitive.length_m * share);
    forward.emplace_back(X_WA.linear().col(0));
    for (const Vector2d& corner : grid.corners) {
      body.points.emplace_back(X_WA * Vector3d(0.0, corner.x(), corner.y()));
    }
  }
  const std::size_t step = primitive.curvature == 0.0 ? cells : 1;
  for (std::size_t i = 0; i < cells; i += step) {
    body.slabs.push_back(SlabBetween(body, grid, i, i + step, forward[i], -forward[i + step]));
    body.box.extend(body.slabs.back().box);
  }
  body.facets = FacetsOf(grid);
  body.look = [primitive](const Vector3d& p, const Facet& facet) {
    return LookOf(primitive, p, facet);
  };
  return body;
}

}  // namespace kantaro::sim
