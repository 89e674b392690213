#include "random_sewer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "base/random.hpp"
#include "network/check.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::sim {
namespace {

using network::BenchHeight;
using network::Manhole;
using network::Network;
using network::ObstacleKind;
using network::Pipe;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed, "sewer") {}

  Network Hub(int most_pipes) {
    Network network;
    network.name = "random";
    network.manholes.push_back(HubManhole());
    const auto pipes = static_cast<int>(1 + random_.Index(static_cast<std::uint64_t>(most_pipes)));
    const double turn = random_.Uniform(0.0, 2.0 * std::numbers::pi);
    for (int i = 0; i < pipes; ++i) {
      const double heading =
          turn + 2.0 * std::numbers::pi * (i + random_.Uniform(-0.25, 0.25)) / pipes;
      AddPipe(network, fmt::format("P{}", i), heading);
    }
    for (Pipe& pipe : network.pipes) Fill(network, pipe);
    return network;
  }

 private:
  bool Chance(double share) { return random_.Uniform(0.0, 1.0) < share; }
  double Clock() { return 12.0 * (1.0 - random_.Uniform(0.0, 1.0)); }

  Manhole HubManhole() {
    Manhole hub;
    hub.name = "hub";
    hub.bench_height = std::array{BenchHeight::kFlat, BenchHeight::kAxis, BenchHeight::kCrown,
                                  BenchHeight::kGiven}[random_.Index(4)];
    if (hub.bench_height == BenchHeight::kGiven) hub.given_bench_m = random_.Uniform(0.05, 0.4);
    if (Chance(0.3)) hub.shaft_diameter_m = random_.Uniform(0.85, 1.3);
    if (Chance(0.3)) hub.channel_radius_m = random_.Uniform(0.2, 0.5);
    return hub;
  }

  void AddPipe(Network& network, const std::string& name, double heading) {
    Manhole end;
    end.name = "end of " + name;
    const double away = random_.Uniform(2.3, 3.2);
    end.p_WM = {away * std::cos(heading), away * std::sin(heading), random_.Uniform(-0.15, 0.25)};
    end.bench_height = Chance(0.5) ? BenchHeight::kCrown : BenchHeight::kFlat;
    Pipe pipe;
    pipe.name = name;
    pipe.upstream = Chance(0.5) ? end.name : "hub";
    pipe.downstream = pipe.upstream == "hub" ? end.name : "hub";
    pipe.diameter_m = random_.Uniform(0.15, 0.4);
    if (Chance(0.4))
      (pipe.upstream == "hub" ? pipe.upstream_offset_m : pipe.downstream_offset_m) =
          random_.Uniform(0.0, 0.3);
    if (Chance(0.3)) {
      const double bend = random_.Uniform(-0.25, 0.25);
      const Eigen::Vector2d along = end.p_WM.head<2>();
      pipe.bends.push_back(
          {0.5 * along + bend * Eigen::Vector2d(-along.y(), along.x()), 1.5 * pipe.diameter_m});
    }
    network.manholes.push_back(end);
    network.pipes.push_back(pipe);
  }

  void Fill(const Network& network, Pipe& pipe) {
    const double length = network::PipeAxis(network, pipe).length_m();
    double at = random_.Uniform(0.1, 0.4);
    if (Chance(0.7)) {
      for (; at < length - 0.15; at += random_.Uniform(0.2, 0.7))
        pipe.joints.push_back(MovedJoint(at));
    }
    if (Chance(0.3))
      pipe.diameter_changes.push_back(
          {random_.Uniform(0.2, 0.8) * length, pipe.diameter_m + random_.Uniform(-0.05, 0.1),
           std::array{network::Alignment::kInvert, network::Alignment::kAxis,
                      network::Alignment::kCrown}[random_.Index(3)]});
    if (Chance(0.2)) pipe.sags.push_back({0.1, length - 0.1, random_.Uniform(0.005, 0.02)});
    for (int i = 0; i < 2; ++i) {
      if (Chance(0.5)) pipe.inlets.push_back(AnyInlet(pipe, length, i));
      if (Chance(0.7)) pipe.obstacles.push_back(AnyObstacle(pipe, length, i));
    }
  }

  network::Joint MovedJoint(double at) {
    network::Joint joint;
    joint.chainage_m = at;
    joint.gap_m = random_.Uniform(0.004, 0.03);
    joint.depth_m = random_.Uniform(0.004, 0.015);
    if (Chance(0.4)) joint.offset_m = random_.Uniform(0.0, 0.015);
    joint.offset_clock_h = Clock();
    if (Chance(0.4)) joint.deflection_rad = random_.Uniform(0.0, 0.05);
    joint.deflection_clock_h = Clock();
    return joint;
  }

  network::Inlet AnyInlet(const Pipe& pipe, double length, int i) {
    network::Inlet inlet;
    inlet.name = fmt::format("{} inlet {}", pipe.name, i);
    inlet.diameter_m = std::min(random_.Uniform(0.08, 0.16), 0.8 * pipe.diameter_m);
    inlet.chainage_m = random_.Uniform(0.2, 0.8) * length;
    inlet.clock_h = Clock();
    inlet.angle_rad = random_.Uniform(0.8, 2.3);
    if (Chance(0.5)) inlet.protrusion_m = random_.Uniform(0.0, 0.4 * pipe.diameter_m);
    return inlet;
  }

  network::Obstacle AnyObstacle(const Pipe& pipe, double length, int i) {
    network::Obstacle obstacle;
    obstacle.name = fmt::format("{} obstacle {}", pipe.name, i);
    obstacle.kind = std::array{ObstacleKind::kSediment, ObstacleKind::kStone,
                               ObstacleKind::kMortarRidge, ObstacleKind::kBrick}[random_.Index(4)];
    obstacle.chainage_m = random_.Uniform(0.25, 0.75) * length;
    obstacle.clock_h = Clock();
    obstacle.height_m = random_.Uniform(0.005, 0.05);
    obstacle.length_m = random_.Uniform(0.03, 0.2);
    if (obstacle.kind == ObstacleKind::kSediment) {
      obstacle.clock_h = 6.0;
      obstacle.length_m *= 2.0;
    } else if (obstacle.kind != ObstacleKind::kMortarRidge || Chance(0.7)) {
      obstacle.width_m = random_.Uniform(0.1, 0.14);
    }
    if (obstacle.kind == ObstacleKind::kStone) obstacle.length_m = obstacle.width_m;
    return obstacle;
  }

  RandomStream random_;
};

}  // namespace

Network RandomNetwork(std::uint64_t seed, int most_pipes) {
  // What cannot be laid is drawn again.
  for (std::uint64_t attempt = 0;; ++attempt) {
    try {
      Network network = Draw(seed + (attempt << 40)).Hub(most_pipes);
      network::CheckNetwork(network);
      return network;
    } catch (const network::Flaw&) {
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace kantaro::sim
