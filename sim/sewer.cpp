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
/// Channels are not carved for water (or a robot) to turn back more sharply than this.
constexpr double kSharpestTurn_rad = 120.0 * std::numbers::pi / 180.0;
/// Below this turn a channel is straight.
constexpr double kStraight_rad = 1.0 * std::numbers::pi / 180.0;
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

Chamber ChamberOf(const Network& network, const Manhole& manhole) {
  Chamber chamber;
  for (const std::size_t i : network.PipesAt(manhole.name)) {
    chamber.channel_radius_m =
        std::max(chamber.channel_radius_m, network.pipes[i].diameter_m / 2.0);
  }
  chamber.shaft_radius_m = network.ShaftDiameter(manhole) / 2.0;
  if (chamber.shaft_radius_m <= chamber.channel_radius_m + 0.05) {
    throw std::invalid_argument(
        fmt::format("manhole \"{}\": its shaft of {:.0f} mm is too narrow for its pipes",
                    manhole.name, chamber.shaft_radius_m * 2000.0));
  }
  chamber.bench_m = manhole.bench_height == network::BenchHeight::kCrown
                        ? 2.0 * chamber.channel_radius_m
                        : chamber.channel_radius_m;
  return chamber;
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

  /// Adds the tube between two chainages, one primitive for each piece of the axis it runs through.
  void AddTube(const PipeAxis& axis, double from_m, double to_m, double radius_m, Feature straight,
               Feature bent) {
    const auto& pieces = axis.pieces();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const bool first = i == 0;
      const bool last = i + 1 == pieces.size();
      const double piece_start = first ? from_m : pieces[i].start_m;
      const double piece_end = last ? to_m : pieces[i].start_m + pieces[i].length_m;
      double start = std::max(from_m, piece_start);
      double end = std::min(to_m, piece_end);
      if (end - start <= 0.0) continue;
      // Over the seams of the axis, tubes reach into each other.
      if (start > from_m) start -= kOverlap_m;
      if (end < to_m) end += kOverlap_m;
      VoidPrimitive whole;
      whole.X_WS = pieces[i].X_WS;
      whole.curvature = pieces[i].curvature;
      VoidPrimitive tube = whole;
      tube.X_WS = AxisPose(whole, start - pieces[i].start_m);
      tube.length_m = end - start;
      tube.radius_m = radius_m;
      tube.feature = tube.curvature == 0.0 ? straight : bent;
      tube.start_chainage_m = start;
      Add(tube);
    }
  }

  void AddPipe(std::size_t index) {
    const Pipe& pipe = sewer_.network.pipes[index];
    const PipeAxis& axis = sewer_.axes[index];
    const double radius = pipe.diameter_m / 2.0;
    StartPart({Part::Kind::kPipe, index});

    // Channels end at the shaft's wall, where the pipe begins.
    double start = -kOverlap_m;
    for (const network::Joint& joint : pipe.joints) {
      const double gap_start = joint.chainage_m - joint.gap_m / 2.0;
      const double gap_end = joint.chainage_m + joint.gap_m / 2.0;
      AddTube(axis, start, gap_start, radius, Feature::kStraight, Feature::kBend);
      constexpr double kLip =
          1e-4;  // the groove cuts a hair into both lengths, so that the three are one void
      AddTube(axis, gap_start - kLip, gap_end + kLip, radius + joint.depth_m, Feature::kJoint,
              Feature::kJoint);
      start = gap_end;
    }
    AddTube(axis, start, axis.length_m() + kOverlap_m, radius, Feature::kStraight, Feature::kBend);

    for (const network::Inlet& inlet : pipe.inlets) {
      const Eigen::Isometry3d X_WP = axis.PoseAt(inlet.chainage_m);
      const Vector3d out = network::ClockDirection(inlet.clock_h);
      VoidPrimitive branch;
      branch.X_WS = X_WP;
      branch.X_WS.linear().col(0) = X_WP.linear() * out;
      branch.X_WS.linear().col(1) = X_WP.linear().col(0);
      branch.X_WS.linear().col(2) = branch.X_WS.linear().col(0).cross(branch.X_WS.linear().col(1));
      branch.length_m = radius + kInletLength_m;
      branch.radius_m = inlet.diameter_m / 2.0;
      branch.feature = Feature::kInlet;
      branch.start_chainage_m = inlet.chainage_m;
      Add(branch);
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
    if (radius <= chamber.channel_radius_m) {
      throw std::invalid_argument(
          fmt::format("manhole \"{}\": a channel of {:.0f} mm cannot turn by {:.0f} degrees in it",
                      manhole.name, chamber.channel_radius_m * 2000.0,
                      std::abs(turn) * 180.0 / std::numbers::pi));
    }
    const double tangent = radius * half_tangent;
    AddChannel(chamber, at(in, -chamber.shaft_radius_m),
               chamber.shaft_radius_m - tangent + kOverlap_m, 0.0);
    AddChannel(chamber, at(in, -tangent), radius * std::abs(turn),
               std::copysign(1.0 / radius, turn));
    AddChannel(chamber, at(out, tangent - kOverlap_m),
               chamber.shaft_radius_m - tangent + kOverlap_m, 0.0);
  }

  void AddManhole(std::size_t index) {
    const Manhole& manhole = sewer_.network.manholes[index];
    const std::vector<std::size_t> pipes = sewer_.network.PipesAt(manhole.name);
    if (pipes.empty()) return;
    const Chamber chamber = ChamberOf(sewer_.network, manhole);
    StartPart({Part::Kind::kManhole, index});

    std::vector<Vector2d> directions;
    for (const std::size_t i : pipes) {
      directions.push_back(
          network::DirectionFrom(sewer_.network, sewer_.network.pipes[i], manhole));
    }
    if (directions.size() == 1) AddChannelBetween(chamber, manhole, -directions[0], -directions[0]);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      for (std::size_t j = i + 1; j < directions.size(); ++j) {
        const double turn = std::acos(std::clamp(-directions[i].dot(directions[j]), -1.0, 1.0));
        if (turn <= kSharpestTurn_rad)
          AddChannelBetween(chamber, manhole, -directions[i], directions[j]);
      }
    }

    VoidPrimitive shaft;
    shaft.X_WS.linear().col(0) = Vector3d::UnitZ();
    shaft.X_WS.linear().col(1) = Vector3d::UnitY();
    shaft.X_WS.linear().col(2) = -Vector3d::UnitX();
    shaft.X_WS.translation() = manhole.p_WM + Vector3d(0.0, 0.0, chamber.bench_m);
    shaft.length_m = std::max(manhole.depth_m - chamber.bench_m, 0.3);
    shaft.radius_m = chamber.shaft_radius_m;
    shaft.feature = Feature::kShaft;
    Add(shaft);
  }

  Sewer sewer_;
};

}  // namespace

Sewer BuildSewer(const Network& network) { return Builder(network).Build(); }

}  // namespace kantaro::sim
