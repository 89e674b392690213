#include "tests/network/sewers.hpp"

#include <numbers>

#include "base/random.hpp"

namespace kantaro::network {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : stream_(seed, "sewer") {}

  double Between(double low, double high) { return stream_.Uniform(low, high); }
  double Clock() { return 12.0 - stream_.Uniform(0.0, 12.0); }
  bool Happens(double share) { return stream_.Uniform(0.0, 1.0) < share; }
  template <typename Enum>
  Enum Among(std::uint64_t count) {
    return static_cast<Enum>(stream_.Index(count));
  }

 private:
  RandomStream stream_;
};

Manhole RandomManhole(Chance& chance, int number, double x_m) {
  Manhole manhole = ManholeAt("M" + std::to_string(number), x_m, chance.Between(-3, 3),
                              chance.Between(-0.1, 0.1));
  manhole.depth_m = chance.Between(1, 5);
  manhole.bench_height = chance.Among<BenchHeight>(4);
  if (manhole.bench_height == BenchHeight::kGiven) manhole.given_bench_m = chance.Between(0.1, 0.4);
  if (chance.Happens(0.3)) manhole.shaft_diameter_m = chance.Between(0.8, 1.5);
  if (chance.Happens(0.3)) manhole.channel_radius_m = chance.Between(0.3, 0.5);
  return manhole;
}

/// Within the first 8 m of the pipe, one in every metre.
std::vector<Joint> RandomJoints(Chance& chance) {
  std::vector<Joint> joints;
  for (int i = 1; i < 8; ++i) {
    Joint joint;
    joint.chainage_m = i + chance.Between(0.1, 0.9);
    joint.gap_m = chance.Between(0.001, 0.03);
    joint.depth_m = chance.Between(0.001, 0.02);
    if (chance.Happens(0.5)) joint.offset_m = chance.Between(0, 0.02);
    if (chance.Happens(0.5)) joint.offset_clock_h = chance.Clock();
    if (chance.Happens(0.5)) joint.deflection_rad = chance.Between(0, 1.5 * kDegree);
    if (chance.Happens(0.5)) joint.deflection_clock_h = chance.Clock();
    joints.push_back(joint);
  }
  return joints;
}

Obstacle RandomObstacle(Chance& chance, const std::string& name) {
  Obstacle obstacle{name,
                    chance.Among<ObstacleKind>(4),
                    chance.Between(1, 9),
                    chance.Clock(),
                    chance.Between(0.005, 0.04),
                    chance.Between(0.08, 0.3),
                    0.0};
  if (obstacle.kind == ObstacleKind::kSediment) {
    obstacle.clock_h = 6.0;
  } else if (obstacle.kind != ObstacleKind::kMortarRidge || chance.Happens(0.5)) {
    obstacle.width_m = chance.Between(0.08, 0.15);
  }
  if (obstacle.kind == ObstacleKind::kStone) obstacle.length_m = obstacle.width_m;
  return obstacle;
}

Pipe RandomPipe(Chance& chance, int number) {
  const std::string name = "P" + std::to_string(number);
  Pipe pipe = PipeFrom(name, "M" + std::to_string(number), "M" + std::to_string(number + 1),
                       chance.Between(0.2, 0.5));
  pipe.material = chance.Among<Material>(4);
  pipe.condition = chance.Among<WallCondition>(3);
  if (chance.Happens(0.5)) pipe.water_m = chance.Between(0, 0.1);
  if (chance.Happens(0.5)) pipe.upstream_offset_m = chance.Between(0, 0.1);
  if (chance.Happens(0.5)) pipe.downstream_offset_m = chance.Between(0, 0.1);
  pipe.joints = RandomJoints(chance);
  if (chance.Happens(0.5)) pipe.sags = {{chance.Between(0, 2), chance.Between(6, 9), 0.01}};
  if (chance.Happens(0.5)) {
    pipe.diameter_changes = {
        {chance.Between(9, 9.5), chance.Between(0.2, 0.5), chance.Among<Alignment>(3)}};
  }
  for (int i = 0; i < 2; ++i) {
    const std::string mark = name + "-" + std::to_string(i);
    pipe.inlets.push_back({mark, chance.Between(1, 9), chance.Between(0.1, 0.15), chance.Clock()});
    if (chance.Happens(0.5)) pipe.inlets.back().angle_rad = chance.Between(31, 149) * kDegree;
    if (chance.Happens(0.5)) pipe.inlets.back().protrusion_m = chance.Between(0, 0.15);
    pipe.obstacles.push_back(RandomObstacle(chance, mark));
    pipe.faults.push_back({mark, chance.Among<FaultCategory>(9), chance.Among<FaultRank>(3),
                           chance.Between(1, 9), chance.Clock(), chance.Between(0.01, 0.5),
                           chance.Between(0.001, 0.1)});
  }
  return pipe;
}

}  // namespace

Network RandomSewer(std::uint64_t seed) {
  Chance chance(seed);
  Network network;
  network.name = "seed " + std::to_string(seed);
  double x_m = chance.Between(-10, 10);
  network.manholes.push_back(RandomManhole(chance, 0, x_m));
  for (int i = 0; i < 4; ++i) {
    const double from_m = x_m;
    x_m += chance.Between(14, 30);
    network.manholes.push_back(RandomManhole(chance, i + 1, x_m));
    Pipe pipe = RandomPipe(chance, i);
    if (chance.Happens(0.5)) {
      pipe.bends = {{{(from_m + x_m) / 2, chance.Between(-2, 2)}, chance.Between(0.4, 2)}};
    }
    network.pipes.push_back(pipe);
  }
  return network;
}

}  // namespace kantaro::network
