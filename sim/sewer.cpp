#include "sim/sewer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "network/topology.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using network::Manhole;
using network::Network;
using network::Pipe;
using network::PipeAxis;

/// Voids that follow each other overlap by this much, so that no wall closes between them.
constexpr double kOverlap_m = 0.002;
/// Default centre-line radius of a curved channel, in shaft radii: measured to turn the robot wet
/// and dry.
constexpr double kChannelRadiusRatio = 0.66;
/// A channel's centre line turns no tighter than this, in channel radii.
constexpr double kTightestChannel = 1.02;
/// Below this turn a channel is straight.
constexpr double kStraight_rad = 1.0 * std::numbers::pi / 180.0;
/// Stretches shorter than this are rounding.
constexpr double kSliver_m = 1e-9;
/// How far solids reach into the wall behind them.
constexpr double kRoot_m = 0.05;
/// How far a house connection is modelled beyond the pipe's wall.
constexpr double kInletLength_m = 0.6;

/// Upright frame with x along a horizontal direction.
Eigen::Isometry3d Level(const Vector3d& p_W, const Vector2d& forward) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear().col(0) = Vector3d(forward.x(), forward.y(), 0.0);
  X.linear().col(1) = Vector3d(-forward.y(), forward.x(), 0.0);
  X.translation() = p_W;
  return X;
}

/// Where a manhole's channels and shaft meet.
struct Chamber {
  double shaft_radius_m{};
  double channel_radius_m{};  ///< half the width of its channels: the largest pipe's
  double bench_m{};           ///< bench above the invert
};

double BenchOf(const Manhole& manhole, double channel_radius_m) {
  switch (manhole.bench_height) {
    case network::BenchHeight::kFlat:
      return 0.0;
    case network::BenchHeight::kAxis:
      return channel_radius_m;
    case network::BenchHeight::kCrown:
      return 2.0 * channel_radius_m;
    case network::BenchHeight::kGiven:
      break;
  }
  return manhole.given_bench_m;
}

Chamber ChamberOf(const Network& network, const Manhole& manhole) {
  Chamber chamber;
  for (const std::size_t i : network.PipesAt(manhole.name)) {
    chamber.channel_radius_m =
        std::max(chamber.channel_radius_m, network.pipes[i].DiameterIn(manhole.name) / 2.0);
  }
  chamber.shaft_radius_m = network.ShaftDiameter(manhole) / 2.0;
  if (chamber.shaft_radius_m < chamber.channel_radius_m + network::kLeastBenching_m / 2 - 1e-9) {
    throw std::invalid_argument(
        fmt::format("manhole \"{}\": its shaft of {:.0f} mm is too narrow for its pipes",
                    manhole.name, chamber.shaft_radius_m * 2000.0));
  }
  chamber.bench_m = BenchOf(manhole, chamber.channel_radius_m);
  return chamber;
}

/// A stretch of a pipe's line on one piece of its axis and of one diameter.
struct Stretch {
  network::AxisPiece piece;
  double start_m{}, end_m{};  ///< chainage
  double radius_m{};          ///< of the pipe

  [[nodiscard]] SweptAxis Axis(double from_m, double to_m) const {
    const SweptAxis whole{piece.X_WS, piece.length_m, piece.curvature};
    return {AxisPose(whole, from_m - piece.start_m), to_m - from_m, piece.curvature};
  }
  [[nodiscard]] Vector3d Direction(double chainage_m) const {
    return Axis(chainage_m, chainage_m).X_WS.linear().col(0);
  }
};

/// The stretches between two chainages, in order. The first and last piece go on beyond their ends.
std::vector<Stretch> Stretches(const PipeAxis& axis, const Pipe& pipe, double from_m, double to_m) {
  std::vector<Stretch> stretches;
  const auto& pieces = axis.pieces();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    double start = i == 0 ? from_m : std::max(from_m, pieces[i].start_m);
    const double end =
        i + 1 == pieces.size() ? to_m : std::min(to_m, pieces[i].start_m + pieces[i].length_m);
    const auto add = [&](double until) {
      if (until - start > kSliver_m)
        stretches.push_back(
            {pieces[i], start, until, pipe.DiameterAt(0.5 * (start + until)) / 2.0});
      start = std::max(start, until);
    };
    for (const network::DiameterChange& change : pipe.diameter_changes)
      add(std::min(end, change.chainage_m));
    add(end);
  }
  return stretches;
}

/// How far two stretches must reach into each other, so that no wedge of wall is left between their
/// square ends.
double OverlapOf(const Stretch& before, const Stretch& after, double radius_m) {
  const double sine = before.Direction(before.end_m).cross(after.Direction(after.start_m)).norm();
  return kOverlap_m + radius_m * std::tan(0.5 * std::asin(std::min(sine, 1.0)));
}

/// No wider than the bend's inside allows.
double WithinBend(const SweptAxis& axis, double radius_m) {
  return std::min(radius_m, 0.98 / std::max(std::abs(axis.curvature), 1e-9));
}

/// What of a convex outline lies where normal · p <= limit.
std::vector<Vector2d> Clipped(const std::vector<Vector2d>& outline, const Vector2d& normal,
                              double limit) {
  std::vector<Vector2d> kept;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& p = outline[i];
    const Vector2d& q = outline[(i + 1) % outline.size()];
    const double at_p = normal.dot(p) - limit;
    const double at_q = normal.dot(q) - limit;
    if (at_p <= 0.0) kept.push_back(p);
    if (at_p * at_q < 0.0) kept.push_back(p + (q - p) * (at_p / (at_p - at_q)));
  }
  return kept;
}

/// A bed of sediment whose ends run out on the invert `from` and `to` along the axis.
Bed BedOn(const SweptAxis& axis, double radius_m, double height_m, double from_m, double to_m) {
  const double top = height_m - radius_m;
  const double floor = -radius_m - kRoot_m;
  std::vector<Vector2d> outline{
      {0.0, floor}, {axis.length_m, floor}, {axis.length_m, top}, {0.0, top}};
  outline = Clipped(outline, {-kReposeSlope, 1.0}, -radius_m - kReposeSlope * from_m);
  outline = Clipped(outline, {kReposeSlope, 1.0}, -radius_m + kReposeSlope * to_m);
  Bed bed;
  bed.axis = axis;
  bed.corners = outline.size();
  std::copy(outline.begin(), outline.end(), bed.outline.begin());
  const double above = std::min(0.0, top);
  bed.half_width_m =
      WithinBend(axis, std::sqrt(radius_m * radius_m - above * above) + 0.4 * kRoot_m);
  return bed;
}

class Builder {
 public:
  explicit Builder(const Network& network) { sewer_.network = network; }

  Sewer Build() {
    for (const Pipe& pipe : sewer_.network.pipes) sewer_.axes.emplace_back(sewer_.network, pipe);
    for (std::size_t i = 0; i < sewer_.network.pipes.size(); ++i) AddPipe(i);
    for (std::size_t i = 0; i < sewer_.network.manholes.size(); ++i) AddManhole(i);
    return std::move(sewer_);
  }

 private:
  void StartPart(Part part) { sewer_.parts.push_back(part); }

  VoidPrimitive& Add(VoidPrimitive primitive) {
    primitive.part = static_cast<std::uint32_t>(sewer_.parts.size() - 1);
    sewer_.voids.push_back(primitive);
    return sewer_.voids.back();
  }

  /// Adds the tube between two chainages, one primitive for each stretch it runs through.
  /// @param depth_m  how much deeper than the pipe's wall it is
  void AddTube(std::size_t pipe, double from_m, double to_m, double depth_m, Feature straight,
               Feature bent) {
    const std::vector<Stretch> stretches =
        Stretches(sewer_.axes[pipe], sewer_.network.pipes[pipe], from_m, to_m);
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const Stretch& stretch = stretches[i];
      const double radius = WithinBend(stretch.Axis(0.0, 0.0), stretch.radius_m + depth_m);
      double start = stretch.start_m;
      double end = stretch.end_m;
      // Over seams they reach into each other; at a step only the narrow one into the wide one.
      if (i > 0 && stretch.radius_m <= stretches[i - 1].radius_m)
        start -= OverlapOf(stretches[i - 1], stretch, radius);
      if (i + 1 < stretches.size() && stretch.radius_m <= stretches[i + 1].radius_m)
        end += OverlapOf(stretch, stretches[i + 1], radius);
      VoidPrimitive tube;
      static_cast<SweptAxis&>(tube) = stretch.Axis(start, end);
      tube.radius_m = radius;
      tube.feature = tube.curvature == 0.0 ? straight : bent;
      tube.start_chainage_m = start;
      Add(tube);
    }
  }

  void AddPipe(std::size_t index) {
    const Pipe& pipe = sewer_.network.pipes[index];
    const double length = sewer_.axes[index].length_m();
    StartPart({Part::Kind::kPipe, index});

    // Channels end at the shaft's wall, where the pipe begins.
    double start = -kOverlap_m;
    for (const network::Joint& joint : pipe.joints) {
      const double gap_start = joint.chainage_m - joint.gap_m / 2.0;
      const double gap_end = joint.chainage_m + joint.gap_m / 2.0;
      AddTube(index, start, gap_start, 0.0, Feature::kStraight, Feature::kBend);
      constexpr double kLip =
          1e-4;  // the groove cuts a hair into both lengths, so that the three are one void
      AddTube(index, gap_start - kLip, gap_end + kLip, joint.depth_m, Feature::kJoint,
              Feature::kJoint);
      start = gap_end;
    }
    AddTube(index, start, length + kOverlap_m, 0.0, Feature::kStraight, Feature::kBend);
    AddMouth(index, 0.0, -1.0, pipe.upstream, pipe.upstream_offset_m);
    AddMouth(index, length, 1.0, pipe.downstream, pipe.downstream_offset_m);
    for (std::uint32_t i = 0; i < pipe.inlets.size(); ++i) AddInlet(index, i);
    for (std::uint32_t i = 0; i < pipe.obstacles.size(); ++i) AddObstacle(index, i);
  }

  /// Opens the wall between the flat end of a pipe and its round shaft; below the benching the
  /// channel does. Where the pipe falls towards the shaft, the opening is raised by as much, lest
  /// it cut into the floor.
  void AddMouth(std::size_t index, double chainage_m, double outward, const std::string& name,
                double offset_m) {
    const Manhole& manhole = sewer_.network.ManholeNamed(name);
    const Chamber chamber = ChamberOf(sewer_.network, manhole);
    const double radius = sewer_.network.pipes[index].DiameterIn(name) / 2.0;
    const double shaft = chamber.shaft_radius_m;
    if (offset_m + 2.0 * radius <= chamber.bench_m) return;
    VoidPrimitive mouth;
    mouth.X_WS = sewer_.axes[index].PoseAt(chainage_m);
    const double falls = -outward * mouth.X_WS.linear()(2, 0);
    mouth.length_m = shaft - std::sqrt(shaft * shaft - radius * radius) + kOverlap_m;
    mouth.X_WS.translation() +=
        (outward < 0.0 ? -mouth.length_m : 0.0) * mouth.X_WS.linear().col(0) +
        std::max(0.0, falls * mouth.length_m) * mouth.X_WS.linear().col(2);
    mouth.start_chainage_m = outward < 0.0 ? -mouth.length_m : chainage_m;
    mouth.radius_m = radius;
    Add(mouth);
  }

  void AddInlet(std::size_t index, std::uint32_t item) {
    const Pipe& pipe = sewer_.network.pipes[index];
    const network::Inlet& inlet = pipe.inlets[item];
    const Eigen::Isometry3d X_WP = sewer_.axes[index].PoseAt(inlet.chainage_m);
    // How far the wall is from the pipe's axis, along the branch.
    const double wall_m = pipe.DiameterAt(inlet.chainage_m) / 2.0 / std::sin(inlet.angle_rad);
    VoidPrimitive branch;
    branch.X_WS = X_WP;
    const Vector3d out = std::sin(inlet.angle_rad) * network::ClockDirection(inlet.clock_h) -
                         std::cos(inlet.angle_rad) * Vector3d::UnitX();
    const Vector3d side = network::ClockDirection(inlet.clock_h).cross(Vector3d::UnitX());
    branch.X_WS.linear().col(0) = X_WP.linear() * out;
    branch.X_WS.linear().col(1) = X_WP.linear() * side.cross(out);
    branch.X_WS.linear().col(2) = X_WP.linear() * side;
    branch.length_m = wall_m + kInletLength_m;
    branch.radius_m = inlet.diameter_m / 2.0;
    branch.feature = Feature::kInlet;
    branch.start_chainage_m = inlet.chainage_m;
    Add(branch);
    if (inlet.protrusion_m <= 0.0) return;
    Stub stub;
    stub.X_WS = branch.X_WS;
    stub.start_m = wall_m - inlet.protrusion_m;
    stub.inner_radius_m = branch.radius_m;
    stub.outer_radius_m = branch.radius_m + kStubWallRatio * inlet.diameter_m;
    // A slanting branch leaves the pipe later on one side.
    stub.end_m = wall_m +
                 stub.outer_radius_m /
                     std::tan(std::min(inlet.angle_rad, std::numbers::pi - inlet.angle_rad)) +
                 kRoot_m;
    AddSolid({stub, Feature::kInlet, 0, item, inlet.chainage_m});
  }

  void AddSolid(SolidPrimitive solid) {
    solid.part = static_cast<std::uint32_t>(sewer_.parts.size() - 1);
    sewer_.solids.push_back(solid);
  }

  void AddObstacle(std::size_t index, std::uint32_t item) {
    const Pipe& pipe = sewer_.network.pipes[index];
    const network::Obstacle& obstacle = pipe.obstacles[item];
    switch (obstacle.kind) {
      case network::ObstacleKind::kSediment:
      case network::ObstacleKind::kMortarRidge:
        return AddAlong(index, item);
      case network::ObstacleKind::kStone:
      case network::ObstacleKind::kBrick:
        break;
    }
    const Eigen::Isometry3d X_WP = sewer_.axes[index].PoseAt(obstacle.chainage_m);
    const Vector3d outward = network::ClockDirection(obstacle.clock_h);
    const double top_m = pipe.DiameterAt(obstacle.chainage_m) / 2.0 - obstacle.height_m;
    SolidPrimitive solid;
    solid.item = item;
    if (obstacle.kind == network::ObstacleKind::kStone) {
      // Its foot is measured on the wall's tangent plane, as along the pipe.
      const double half = obstacle.width_m / 2.0;
      const double radius =
          (half * half + obstacle.height_m * obstacle.height_m) / (2.0 * obstacle.height_m);
      solid.shape = Ball{X_WP * ((top_m + radius) * outward), radius, X_WP.linear() * -outward,
                         std::max(radius - obstacle.height_m - kRoot_m, -radius)};
      solid.start_chainage_m = obstacle.chainage_m - half;
    } else {
      const double height = obstacle.height_m + kRoot_m;
      Block block;
      block.half_m = Vector3d(obstacle.length_m, obstacle.width_m, height) / 2.0;
      block.X_WB = X_WP;
      block.X_WB.translation() = X_WP * ((top_m + height / 2.0) * outward);
      block.X_WB.linear().col(1) = X_WP.linear() * outward.cross(Vector3d::UnitX());
      block.X_WB.linear().col(2) = X_WP.linear() * outward;
      solid.shape = block;
      solid.start_chainage_m = obstacle.chainage_m - obstacle.length_m / 2.0;
    }
    AddSolid(solid);
  }

  /// What lies along the pipe follows its axis, stretch by stretch.
  void AddAlong(std::size_t index, std::uint32_t item) {
    const Pipe& pipe = sewer_.network.pipes[index];
    const network::Obstacle& obstacle = pipe.obstacles[item];
    const double from = obstacle.chainage_m - obstacle.length_m / 2.0;
    const double to = obstacle.chainage_m + obstacle.length_m / 2.0;
    const std::vector<Stretch> stretches = Stretches(sewer_.axes[index], pipe, from, to);
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const Stretch& stretch = stretches[i];
      const double start = stretch.start_m - (i > 0 ? kOverlap_m : 0.0);
      const double end = stretch.end_m + (i + 1 < stretches.size() ? kOverlap_m : 0.0);
      SolidPrimitive solid;
      solid.item = item;
      solid.start_chainage_m = start;
      const SweptAxis axis = stretch.Axis(start, end);
      if (obstacle.kind == network::ObstacleKind::kSediment) {
        solid.shape = BedOn(axis, stretch.radius_m, obstacle.height_m, from - start, to - start);
      } else {
        Ridge ridge;
        ridge.axis = axis;
        ridge.inner_radius_m = std::max(stretch.radius_m - obstacle.height_m, 0.001);
        ridge.outer_radius_m = WithinBend(axis, stretch.radius_m + kRoot_m);
        ridge.middle_rad = obstacle.clock_h * std::numbers::pi / 6.0;
        ridge.half_arc_rad =
            obstacle.width_m > 0.0
                ? std::min(std::numbers::pi, obstacle.width_m / 2.0 / stretch.radius_m)
                : std::numbers::pi;
        solid.shape = ridge;
      }
      AddSolid(solid);
    }
  }

  void AddChannel(const Chamber& chamber, const Eigen::Isometry3d& X_WS, double length_m,
                  double curvature) {
    if (length_m <= 0.0) return;
    VoidPrimitive channel;
    channel.X_WS = X_WS;
    channel.length_m = length_m;
    channel.curvature = curvature;
    channel.radius_m = chamber.channel_radius_m;
    channel.profile = Profile::kU;
    // The sides end a little above the bench, where the shaft is open.
    channel.wall_height_m = chamber.bench_m - chamber.channel_radius_m + 0.001;
    channel.feature = Feature::kChannel;
    Add(channel);
  }

  /// Along `in` (towards the centre) and out along `out`, tangent to both.
  void AddChannelBetween(const Chamber& chamber, const Manhole& manhole, const Vector2d& in,
                         const Vector2d& out) {
    const Vector3d p_WC = manhole.p_WM + Vector3d(0.0, 0.0, chamber.channel_radius_m);
    const auto at = [&](const Vector2d& along, double distance) {
      return Level(p_WC + distance * Vector3d(along.x(), along.y(), 0.0), along);
    };
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    if (std::abs(turn) < kStraight_rad) {
      AddChannel(chamber, at(in, -chamber.shaft_radius_m), 2.0 * chamber.shaft_radius_m, 0.0);
      return;
    }
    const double half_tangent = std::tan(std::abs(turn) / 2.0);
    const double radius =
        std::min(manhole.channel_radius_m.value_or(kChannelRadiusRatio * chamber.shaft_radius_m),
                 chamber.shaft_radius_m / half_tangent);
    if (radius <= kTightestChannel * chamber.channel_radius_m) {
      // Two straight halves, each through to the other's outer side.
      const double beyond = chamber.channel_radius_m * std::min(1.0, half_tangent);
      AddChannel(chamber, at(in, -chamber.shaft_radius_m), chamber.shaft_radius_m + beyond, 0.0);
      AddChannel(chamber, at(out, -beyond), chamber.shaft_radius_m + beyond, 0.0);
      return;
    }
    const double tangent = radius * half_tangent;
    AddChannel(chamber, at(in, -chamber.shaft_radius_m),
               chamber.shaft_radius_m - tangent + kOverlap_m, 0.0);
    AddChannel(chamber, at(in, -tangent), radius * std::abs(turn),
               std::copysign(1.0 / radius, turn));
    AddChannel(chamber, at(out, tangent - kOverlap_m),
               chamber.shaft_radius_m - tangent + kOverlap_m, 0.0);
  }

  /// One channel for each two pipes that a channel can join; a lone pipe's goes straight on.
  void AddChannels(const Chamber& chamber, const Manhole& manhole,
                   const std::vector<std::size_t>& pipes) {
    std::vector<Vector2d> directions;
    for (const std::size_t i : pipes) {
      directions.push_back(
          network::DirectionFrom(sewer_.network, sewer_.network.pipes[i], manhole));
    }
    if (directions.size() == 1) AddChannelBetween(chamber, manhole, -directions[0], -directions[0]);
    std::vector<bool> joined(directions.size(), directions.size() == 1);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      for (std::size_t j = i + 1; j < directions.size(); ++j) {
        const double turn = std::acos(std::clamp(-directions[i].dot(directions[j]), -1.0, 1.0));
        if (turn > network::kSharpestTurn_rad + 1e-9) continue;
        AddChannelBetween(chamber, manhole, -directions[i], directions[j]);
        joined[i] = joined[j] = true;
      }
    }
    // What no channel joins still ends in the middle, not in the benching.
    for (std::size_t i = 0; i < directions.size(); ++i) {
      if (joined[i]) continue;
      const Vector3d p_WC = manhole.p_WM + Vector3d(0.0, 0.0, chamber.channel_radius_m);
      const Vector3d out(directions[i].x(), directions[i].y(), 0.0);
      AddChannel(chamber, Level(p_WC + chamber.shaft_radius_m * out, -directions[i]),
                 chamber.shaft_radius_m + chamber.channel_radius_m, 0.0);
    }
  }

  void AddManhole(std::size_t index) {
    const Manhole& manhole = sewer_.network.manholes[index];
    const std::vector<std::size_t> pipes = sewer_.network.PipesAt(manhole.name);
    if (pipes.empty()) return;
    const Chamber chamber = ChamberOf(sewer_.network, manhole);
    StartPart({Part::Kind::kManhole, index});
    if (chamber.bench_m > 0.0) AddChannels(chamber, manhole, pipes);

    // The cover lies above every pipe.
    double top_m = std::max(manhole.depth_m, chamber.bench_m + 0.3);
    for (const std::size_t i : pipes) {
      const Pipe& pipe = sewer_.network.pipes[i];
      const double offset_m =
          pipe.upstream == manhole.name ? pipe.upstream_offset_m : pipe.downstream_offset_m;
      top_m = std::max(top_m, offset_m + pipe.DiameterIn(manhole.name) + kRoot_m);
    }
    VoidPrimitive shaft;
    shaft.X_WS.linear().col(0) = Vector3d::UnitZ();
    shaft.X_WS.linear().col(1) = Vector3d::UnitY();
    shaft.X_WS.linear().col(2) = -Vector3d::UnitX();
    shaft.X_WS.translation() = manhole.p_WM + Vector3d(0.0, 0.0, chamber.bench_m);
    shaft.length_m = top_m - chamber.bench_m;
    shaft.radius_m = chamber.shaft_radius_m;
    shaft.feature = Feature::kShaft;
    Add(shaft);
  }

  Sewer sewer_;
};

}  // namespace

Sewer BuildSewer(const Network& network) { return Builder(network).Build(); }

}  // namespace kantaro::sim
