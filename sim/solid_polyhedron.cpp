#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>
#include <variant>

#include "sim/polyhedron.hpp"
#include "sim/polyhedron_parts.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

using Loop = std::vector<std::uint32_t>;

// Facets of one shade are smooth, others flat.
constexpr std::uint32_t kInner = 0, kOuter = 1, kFlat = 2;

// Puts a polyhedron together from convex cells.
class Assembly {
 public:
  struct Face {
    Loop corners;  // counter-clockwise seen from outside
    bool internal{};
    std::uint32_t shade{kFlat};
    double angle{};
  };

  std::uint32_t Point(const Vector3d& p) {
    body_.points.push_back(p);
    return static_cast<std::uint32_t>(body_.points.size() - 1);
  }

  void AddCell(const std::vector<Face>& faces) {
    Slab slab;
    for (const Face& face : faces) {
      const Vector3d outward = OutwardOf(face.corners);
      for (const std::uint32_t i : face.corners) slab.box.extend(body_.points[i]);
      slab.planes.push_back(PlaneThrough(body_.points[face.corners[0]], -outward));
      slab.planes.back().internal = face.internal;
      if (!face.internal) AddFacet(face, outward);
    }
    Grow(slab);
    body_.box.extend(slab.box);
    body_.slabs.push_back(std::move(slab));
  }

  // Two loops of equal size; the bottom is counter-clockwise seen from the top. The faces come in
  // the order of the corners, then bottom and top.
  static std::vector<Face> Prism(const Loop& bottom, const Loop& top) {
    std::vector<Face> faces;
    const std::size_t n = bottom.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      faces.push_back({{bottom[i], bottom[j], top[j], top[i]}});
    }
    faces.push_back({Loop(bottom.rbegin(), bottom.rend())});
    faces.push_back({top});
    return faces;
  }

  Polyhedron Take() { return std::move(body_); }

 private:
  [[nodiscard]] Vector3d OutwardOf(const Loop& corners) const {
    Vector3d sum = Vector3d::Zero();
    const Vector3d& p = body_.points[corners[0]];
    for (std::size_t i = 2; i < corners.size(); ++i)
      sum += (body_.points[corners[i - 1]] - p).cross(body_.points[corners[i]] - p);
    return sum.normalized();
  }

  void AddFacet(const Face& face, const Vector3d& outward) {
    Facet facet;
    facet.corners = face.corners;
    facet.normal = outward;
    facet.angle = face.angle;
    facet.shade =
        face.shade == kFlat ? kFlat + static_cast<std::uint32_t>(body_.facets.size()) : face.shade;
    for (std::size_t i = 0; i < facet.corners.size(); ++i) {
      const auto ends =
          std::minmax(facet.corners[i], facet.corners[(i + 1) % facet.corners.size()]);
      facet.edges.push_back(edges_.try_emplace(ends, edges_.size()).first->second);
    }
    body_.facets.push_back(std::move(facet));
  }

  Polyhedron body_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> edges_;
};

// Along the axis on what faces up or sideways, up the face on what faces along it.
Vector2d FlatTexture(const Vector3d& p_A, const Vector3d& normal_A) {
  Eigen::Index faces = 0;
  normal_A.cwiseAbs().maxCoeff(&faces);
  if (faces == 0) return {p_A.z(), p_A.y()};
  return {p_A.x(), faces == 1 ? p_A.z() : p_A.y()};
}

VertexLook FlatLook(const SweptAxis& axis, const Vector3d& p, const Facet& facet) {
  const SweepPoint s = ToSweep(axis, p);
  const Eigen::Matrix3d R_WA = AxisPose(axis, s.along_m).linear();
  return {facet.normal,
          FlatTexture({s.along_m, s.left_m, s.up_m}, R_WA.transpose() * facet.normal)};
}

Polyhedron Make(const Block& block, double /*tolerance_m*/, double /*max_cell_m*/) {
  Assembly assembly;
  const auto loop = [&](double z) {
    Loop corners;
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      corners.push_back(assembly.Point(block.X_WB * block.half_m.cwiseProduct(Vector3d(x, y, z))));
    return corners;
  };
  const Loop bottom = loop(-1.0);
  assembly.AddCell(Assembly::Prism(bottom, loop(1.0)));
  Polyhedron body = assembly.Take();
  const SweptAxis axis{block.X_WB, 1.0, 0.0};
  body.look = [axis](const Vector3d& p, const Facet& facet) { return FlatLook(axis, p, facet); };
  return body;
}

// Rings of a ball from its top to its cut: convex, so one cell.
Polyhedron Make(const Ball& ball, double tolerance_m, double /*max_cell_m*/) {
  const std::size_t around = SegmentsAround(ball.radius_m, tolerance_m);
  const double turn = 2.0 * kPi / static_cast<double>(around);
  const double radius = CornerRadius(ball.radius_m, turn);
  const double lowest = std::acos(std::max(-1.0, ball.foot_m / ball.radius_m));
  const auto rings = static_cast<std::size_t>(std::ceil(lowest / turn));
  const Vector3d x = ball.up_W.unitOrthogonal();
  const Vector3d y = ball.up_W.cross(x);
  Assembly assembly;
  std::vector<Loop> loops{{assembly.Point(ball.p_WB + radius * ball.up_W)}};
  for (std::size_t i = 1; i <= rings; ++i) {
    // The last stays off the lowest point: a whole ball ends in a small face, too.
    const double down =
        std::min(lowest * static_cast<double>(i) / static_cast<double>(rings), kPi - 0.5 * turn);
    Loop& loop = loops.emplace_back();
    for (std::size_t j = 0; j < around; ++j) {
      const double angle = static_cast<double>(j) * turn;
      loop.push_back(assembly.Point(ball.p_WB + radius * (std::cos(down) * ball.up_W +
                                                          std::sin(down) * std::cos(angle) * x +
                                                          std::sin(down) * std::sin(angle) * y)));
    }
  }
  std::vector<Assembly::Face> faces;
  for (std::size_t i = 0; i < rings; ++i) {
    for (std::size_t j = 0; j < around; ++j) {
      const std::size_t k = (j + 1) % around;
      Loop corners{loops[i][i == 0 ? 0 : j], loops[i + 1][j], loops[i + 1][k]};
      if (i > 0) corners.push_back(loops[i][k]);
      faces.push_back({corners, false, kInner});
    }
  }
  faces.push_back({Loop(loops.back().rbegin(), loops.back().rend())});
  assembly.AddCell(faces);
  Polyhedron body = assembly.Take();
  body.look = [ball, x, y](const Vector3d& p, const Facet& facet) {
    const Vector3d q = p - ball.p_WB;
    return VertexLook{facet.shade == kInner ? q.normalized() : facet.normal, {q.dot(x), q.dot(y)}};
  };
  return body;
}

// A tube with a thick wall, or a sector of it.
struct Shell {
  SweptAxis axis;
  double inner_radius_m{}, outer_radius_m{};
  double from_rad{}, to_rad{};  // from the crown, clockwise looking along the axis
  std::size_t segments{};
  bool closed{};
};

VertexLook LookOf(const Shell& shell, const Vector3d& p, const Facet& facet) {
  if (facet.shade >= kFlat) return FlatLook(shell.axis, p, facet);
  const SweepPoint s = ToSweep(shell.axis, p);
  const double sign = facet.shade == kInner ? -1.0 : 1.0;
  const Vector3d normal_A = sign * Vector3d(0.0, s.left_m, s.up_m).normalized();
  double angle = std::atan2(-s.left_m, s.up_m);
  angle += 2.0 * kPi * std::round((facet.angle - angle) / (2.0 * kPi));
  const double radius = facet.shade == kInner ? shell.inner_radius_m : shell.outer_radius_m;
  return {AxisPose(shell.axis, s.along_m).linear() * normal_A, {s.along_m, radius * angle}};
}

Polyhedron Make(const Shell& shell, double tolerance_m, double max_cell_m) {
  const double step = (shell.to_rad - shell.from_rad) / static_cast<double>(shell.segments);
  const std::array<double, 2> radii{CornerRadius(shell.inner_radius_m, step),
                                    CornerRadius(shell.outer_radius_m, step)};
  const std::size_t cells = CellsAlong(shell.axis, shell.outer_radius_m, tolerance_m, max_cell_m);
  const std::size_t around = shell.segments + (shell.closed ? 0 : 1);
  Assembly assembly;
  for (std::size_t i = 0; i <= cells; ++i) {
    const Isometry3d X_WA = AxisPose(
        shell.axis, shell.axis.length_m * static_cast<double>(i) / static_cast<double>(cells));
    for (std::size_t j = 0; j < around; ++j) {
      const double angle = shell.from_rad + static_cast<double>(j) * step;
      for (const double radius : radii) {
        (void)assembly.Point(X_WA *
                             Vector3d(0.0, -radius * std::sin(angle), radius * std::cos(angle)));
      }
    }
  }
  const auto point = [&](std::size_t i, std::size_t j, std::size_t outer) {
    return static_cast<std::uint32_t>(2 * (i * around + j % around) + outer);
  };
  for (std::size_t i = 0; i < cells; ++i) {
    for (std::size_t j = 0; j < shell.segments; ++j) {
      const auto loop = [&](std::size_t k) {
        return Loop{point(k, j, 1), point(k, j + 1, 1), point(k, j + 1, 0), point(k, j, 0)};
      };
      std::vector<Assembly::Face> faces = Assembly::Prism(loop(i), loop(i + 1));
      const double middle = shell.from_rad + (static_cast<double>(j) + 0.5) * step;
      for (Assembly::Face& face : faces) face.angle = middle;
      faces[0].shade = kOuter;
      faces[1].internal = shell.closed || j + 1 < shell.segments;
      faces[2].shade = kInner;
      faces[3].internal = shell.closed || j > 0;
      faces[4].internal = i > 0;
      faces[5].internal = i + 1 < cells;
      assembly.AddCell(faces);
    }
  }
  Polyhedron body = assembly.Take();
  body.look = [shell](const Vector3d& p, const Facet& facet) { return LookOf(shell, p, facet); };
  return body;
}

Polyhedron Make(const Ridge& ridge, double tolerance_m, double max_cell_m) {
  Shell shell{ridge.axis, ridge.inner_radius_m, ridge.outer_radius_m, 0.0, 0.0, 0, false};
  shell.closed = ridge.half_arc_rad >= kPi;
  const double half = std::min(ridge.half_arc_rad, kPi);
  shell.from_rad = shell.closed ? 0.0 : ridge.middle_rad - half;
  shell.to_rad = shell.closed ? 2.0 * kPi : ridge.middle_rad + half;
  const double whole = static_cast<double>(SegmentsAround(ridge.inner_radius_m, tolerance_m));
  shell.segments = static_cast<std::size_t>(std::max(1.0, std::ceil(whole * half / kPi - 1e-9)));
  return Make(shell, tolerance_m, max_cell_m);
}

Polyhedron Make(const Stub& stub, double tolerance_m, double max_cell_m) {
  // With the corners of its bore.
  const SweptAxis whole{stub.X_WS, stub.end_m, 0.0};
  return Make(Shell{{AxisPose(whole, stub.start_m), stub.end_m - stub.start_m, 0.0},
                    stub.inner_radius_m,
                    stub.outer_radius_m,
                    0.0,
                    2.0 * kPi,
                    SegmentsAround(stub.inner_radius_m, tolerance_m),
                    true},
              tolerance_m, max_cell_m);
}

// Upper and lower end of a convex outline at a place along it.
std::pair<double, double> HeightsAt(const Bed& bed, double along_m) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t i = 0; i < bed.corners; ++i) {
    const Vector2d& a = bed.outline[i];
    const Vector2d& b = bed.outline[(i + 1) % bed.corners];
    if (along_m < std::min(a.x(), b.x()) || along_m > std::max(a.x(), b.x())) continue;
    for (const double t : {0.0, 1.0}) {
      const double span = b.x() - a.x();
      const double share = std::abs(span) > 1e-9 ? (along_m - a.x()) / span : t;
      const double up = a.y() + std::clamp(share, 0.0, 1.0) * (b.y() - a.y());
      low = std::min(low, up);
      high = std::max(high, up);
    }
  }
  return {low, high};
}

// Upright prisms over triangles: so their tops are flat round a bend too.
Polyhedron Make(const Bed& bed, double tolerance_m, double max_cell_m) {
  std::vector<double> corners;
  for (std::size_t i = 0; i < bed.corners; ++i) corners.push_back(bed.outline[i].x());
  std::sort(corners.begin(), corners.end());
  std::vector<double> stations;
  for (const double x : corners) {
    if (!stations.empty() && x - stations.back() < 1e-6) continue;
    if (!stations.empty()) {
      const double from = stations.back();
      const SweptAxis part{bed.axis.X_WS, x - from, bed.axis.curvature};
      const std::size_t cells = CellsAlong(part, bed.half_width_m, tolerance_m, max_cell_m);
      for (std::size_t k = 1; k < cells; ++k)
        stations.push_back(from + (x - from) * static_cast<double>(k) / static_cast<double>(cells));
    }
    stations.push_back(x);
  }
  Assembly assembly;
  for (const double x : stations) {
    const auto [low, high] = HeightsAt(bed, x);
    for (const double left : {-bed.half_width_m, bed.half_width_m}) {
      (void)assembly.Point(FromSweep(bed.axis, {x, left, low}));
      (void)assembly.Point(FromSweep(bed.axis, {x, left, high}));
    }
  }
  const auto point = [](std::size_t i, std::size_t left, std::size_t top) {
    return static_cast<std::uint32_t>(4 * i + 2 * left + top);
  };
  for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
    const auto right = [&](std::size_t top) {
      return Loop{point(i, 0, top), point(i + 1, 0, top), point(i, 1, top)};
    };
    const auto left = [&](std::size_t top) {
      return Loop{point(i + 1, 1, top), point(i, 1, top), point(i + 1, 0, top)};
    };
    std::vector<Assembly::Face> faces = Assembly::Prism(right(0), right(1));
    faces[1].internal = true;
    faces[2].internal = i > 0;
    assembly.AddCell(faces);
    faces = Assembly::Prism(left(0), left(1));
    faces[1].internal = true;
    faces[2].internal = i + 2 < stations.size();
    assembly.AddCell(faces);
  }
  Polyhedron body = assembly.Take();
  const SweptAxis axis = bed.axis;
  body.look = [axis](const Vector3d& p, const Facet& facet) { return FlatLook(axis, p, facet); };
  return body;
}

}  // namespace

Polyhedron PolyhedronOf(const SolidPrimitive& solid, double tolerance_m, double max_cell_m) {
  Polyhedron body = std::visit(
      [&](const auto& shape) { return Make(shape, tolerance_m, max_cell_m); }, solid.shape);
  body.look = [look = std::move(body.look), start = solid.start_chainage_m](const Vector3d& p,
                                                                            const Facet& facet) {
    VertexLook at = look(p, facet);
    at.surface_m.x() += start;
    return at;
  };
  return body;
}

}  // namespace kantaro::sim
