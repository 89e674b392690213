#include "sim/fault_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using network::FaultCategory;
using network::FaultRank;

constexpr double kTurn = 2.0 * std::numbers::pi;
/// Flat things lie this far off the wall: above the facets of its mesh, yet no thicker than paint
/// to the eye.
constexpr double kPaint_m = 0.0006;
constexpr double kRoughPeriod_m = 0.2;

/// Size by rank, A being 1.
double RankScale(FaultRank rank) {
  switch (rank) {
    case FaultRank::kA:
      return 1.0;
    case FaultRank::kB:
      return 0.6;
    case FaultRank::kC:
      break;
  }
  return 0.3;
}

/// The wall around a place, rolled out: u along the axis, v clockwise around it (looking
/// downstream) [m], and height off the wall towards the axis. Right-handed, so what is
/// counter-clockwise in u, v is seen from inside.
class RolledWall {
 public:
  RolledWall(const network::PipeAxis& axis, double radius_m, double chainage_m, double clock_h)
      : axis_(axis), radius_m_(radius_m), chainage_m_(chainage_m), clock_h_(clock_h) {}

  [[nodiscard]] double radius_m() const { return radius_m_; }
  [[nodiscard]] Vector3d At(const Vector2d& uv_m, double height_m) const {
    const double clock_h = clock_h_ + 12.0 * uv_m.y() / (kTurn * radius_m_);
    return axis_.PoseAt(chainage_m_ + uv_m.x()) *
           ((radius_m_ - height_m) * network::ClockDirection(clock_h));
  }

 private:
  const network::PipeAxis& axis_;
  double radius_m_, chainage_m_, clock_h_;
};

Look RoughLook(const Eigen::Vector3f& colour, float gloss, float relief = 1.0f) {
  return {Pattern::kRough, colour, gloss, relief};
}

const Look kVoidDark = RoughLook({0.03f, 0.025f, 0.02f}, 0.02f, 0.3f);
const Look kDampStain = RoughLook({0.26f, 0.18f, 0.11f}, 0.5f, 0.3f);
const Look kBrokenEdge = RoughLook({0.85f, 0.80f, 0.70f}, 0.1f);
const Look kLime = RoughLook({0.90f, 0.84f, 0.72f}, 0.3f, 0.6f);
const Look kRootBark = RoughLook({0.55f, 0.36f, 0.20f}, 0.15f, 0.6f);
const Look kMortar = RoughLook({0.70f, 0.68f, 0.63f}, 0.05f, 0.45f);
const Look kGrease = RoughLook({0.95f, 0.84f, 0.58f}, 0.6f, 0.2f);
const Look kStone = RoughLook({0.62f, 0.44f, 0.28f}, 0.15f, 0.45f);
const Look kPipeEnd = RoughLook({0.78f, 0.44f, 0.24f}, 0.4f, 0.2f);

/// Collects vertices about the first one.
class MeshBuilder {
 public:
  std::uint32_t Add(const Vector3d& p_W, const Vector2d& texture_m) {
    if (mesh_.positions.empty()) mesh_.p_WO = p_W;
    mesh_.positions.push_back((p_W - mesh_.p_WO).cast<float>());
    mesh_.texture.push_back((texture_m / kRoughPeriod_m).cast<float>());
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }
  void Triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.triangles.push_back({a, b, c});
  }
  /// Corners counter-clockwise.
  void Quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    Triangle(a, b, c);
    Triangle(a, c, d);
  }
  [[nodiscard]] Visual Finish(const Look& look) {
    ComputeNormals(mesh_);
    return {std::move(mesh_), look};
  }

 private:
  VisualMesh mesh_;
};

/// A periodic irregular curve about 0.
class Wobble {
 public:
  Wobble(RandomStream& random, int lowest, int highest) : lowest_(lowest) {
    for (int k = lowest; k <= highest; ++k) {
      waves_.push_back({random.Normal(1.0 / k), random.Uniform(0.0, kTurn)});
    }
  }
  [[nodiscard]] double At(double angle) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      sum += waves_[i].x() * std::sin((lowest_ + static_cast<int>(i)) * angle + waves_[i].y());
    }
    return sum;
  }

 private:
  int lowest_;
  std::vector<Vector2d> waves_;  ///< amplitude, phase
};

/// Irregular relief over the plane, about 0, from waves of every direction.
class Knobs {
 public:
  explicit Knobs(RandomStream& random) {
    for (int i = 0; i < 14; ++i) {
      const double waves = random.Uniform(1.0, 7.0);
      const double direction = random.Uniform(0.0, kTurn);
      waves_.push_back({waves * Vector2d(std::cos(direction), std::sin(direction)),
                        random.Uniform(0.0, kTurn), 0.6 / waves});
    }
  }
  /// @param place in units of the lump's size.
  [[nodiscard]] double At(const Vector2d& place) const {
    double sum = 0.0;
    for (const Wave& wave : waves_)
      sum += wave.height * std::sin(wave.number.dot(place) * 2.0 + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    Vector2d number;
    double phase{}, height{};
  };
  std::vector<Wave> waves_;
};

/// A patch with a ragged outline around the origin. `height` gives its relief from the share of the
/// way out (0 middle … 1 outline) and the place in units of the half size.
Visual Patch(const RolledWall& wall, const Vector2d& half_size_m, double raggedness,
             RandomStream& random, const std::function<double(double, const Vector2d&)>& height,
             const Look& look) {
  constexpr int kRings = 10;
  constexpr std::uint32_t kSectors = 32;
  const Wobble outline(random, 2, 11);
  const Vector2d texture_offset(random.Uniform(0.0, 1.0), random.Uniform(0.0, 1.0));
  MeshBuilder builder;
  builder.Add(wall.At(Vector2d::Zero(), height(0.0, Vector2d::Zero())), texture_offset);
  for (int ring = 1; ring <= kRings; ++ring) {
    const double out = static_cast<double>(ring) / kRings;
    for (std::uint32_t sector = 0; sector < kSectors; ++sector) {
      const double angle = kTurn * sector / kSectors;
      const double reach = out * std::max(0.3, 1.0 + raggedness * outline.At(angle));
      const Vector2d place = reach * Vector2d(std::cos(angle), std::sin(angle));
      const Vector2d uv = half_size_m.cwiseProduct(place);
      // The height stretches the texture too, or it would smear down steep sides.
      const double height_m = height(out, place);
      builder.Add(wall.At(uv, height_m), uv + texture_offset + Vector2d::Constant(height_m));
    }
  }
  const auto at = [](int ring, std::uint32_t sector) {
    return 1 + static_cast<std::uint32_t>(ring - 1) * kSectors + sector % kSectors;
  };
  for (std::uint32_t i = 0; i < kSectors; ++i) {
    builder.Triangle(0, at(1, i), at(1, i + 1));
    for (int ring = 1; ring < kRings; ++ring) {
      builder.Quad(at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1));
    }
  }
  return builder.Finish(look);
}

Visual FlatPatch(const RolledWall& wall, const Vector2d& half_size_m, double raggedness,
                 RandomStream& random, double off_m, const Look& look) {
  return Patch(
      wall, half_size_m, raggedness, random, [off_m](double, const Vector2d&) { return off_m; },
      look);
}

/// A lump: steep at its edge, knobbly on top.
Visual Lump(const RolledWall& wall, const Vector2d& half_size_m, double height_m, double knobs,
            RandomStream& random, const Look& look) {
  const Knobs relief(random);
  const auto height = [&](double out, const Vector2d& place) {
    const double dome = std::sqrt(std::max(0.0, 1.0 - out * out * out));
    // Its rim is sunk, so that no light shows beneath.
    return height_m * dome * std::max(0.2, 1.0 + knobs * relief.At(place)) - 0.001;
  };
  return Patch(wall, half_size_m, 0.25, random, height, look);
}

/// Where a band's two edges run.
struct Station {
  Vector2d right_m, left_m;  ///< of the way along the band, on the rolled wall
};

Visual Band(const RolledWall& wall, const std::vector<Station>& stations, double off_m,
            const Look& look) {
  // A wide band laid straight across a round wall would rise off it in the middle, over what lies
  // on it.
  constexpr double kStrip_m = 0.006;
  double widest_m = 0.0;
  for (const Station& station : stations) {
    widest_m = std::max(widest_m, (station.left_m - station.right_m).norm());
  }
  const auto strips = static_cast<std::uint32_t>(1.0 + widest_m / kStrip_m);
  MeshBuilder builder;
  for (const Station& station : stations) {
    for (std::uint32_t k = 0; k <= strips; ++k) {
      const Vector2d uv = station.right_m + (station.left_m - station.right_m) * k / strips;
      builder.Add(wall.At(uv, off_m), uv);
    }
  }
  for (std::uint32_t i = 0; i + 1 < stations.size(); ++i) {
    for (std::uint32_t k = 0; k < strips; ++k) {
      const std::uint32_t here = i * (strips + 1) + k, next = here + strips + 1;
      builder.Quad(here, next, next + 1, here + 1);
    }
  }
  return builder.Finish(look);
}

/// A jagged line from one place to another, as fracture runs.
std::vector<Vector2d> JaggedLine(const Vector2d& from_m, const Vector2d& to_m, double jag,
                                 RandomStream& random) {
  constexpr double kStep_m = 0.008;
  const Vector2d way = to_m - from_m;
  const int steps = std::max(6, static_cast<int>(std::ceil(way.norm() / kStep_m)));
  const Vector2d aside(-way.y() / way.norm(), way.x() / way.norm());
  std::vector<Vector2d> line;
  double offset_m = 0.0;
  for (int i = 0; i <= steps; ++i) {
    line.push_back(from_m + way * i / steps + offset_m * aside);
    offset_m = 0.85 * offset_m + random.Normal(jag * way.norm() / steps);
  }
  return line;
}

/// A crack's mouth along a line: widest in the middle, closing at both ends (or at the far end
/// alone).
Visual CrackAlong(const RolledWall& wall, const std::vector<Vector2d>& line_m, double width_m,
                  bool open_start, double off_m, RandomStream& random, const Look& look) {
  std::vector<Station> stations;
  for (std::size_t i = 0; i < line_m.size(); ++i) {
    const Vector2d way = line_m[std::min(i + 1, line_m.size() - 1)] - line_m[i == 0 ? 0 : i - 1];
    const Vector2d aside = Vector2d(-way.y(), way.x()).normalized();
    const double share = static_cast<double>(i) / static_cast<double>(line_m.size() - 1);
    const double taper =
        open_start ? 1.0 - share : std::min(1.0, 4.0 * std::min(share, 1.0 - share));
    const double half_m = 0.5 * width_m * taper * random.Uniform(0.65, 1.15) + 1e-4;
    stations.push_back({line_m[i] - half_m * aside, line_m[i] + half_m * aside});
  }
  return Band(wall, stations, off_m, look);
}

std::vector<Visual> Crack(const RolledWall& wall, const network::Fault& fault,
                          RandomStream& random) {
  std::vector<Visual> visuals;
  const double half_m = fault.length_m / 2.0;
  const std::vector<Vector2d> line = JaggedLine({-half_m, 0.0}, {half_m, 0.0}, 0.4, random);
  const double damp_m = RankScale(fault.rank) * 0.012;
  // A wide band folds over itself where the line turns sharply.
  std::vector<Vector2d> smooth = line;
  for (std::size_t i = 2; i + 2 < line.size(); ++i) {
    smooth[i] = (line[i - 2] + line[i - 1] + line[i] + line[i + 1] + line[i + 2]) / 5.0;
  }
  visuals.push_back(
      CrackAlong(wall, smooth, fault.width_m + damp_m, false, 0.7 * kPaint_m, random, kDampStain));
  visuals.push_back(CrackAlong(wall, line, fault.width_m, false, kPaint_m, random, kVoidDark));
  const int branches = static_cast<int>(std::lround(4.0 * RankScale(fault.rank)));
  for (int i = 0; i < branches; ++i) {
    const Vector2d start = line[line.size() / 5 + random.Index(3 * line.size() / 5)];
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const Vector2d way =
        fault.length_m * random.Uniform(0.12, 0.28) *
        Vector2d(random.Uniform(-1.0, 1.0), side * random.Uniform(0.5, 1.0)).normalized();
    visuals.push_back(CrackAlong(wall, JaggedLine(start, start + way, 0.5, random),
                                 0.6 * fault.width_m, true, kPaint_m, random, kVoidDark));
  }
  return visuals;
}

/// Ground water has washed in: a damp stain, and lime where it ran down to the invert.
std::vector<Visual> Infiltration(const RolledWall& wall, const network::Fault& fault,
                                 RandomStream& random) {
  std::vector<Visual> visuals;
  const Vector2d half_m(fault.length_m / 2.0, fault.width_m / 2.0);
  visuals.push_back(FlatPatch(wall, half_m, 0.5, random, 0.7 * kPaint_m, kDampStain));
  // Clockwise is down on the right-hand side, and up on the left.
  const double clock_h = std::fmod(fault.clock_h, 12.0);
  const double down = clock_h < 6.0 ? 1.0 : -1.0;
  const double to_invert_m = std::abs(6.0 - clock_h) / 12.0 * kTurn * wall.radius_m();
  const int runs = 2 + static_cast<int>(std::lround(5.0 * RankScale(fault.rank)));
  for (int i = 0; i < runs; ++i) {
    const Vector2d start(random.Uniform(-0.8, 0.8) * half_m.x(), 0.2 * down * half_m.y());
    const double run_m =
        std::min(to_invert_m, half_m.y() + random.Uniform(0.3, 1.0) * to_invert_m) + 0.01;
    visuals.push_back(CrackAlong(
        wall, JaggedLine(start, start + Vector2d(0.0, down * run_m), 0.15, random),
        random.Uniform(0.003, 0.012), true, kPaint_m, random, i % 3 == 0 ? kDampStain : kLime));
  }
  return visuals;
}

/// One root: a tapering tube that grows inward and hangs.
void AddRoot(MeshBuilder& builder, const RolledWall& wall, const Vector2d& uv_m, double length_m,
             RandomStream& random) {
  constexpr int kSegments = 6;
  constexpr std::uint32_t kSides = 4;
  const Vector3d start = wall.At(uv_m, -0.002);
  const Vector3d inward = (wall.At(uv_m, 0.01) - start).normalized();
  const Vector3d along = (wall.At(uv_m + Vector2d(0.01, 0.0), -0.002) - start).normalized();
  const Vector3d lean =
      Vector3d(random.Normal(0.45), random.Normal(0.45), random.Normal(0.2)) + 0.5 * along;
  const double thickness_m = random.Uniform(0.0007, 0.0022);
  const double curl = random.Uniform(0.0, kTurn);
  std::uint32_t previous = 0;
  for (int i = 0; i <= kSegments; ++i) {
    const double s = static_cast<double>(i) / kSegments;
    const Vector3d middle = start + length_m * (s * (1.0 - 0.35 * s) * inward + s * s * lean * 0.6 -
                                                0.45 * s * s * Vector3d::UnitZ() +
                                                0.07 * s * std::sin(curl + 7.0 * s) * along);
    const double radius_m = thickness_m * (1.0 - 0.85 * s);
    const Vector3d side = inward.cross(along).normalized();
    std::uint32_t first = 0;
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const double angle = kTurn * k / kSides;
      const std::uint32_t vertex =
          builder.Add(middle + radius_m * (std::cos(angle) * along + std::sin(angle) * side),
                      {s * length_m, 0.003 * k});
      if (k == 0) first = vertex;
    }
    for (std::uint32_t k = 0; i > 0 && k < kSides; ++k) {
      const std::uint32_t next = (k + 1) % kSides;
      builder.Quad(previous + k, first + k, first + next, previous + next);
    }
    previous = first;
  }
}

std::vector<Visual> Roots(const RolledWall& wall, const network::Fault& fault,
                          RandomStream& random) {
  const double scale = RankScale(fault.rank);
  const int count = 6 + static_cast<int>(std::lround(30.0 * scale));
  MeshBuilder builder;
  for (int i = 0; i < count; ++i) {
    const Vector2d uv(random.Normal(0.2) * fault.length_m,
                      random.Uniform(-0.5, 0.5) * fault.width_m);
    AddRoot(builder, wall, uv, scale * wall.radius_m() * random.Uniform(0.35, 0.95), random);
  }
  return {builder.Finish(kRootBark)};
}

/// A hole with pale broken edges and cracks running from it.
std::vector<Visual> Break(const RolledWall& wall, const network::Fault& fault,
                          RandomStream& random) {
  std::vector<Visual> visuals;
  const Vector2d half_m(fault.length_m / 2.0, fault.width_m / 2.0);
  RandomStream same = random;  // one outline, drawn twice
  visuals.push_back(
      FlatPatch(wall, half_m.array() + 0.004, 0.5, same, 0.7 * kPaint_m, kBrokenEdge));
  visuals.push_back(FlatPatch(wall, half_m, 0.5, random, kPaint_m, kVoidDark));
  const int cracks = 2 + static_cast<int>(std::lround(4.0 * RankScale(fault.rank)));
  for (int i = 0; i < cracks; ++i) {
    const double angle = kTurn * (i + random.Uniform(0.0, 0.8)) / cracks;
    const Vector2d out(std::cos(angle), std::sin(angle));
    const Vector2d start = 0.6 * half_m.cwiseProduct(out);
    visuals.push_back(CrackAlong(
        wall,
        JaggedLine(start, start + half_m.maxCoeff() * random.Uniform(0.7, 1.6) * out, 0.4, random),
        0.006, true, kPaint_m, random, kVoidDark));
  }
  return visuals;
}

/// A joint that stands open over part of the round.
std::vector<Visual> OpenJoint(const RolledWall& wall, const network::Fault& fault,
                              RandomStream& random) {
  const auto band = [&](double extra_m, double off_m, const Look& look) {
    constexpr int kSteps = 30;
    std::vector<Station> stations;
    for (int i = 0; i <= kSteps; ++i) {
      const double share = static_cast<double>(i) / kSteps;
      const double half_m =
          (0.5 * fault.length_m + extra_m) * std::sqrt(std::sin(std::numbers::pi * share)) + 1e-4;
      const double v = (share - 0.5) * (fault.width_m + 2.0 * extra_m);
      stations.push_back(
          {{half_m * random.Uniform(0.85, 1.1), v}, {-half_m * random.Uniform(0.85, 1.1), v}});
    }
    return Band(wall, stations, off_m, look);
  };
  return {band(0.004, 0.7 * kPaint_m, kDampStain), band(0.0, kPaint_m, kVoidDark)};
}

/// The end of a house connection that was pushed in too far.
std::vector<Visual> ProjectingPipe(const RolledWall& wall, const network::Fault& fault) {
  constexpr std::uint32_t kSides = 32;
  constexpr double kWall_m = 0.004;
  const double outer_m = std::min(fault.length_m, fault.width_m) / 2.0;
  const double height_m = 0.45 * RankScale(fault.rank) * wall.radius_m();
  const Vector3d foot = wall.At(Vector2d::Zero(), 0.0);
  const Vector3d inward = (wall.At(Vector2d::Zero(), 0.01) - foot).normalized();
  const Vector3d along = (wall.At({0.01, 0.0}, 0.0) - wall.At({-0.01, 0.0}, 0.0)).normalized();
  const Vector3d around = inward.cross(along);
  const auto ring = [&](MeshBuilder& builder, double radius_m, double up_m) {
    std::uint32_t first = 0;
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const double angle = kTurn * k / kSides;
      const std::uint32_t vertex = builder.Add(
          foot + up_m * inward + radius_m * (std::cos(angle) * along + std::sin(angle) * around),
          {angle * radius_m, up_m});
      if (k == 0) first = vertex;
    }
    return first;
  };
  /// A belt from one ring to the next, seen from outside when the second is farther up or inward.
  const auto belt = [&](double r0_m, double up0_m, double r1_m, double up1_m, const Look& look) {
    MeshBuilder builder;
    const std::uint32_t a = ring(builder, r0_m, up0_m), b = ring(builder, r1_m, up1_m);
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t next = (k + 1) % kSides;
      builder.Quad(a + k, a + next, b + next, b + k);
    }
    return builder.Finish(look);
  };
  const double sunk_m = -0.5 * outer_m;  // the main's wall falls away beside its foot
  return {belt(outer_m, sunk_m, outer_m, height_m, kPipeEnd),
          belt(outer_m, height_m, outer_m - kWall_m, height_m, kBrokenEdge),
          belt(outer_m - kWall_m, height_m, outer_m - kWall_m, 0.002, kDampStain),
          belt(outer_m - kWall_m, 0.002, 0.0005, 0.002, kVoidDark)};
}

}  // namespace

std::vector<Visual> BuildFault(const network::PipeAxis& axis, double pipe_radius_m,
                               const network::Fault& fault, RandomStream& random) {
  const RolledWall wall(axis, pipe_radius_m, fault.chainage_m, fault.clock_h);
  const Vector2d half_m(fault.length_m / 2.0, fault.width_m / 2.0);
  const double scale = RankScale(fault.rank);
  switch (fault.category) {
    case FaultCategory::kCrack:
      return Crack(wall, fault, random);
    case FaultCategory::kWaterInfiltration:
      return Infiltration(wall, fault, random);
    case FaultCategory::kRootInvasion:
      return Roots(wall, fault, random);
    case FaultCategory::kPipeBreak:
      return Break(wall, fault, random);
    case FaultCategory::kJointAndGap:
      return OpenJoint(wall, fault, random);
    case FaultCategory::kMountingPipeProjection:
      return ProjectingPipe(wall, fault);
    case FaultCategory::kAdhesionOfMortar:
      return {Lump(wall, half_m, 0.18 * scale * pipe_radius_m, 0.5, random, kMortar)};
    case FaultCategory::kForeignSubstance:
      return {Lump(wall, half_m, std::min(half_m.minCoeff() * 1.3, 0.5 * pipe_radius_m), 0.35,
                   random, kStone)};
    case FaultCategory::kAdhesionOfGrease:
      return {FlatPatch(wall, 1.15 * half_m, 0.15, random, 0.7 * kPaint_m, kDampStain),
              Lump(wall, half_m, 0.10 * scale * pipe_radius_m, 0.7, random, kGrease)};
  }
  return {};
}

std::vector<Visual> BuildJointRims(const network::PipeAxis& axis, double pipe_radius_m,
                                   const network::Joint& joint, RandomStream& random,
                                   const Look& look,
                                   const std::function<bool(const Vector3d&)>& in_groove) {
  constexpr int kSteps = 96;
  constexpr double kLook_m = 0.0002, kStep_m = 0.0005, kFurthest_m = 0.05;
  const RolledWall wall(axis, pipe_radius_m, joint.chainage_m, 12.0);
  std::vector<Visual> rims;
  for (const double side : {-1.0, 1.0}) {
    const Wobble edge(random, 1, 24);
    std::vector<Station> stations;
    for (int i = 0; i <= kSteps; ++i) {
      const double angle = kTurn * i / kSteps;
      const double v = angle * pipe_radius_m;
      double inner_m = side * joint.gap_m / 2.0;
      while (std::abs(inner_m) < joint.gap_m / 2.0 + kFurthest_m &&
             in_groove(wall.At({inner_m + side * kLook_m, v}, -kLook_m)))
        inner_m += side * kStep_m;
      const double outer_m = inner_m + side * std::max(0.001, 0.004 + 0.0026 * edge.At(angle));
      stations.push_back({{std::max(inner_m, outer_m), v}, {std::min(inner_m, outer_m), v}});
    }
    rims.push_back(Band(wall, stations, kPaint_m, look));
  }
  return rims;
}

}  // namespace kantaro::sim
