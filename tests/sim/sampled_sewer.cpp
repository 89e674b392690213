#include "sampled_sewer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kCell_m = 0.02;

/// A place along, left of and above a line that is straight or turns left with its curvature.
Vector3d OnLine(const SweptAxis& axis, double along, double left, double up) {
  const double k = axis.curvature;
  if (k == 0.0) return axis.X_WS * Vector3d(along, left, up);
  const double r = 1.0 / k - left;
  return axis.X_WS * Vector3d(r * std::sin(along * k), 1.0 / k - r * std::cos(along * k), up);
}

/// And back: along, left, up.
Vector3d InLine(const SweptAxis& axis, const Vector3d& p_W) {
  const Vector3d q = axis.X_WS.inverse() * p_W;
  const double k = axis.curvature;
  if (k == 0.0) return q;
  const Vector2d from_middle(q.x(), q.y() - 1.0 / k);
  const double s = k > 0.0 ? 1.0 : -1.0;
  double angle = std::atan2(s * from_middle.x(), -s * from_middle.y());
  const double middle = 0.5 * axis.length_m * k;
  angle = middle + std::remainder(angle - middle, 2.0 * kPi);
  return {angle / k, 1.0 / k - s * from_middle.norm(), q.z()};
}

bool InVoid(const VoidPrimitive& v, const Vector3d& p_W, double deep) {
  const Vector3d q = InLine(v, p_W);
  if (q.x() <= deep || q.x() >= v.length_m - deep) return false;
  if (v.profile == Profile::kRound || q.z() <= 0.0) {
    if (q.tail<2>().norm() >= v.radius_m - deep) return false;
  } else if (std::abs(q.y()) >= v.radius_m - deep) {
    return false;
  }
  return v.profile == Profile::kRound || q.z() < v.wall_height_m - deep;
}

struct IsIn {
  const Vector3d& p;
  bool operator()(const Bed& bed) const {
    const Vector3d q = InLine(bed.axis, p);
    for (std::size_t i = 0; i < bed.corners; ++i) {
      const Vector2d a = bed.outline[i], b = bed.outline[(i + 1) % bed.corners];
      if ((b.x() - a.x()) * (q.z() - a.y()) < (b.y() - a.y()) * (q.x() - a.x())) return false;
    }
    return std::abs(q.y()) <= bed.half_width_m;
  }
  bool operator()(const Ball& ball) const {
    return (p - ball.p_WB).norm() <= ball.radius_m && (p - ball.p_WB).dot(ball.up_W) >= ball.foot_m;
  }
  bool operator()(const Ridge& ridge) const {
    const Vector3d q = InLine(ridge.axis, p);
    const double off = q.tail<2>().norm();
    const Vector2d middle(-std::sin(ridge.middle_rad), std::cos(ridge.middle_rad));
    return q.x() >= 0.0 && q.x() <= ridge.axis.length_m && off >= ridge.inner_radius_m &&
           off <= ridge.outer_radius_m &&
           (ridge.half_arc_rad >= kPi ||
            std::acos(std::clamp(q.tail<2>().dot(middle) / off, -1.0, 1.0)) <= ridge.half_arc_rad);
  }
  bool operator()(const Block& block) const {
    return ((block.X_WB.inverse() * p).cwiseAbs() - block.half_m).maxCoeff() <= 0.0;
  }
  bool operator()(const Stub& stub) const {
    const Vector3d q = stub.X_WS.inverse() * p;
    const double off = q.tail<2>().norm();
    return q.x() >= stub.start_m && q.x() <= stub.end_m && off >= stub.inner_radius_m &&
           off <= stub.outer_radius_m;
  }
};

/// What there is to a shape: faces with the ranges of their two parameters, and points on them.
struct Face {
  int number;
  double u0, u1, v0, v1;
};

/// A face that closes round an axis overlaps itself by so much: what is nearest to a point is
/// looked for around the nearest sample, and not beyond the face's ends.
constexpr double kSeam_rad = 0.1;
constexpr double kAround_rad = 2 * kPi + kSeam_rad;

std::vector<Face> FacesOf(const VoidPrimitive& v) {
  const double r = v.radius_m, l = v.length_m;
  std::vector<Face> faces{{0, 0, l, 0, kAround_rad * r}, {1, -r, r, -r, r}, {2, -r, r, -r, r}};
  if (v.profile == Profile::kU) {
    const double top = v.wall_height_m;
    faces[0] = {0, 0, l, kPi * r, 2 * kPi * r};  // the lower half
    faces[1] = {1, -r, r, -r, std::max(top, 0.0)};
    faces[2] = {2, -r, r, -r, std::max(top, 0.0)};
    if (top > 0.0) {
      faces.push_back({3, 0, l, 0, top});
      faces.push_back({4, 0, l, 0, top});
    }
    faces.push_back({5, 0, l, -r, r});
  }
  return faces;
}

Vector3d PointOn(const VoidPrimitive& v, int face, double a, double b) {
  const double r = v.radius_m;
  switch (face) {
    case 0:
      return OnLine(v, a, r * std::cos(b / r), r * std::sin(b / r));
    case 1:
      return OnLine(v, 0.0, a, b);
    case 2:
      return OnLine(v, v.length_m, a, b);
    case 3:
    case 4:
      return OnLine(v, a, face == 3 ? r : -r, b);
    default:
      return OnLine(v, a, b, v.wall_height_m);
  }
}

/// A void's faces bound it only where its others do not cut them off.
bool Bounds(const VoidPrimitive& v, const Vector3d& p_W) {
  const Vector3d q = InLine(v, p_W);
  constexpr double kHair = 1e-9;
  if (q.x() < -kHair || q.x() > v.length_m + kHair) return false;
  const double off = v.profile == Profile::kU && q.z() > 0.0 ? std::abs(q.y()) : q.tail<2>().norm();
  return off <= v.radius_m + kHair &&
         (v.profile == Profile::kRound || q.z() <= v.wall_height_m + kHair);
}

struct Faces {
  std::vector<Face> operator()(const Bed& bed) const {
    std::vector<Face> faces;
    const double w = bed.half_width_m;
    for (std::size_t i = 0; i < bed.corners; ++i) {
      const double edge = (bed.outline[(i + 1) % bed.corners] - bed.outline[i]).norm();
      faces.push_back({static_cast<int>(i), 0, edge, -w, w});
    }
    return faces;
  }
  std::vector<Face> operator()(const Ball& ball) const {
    const double r = ball.radius_m, foot = std::max(-r, ball.foot_m);
    return {{0, 0, r * std::acos(foot / r), 0, kAround_rad * r},
            {1, 0, std::sqrt(r * r - foot * foot), 0, kAround_rad * r}};
  }
  std::vector<Face> operator()(const Ridge& ridge) const {
    const double ri = ridge.inner_radius_m, ro = ridge.outer_radius_m, l = ridge.axis.length_m;
    const bool full = ridge.half_arc_rad >= kPi;
    const double a = full ? kPi + kSeam_rad : ridge.half_arc_rad;
    std::vector<Face> faces{{0, 0, l, -a * ri, a * ri},
                            {1, ri, ro, -a * ro, a * ro},
                            {2, ri, ro, -a * ro, a * ro},
                            {5, 0, l, -a * ro, a * ro}};  // seen where an inlet enters beside it
    if (!full) {
      faces.push_back({3, 0, l, ri, ro});
      faces.push_back({4, 0, l, ri, ro});
    }
    return faces;
  }
  std::vector<Face> operator()(const Block& block) const {
    std::vector<Face> faces;
    for (int i = 0; i < 6; ++i) {
      const double u = block.half_m[(i / 2 + 1) % 3], v = block.half_m[(i / 2 + 2) % 3];
      faces.push_back({i, -u, u, -v, v});
    }
    return faces;
  }
  std::vector<Face> operator()(const Stub& stub) const {
    const double ri = stub.inner_radius_m, ro = stub.outer_radius_m;
    return {{0, stub.start_m, stub.end_m, 0, kAround_rad * ri},
            {1, stub.start_m, stub.end_m, 0, kAround_rad * ro},
            {2, ri, ro, 0, kAround_rad * ro}};
  }
};

struct SurfacePoint {
  int face;
  double u, v;
  Vector3d operator()(const Bed& bed) const {
    const auto i = static_cast<std::size_t>(face);
    const Vector2d a = bed.outline[i];
    const Vector2d edge = bed.outline[(i + 1) % bed.corners] - a;
    const Vector2d p = a + u * edge.normalized();
    return OnLine(bed.axis, p.x(), v, p.y());
  }
  Vector3d operator()(const Ball& ball) const {
    const double down = u / ball.radius_m, angle = v / ball.radius_m;
    const Vector3d x = ball.up_W.unitOrthogonal();
    if (face == 1)
      return ball.p_WB + ball.foot_m * ball.up_W +
             u * (std::cos(angle) * x + std::sin(angle) * ball.up_W.cross(x));
    return ball.p_WB + ball.radius_m * (std::cos(down) * ball.up_W +
                                        std::sin(down) * (std::cos(angle) * x +
                                                          std::sin(angle) * ball.up_W.cross(x)));
  }
  Vector3d operator()(const Ridge& ridge) const {
    const auto at = [&](double along, double radius, double angle) {
      const double a = ridge.middle_rad + angle;
      return OnLine(ridge.axis, along, -radius * std::sin(a), radius * std::cos(a));
    };
    const double l = ridge.axis.length_m;
    if (face == 0) return at(u, ridge.inner_radius_m, v / ridge.inner_radius_m);
    if (face <= 2) return at(face == 1 ? 0.0 : l, u, v / ridge.outer_radius_m);
    if (face == 5) return at(u, ridge.outer_radius_m, v / ridge.outer_radius_m);
    return at(u, v, face == 3 ? -ridge.half_arc_rad : ridge.half_arc_rad);
  }
  Vector3d operator()(const Block& block) const {
    Vector3d q = Vector3d::Zero();
    const int axis = face / 2;
    q[axis] = face % 2 == 0 ? -block.half_m[axis] : block.half_m[axis];
    q[(axis + 1) % 3] = u;
    q[(axis + 2) % 3] = v;
    return block.X_WB * q;
  }
  Vector3d operator()(const Stub& stub) const {
    const auto at = [&](double along, double radius, double angle) {
      return Vector3d(stub.X_WS *
                      Vector3d(along, radius * std::cos(angle), radius * std::sin(angle)));
    };
    if (face == 0) return at(u, stub.inner_radius_m, v / stub.inner_radius_m);
    if (face == 1) return at(u, stub.outer_radius_m, v / stub.outer_radius_m);
    return at(stub.start_m, u, v / stub.outer_radius_m);
  }
};

std::uint64_t Key(const Vector3d& q, int dx = 0, int dy = 0, int dz = 0) {
  const auto part = [](double value, int step) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / kCell_m)) +
                                      step + (1 << 20));
  };
  return part(q.x(), dx) << 42 | part(q.y(), dy) << 21 | part(q.z(), dz);
}

}  // namespace

SampledSewer::SampledSewer(const Sewer& sewer, double spacing_m)
    : sewer_(sewer), spacing_m_(spacing_m), origin_(sewer.network.manholes[0].p_WM) {
  for (const VoidPrimitive& v : sewer.voids) boxes_.push_back(BoundingBox(v));
  for (std::uint32_t i = 0; i < sewer.voids.size() + sewer.solids.size(); ++i) AddPatches(i);
  for (std::uint32_t i = 0; i < patches_.size(); ++i) {
    const Patch& patch = patches_[i];
    const auto count = [&](const double(&range)[2]) {
      return std::max(1, static_cast<int>(std::ceil((range[1] - range[0]) / spacing_m)));
    };
    const int nu = count(patch.u_m), nv = count(patch.v_m);
    for (int a = 0; a <= nu; ++a) {
      for (int b = 0; b <= nv; ++b) {
        const double u = patch.u_m[0] + (patch.u_m[1] - patch.u_m[0]) * a / nu;
        const double v = patch.v_m[0] + (patch.v_m[1] - patch.v_m[0]) * b / nv;
        const auto p = GroundAt(patch, u, v);
        if (!p) continue;
        cells_[Key(*p - origin_)].push_back(static_cast<std::uint32_t>(samples_.size()));
        samples_.push_back(
            {i, static_cast<float>(u), static_cast<float>(v), (*p - origin_).cast<float>()});
      }
    }
  }
}

void SampledSewer::AddPatches(std::uint32_t primitive) {
  const auto faces =
      primitive < sewer_.voids.size()
          ? FacesOf(sewer_.voids[primitive])
          : std::visit(Faces{}, sewer_.solids[primitive - sewer_.voids.size()].shape);
  for (const Face& face : faces)
    patches_.push_back({primitive, face.number, {face.u0, face.u1}, {face.v0, face.v1}});
}

Vector3d SampledSewer::PointOn(const Patch& patch, double u, double v) const {
  if (patch.primitive < sewer_.voids.size())
    return kantaro::sim::PointOn(sewer_.voids[patch.primitive], patch.face, u, v);
  return std::visit(SurfacePoint{patch.face, u, v},
                    sewer_.solids[patch.primitive - sewer_.voids.size()].shape);
}

std::optional<Vector3d> SampledSewer::GroundAt(const Patch& patch, double u, double v) const {
  if (u < patch.u_m[0] || u > patch.u_m[1] || v < patch.v_m[0] || v > patch.v_m[1]) return {};
  const Vector3d p = PointOn(patch, u, v);
  if (patch.primitive >= sewer_.voids.size()) return p;  // all of a solid is ground
  if (!Bounds(sewer_.voids[patch.primitive], p)) return {};
  for (std::uint32_t i = 0; i < sewer_.voids.size(); ++i) {
    if (i != patch.primitive && boxes_[i].contains(p) && InVoid(sewer_.voids[i], p, 1e-7))
      return {};
  }
  return p;
}

bool SampledSewer::IsFree(const Vector3d& p_W) const {
  bool open = false;
  for (std::size_t i = 0; i < sewer_.voids.size() && !open; ++i)
    open = boxes_[i].contains(p_W) && InVoid(sewer_.voids[i], p_W, 0.0);
  return open &&
         std::none_of(sewer_.solids.begin(), sewer_.solids.end(), [&](const SolidPrimitive& solid) {
           return std::visit(IsIn{p_W}, solid.shape);
         });
}

Vector3d SampledSewer::Sample(std::size_t index) const {
  return origin_ + samples_[index].p.cast<double>();
}

std::vector<std::uint32_t> SampledSewer::Near(const Vector3d& p_W, double reach_m) const {
  // The nearest of each patch, ordered by distance; shell by shell of cells.
  std::vector<std::pair<double, std::uint32_t>> nearest;
  const Vector3d q = p_W - origin_;
  const int shells = static_cast<int>(std::ceil(reach_m / kCell_m));
  double best = reach_m;
  for (int shell = 0; shell <= shells && (shell - 1) * kCell_m < best + 2.0 * spacing_m_; ++shell) {
    for (int x = -shell; x <= shell; ++x) {
      for (int y = -shell; y <= shell; ++y) {
        const bool rim = std::max(std::abs(x), std::abs(y)) == shell;
        for (int z = -shell; z <= shell; z += rim || shell == 0 ? 1 : 2 * shell) {
          const auto cell = cells_.find(Key(q, x, y, z));
          if (cell == cells_.end()) continue;
          for (const std::uint32_t i : cell->second) {
            const double distance = (samples_[i].p.cast<double>() - q).norm();
            if (distance > best + 2.0 * spacing_m_) continue;
            best = std::min(best, distance);
            const auto same = std::find_if(nearest.begin(), nearest.end(), [&](const auto& entry) {
              return samples_[entry.second].patch == samples_[i].patch;
            });
            if (same == nearest.end()) {
              nearest.emplace_back(distance, i);
            } else if (distance < same->first) {
              *same = {distance, i};
            }
          }
        }
      }
    }
  }
  std::sort(nearest.begin(), nearest.end());
  std::vector<std::uint32_t> indices;
  for (const auto& [distance, i] : nearest) {
    if (distance <= best + 2.0 * spacing_m_) indices.push_back(i);
  }
  return indices;
}

double SampledSewer::Roughly(const Vector3d& p_W, double reach_m) const {
  double best = reach_m;
  for (const std::uint32_t i : Near(p_W, reach_m)) best = std::min(best, (Sample(i) - p_W).norm());
  return best;
}

double SampledSewer::Distance(const Vector3d& p_W, double reach_m) const {
  double best = reach_m;
  for (const std::uint32_t i : Near(p_W, reach_m)) {
    const Patch& patch = patches_[samples_[i].patch];
    double u = samples_[i].u, v = samples_[i].v;
    double here = (Sample(i) - p_W).norm();
    // Sixteen ways at each size of step: where the ground ends askew, one of them runs along it.
    for (double step = spacing_m_; step > 2e-5;) {
      bool nearer = false;
      for (int k = 0; k < 16; ++k) {
        const double angle = k * kPi / 8.0;
        const auto p = GroundAt(patch, u + step * std::cos(angle), v + step * std::sin(angle));
        if (!p || (*p - p_W).norm() >= here - 1e-9) continue;
        here = (*p - p_W).norm();
        u += step * std::cos(angle);
        v += step * std::sin(angle);
        nearer = true;
        break;
      }
      if (!nearer) step *= 0.5;
    }
    best = std::min(best, here);
  }
  return best;
}

}  // namespace kantaro::sim
