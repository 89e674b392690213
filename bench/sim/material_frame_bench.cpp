// Processor time of one 640 x 480 frame, of all threads together, so that whatever else the machine
// does does not count: in dry, wet and slimy pipes, with water, and at a manhole's mouth.
#include <benchmark/benchmark.h>

#include <string>

#include "sim/renderer.hpp"
#include "sim/twin.hpp"

namespace kantaro::sim {
namespace {

network::Network StraightPipe(network::Material material, network::WallCondition condition,
                              double water_m) {
  network::Network network;
  network.name = "frame";
  for (const double x_m : {-5.0, 5.0}) {
    network::Manhole manhole;
    manhole.name = x_m < 0.0 ? "up" : "down";
    manhole.p_WM = {x_m, 0.0, 0.0};
    network.manholes.push_back(manhole);
  }
  network::Pipe pipe;
  pipe.name = "pipe";
  pipe.upstream = network.manholes[0].name;
  pipe.downstream = network.manholes[1].name;
  pipe.diameter_m = 0.3;
  pipe.material = material;
  pipe.condition = condition;
  pipe.water_m = water_m;
  for (int i = 1; i < 8; ++i) pipe.joints.push_back({static_cast<double>(i)});
  network.pipes.push_back(pipe);
  return network;
}

void Frame(benchmark::State& state, network::Material material, network::WallCondition condition,
           double water_m, double chainage_m) {
  const World world = BuildWorld(StraightPipe(material, condition, water_m), 1, true);
  Renderer renderer(world.scenery);
  Eigen::Matrix3d R_PC;  // optical axes: x right, y down, z forward
  R_PC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  CameraView view;
  view.X_WC = world.sewer->axes.front().PoseAt(chainage_m);
  view.X_WC.linear() *= R_PC;
  Lamps lamps;
  for (const double x_m : {-0.015, 0.015}) {
    for (const double y_m : {-0.016, 0.016})
      lamps.p_WLamp.push_back(view.X_WC * Eigen::Vector3d(x_m, y_m, 0.0));
  }
  lamps.direction_W = view.X_WC.linear().col(2);
  benchmark::DoNotOptimize(renderer.Render(view, lamps));
  for (auto _ : state) benchmark::DoNotOptimize(renderer.Render(view, lamps));
}

using network::Material;
using network::WallCondition;
constexpr double kInPipe_m = 2.3, kAtMouth_m = 8.6;

void BM_DryPlastic(benchmark::State& state) {
  Frame(state, Material::kPvc, WallCondition::kDry, 0.0, kInPipe_m);
}
void BM_WetClay(benchmark::State& state) {
  Frame(state, Material::kClay, WallCondition::kWet, 0.0, kInPipe_m);
}
void BM_SlimyConcrete(benchmark::State& state) {
  Frame(state, Material::kConcrete, WallCondition::kSlimy, 0.0, kInPipe_m);
}
void BM_WetConcreteWithWater(benchmark::State& state) {
  Frame(state, Material::kConcrete, WallCondition::kWet, 0.025, kInPipe_m);
}
void BM_Mouth(benchmark::State& state) {
  Frame(state, Material::kPvc, WallCondition::kDry, 0.0, kAtMouth_m);
}
BENCHMARK(BM_DryPlastic)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(BM_WetClay)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(BM_SlimyConcrete)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(BM_WetConcreteWithWater)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(BM_Mouth)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
}  // namespace kantaro::sim
