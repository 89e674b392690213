// What a step, a picture and a ray cost in a city of 10,000 pipes, against ten of them, at the same
// place. The two are measured by turns in one run, in processor time of all threads, so that
// whatever else the machine does falls on neither; `ratio` is the median over the turns, and at
// most 1.1.
//
// In the city the physics holds the walls of all 10,000 pipes. Cameras and rays get what a mission
// gives them in a large network: the surroundings of its route, cut out of the 10,000. The ten are
// small enough to be built whole.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "network/generator.hpp"
#include "network/topology.hpp"
#include "sim/physics.hpp"
#include "sim/renderer.hpp"
#include "sim/twin.hpp"

namespace kantaro::sim {
namespace {

constexpr std::size_t kManyPipes = 10'000;
constexpr std::size_t kFewPipes = 10;
constexpr double kMissionReach_m = 10.0;  // as missions cut it out

/// A straight 250 mm pipe inside the city, whose wall is not disturbed by an inlet.
const network::Pipe& Place(const network::Network& city) {
  for (std::size_t i = city.pipes.size() / 2; i < city.pipes.size(); ++i) {
    const network::Pipe& pipe = city.pipes[i];
    if (pipe.diameter_m == 0.250 && pipe.bends.empty() && pipe.inlets.empty()) return pipe;
  }
  throw std::runtime_error("the city has no such pipe");
}

/// The ten pipes around a pipe, or the few more that the last manhole brings.
network::Network Few(const network::Network& city, const network::Pipe& pipe) {
  for (double reach_m = kMissionReach_m;; reach_m *= 1.1) {
    network::Network few = network::Neighbourhood(city, {pipe.upstream, pipe.downstream}, reach_m);
    if (few.pipes.size() >= kFewPipes) return few;
  }
}

struct Worlds {
  network::Network city = network::Generate({network::Layout::kCity, kManyPipes, {}, 35.8, 1});
  network::Pipe pipe = Place(city);
  network::Network few = Few(city, pipe);
  World around_city = BuildWorld(
      network::Neighbourhood(city, {pipe.upstream, pipe.downstream}, kMissionReach_m), 1, true);
  World around_few = BuildWorld(few, 1, true);
  Sewer sewer_city = BuildSewer(city);
  VoidField field_city{sewer_city.voids, sewer_city.solids};
  robot::Description description =
      robot::ReadDescription(std::filesystem::path(KANTARO_SOURCE_DIR) / "models/kantaro");
};

const Worlds& TheWorlds() {
  static const Worlds worlds;
  return worlds;
}

/// Runs both by turns. @param turn  does some of what is measured.
void Compare(benchmark::State& state, const std::function<void()>& many_turn,
             const std::function<void()>& few_turn) {
  const auto time = [](const std::function<void()>& turn) {
    const std::clock_t start = std::clock();
    turn();
    return static_cast<double>(std::clock() - start);
  };
  many_turn();
  few_turn();
  std::vector<double> ratios;
  for (auto _ : state) {
    const double many_first_s = time(many_turn), few_s = time(few_turn);
    const double few_again_s = time(few_turn), many_s = time(many_turn);
    ratios.push_back((many_first_s + many_s) / (few_s + few_again_s));
  }
  std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
  state.counters["ratio"] = ratios[ratios.size() / 2];
  state.counters["few_pipes"] = static_cast<double>(TheWorlds().few.pipes.size());
}

/// A robot that drives on in the pipe, as far as five metres and again.
class Drive {
 public:
  Drive(const Sewer& sewer, const VoidField& field)
      : sewer_(sewer), physics_(field, TheWorlds().description, Options()) {
    Start();
  }
  void Turn() {
    for (int i = 0; i < 500; ++i) physics_.Step();
    if (physics_.time_s() > 40.0) Start();
  }

 private:
  static PhysicsOptions Options() {
    PhysicsOptions options;
    options.mast_height_m = TheWorlds().description.MastHeight(0.250);
    return options;
  }
  void Start() {
    physics_.Place(sewer_, {TheWorlds().pipe.name, 2.0, true, 0.0, 0.0});
    physics_.Drive(0.13 / 0.045, 0.13 / 0.045);
  }

  const Sewer& sewer_;
  Physics physics_;
};

void BM_Step(benchmark::State& state) {
  const Worlds& worlds = TheWorlds();
  Drive many(worlds.sewer_city, worlds.field_city);
  Drive few(*worlds.around_few.sewer, *worlds.around_few.field);
  Compare(
      state, [&] { many.Turn(); }, [&] { few.Turn(); });
  state.counters["primitives_many"] = static_cast<double>(worlds.sewer_city.voids.size());
  state.counters["primitives_few"] = static_cast<double>(worlds.around_few.sewer->voids.size());
}

/// On the pipe's axis, looking along it.
Eigen::Isometry3d AxisAt(const Sewer& sewer, double chainage_m) {
  return sewer.axes[sewer.network.FindPipe(TheWorlds().pipe.name).value()].PoseAt(chainage_m);
}

void BM_Camera(benchmark::State& state) {
  const Worlds& worlds = TheWorlds();
  Renderer many(worlds.around_city.scenery), few(worlds.around_few.scenery);
  CameraView view;
  Eigen::Matrix3d R_AC;  // optical axes: x right, y down, z forward
  R_AC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  view.X_WC = AxisAt(*worlds.around_few.sewer, 5.0);
  view.X_WC.linear() *= R_AC;
  Lamps lamps;
  lamps.p_WLamp = {view.X_WC.translation()};
  lamps.direction_W = view.X_WC.linear().col(2);
  Compare(
      state, [&] { benchmark::DoNotOptimize(many.Render(view, lamps)); },
      [&] { benchmark::DoNotOptimize(few.Render(view, lamps)); });
}

/// Whole turns of the laser, across the axis and a little askew.
void BM_Rays(benchmark::State& state) {
  const Worlds& worlds = TheWorlds();
  std::vector<Ray> rays;
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Isometry3d X_WA = AxisAt(*worlds.around_few.sewer, 3.0 + i * 2e-4);
    const double angle = 2.0 * std::numbers::pi * i / 97.0;
    rays.push_back(
        {X_WA.translation(),
         X_WA.linear() * Eigen::Vector3d(std::sin(0.1 * i) * 0.5, std::cos(angle), std::sin(angle))
                             .normalized()});
  }
  std::vector<std::optional<RayHit>> hits(rays.size());
  Compare(
      state, [&] { worlds.around_city.rays->Cast(rays, 100.0, hits); },
      [&] { worlds.around_few.rays->Cast(rays, 100.0, hits); });
}

BENCHMARK(BM_Step)->Unit(benchmark::kMillisecond)->Iterations(40);
BENCHMARK(BM_Camera)->Unit(benchmark::kMillisecond)->Iterations(40);
BENCHMARK(BM_Rays)->Unit(benchmark::kMillisecond)->Iterations(40);

}  // namespace
}  // namespace kantaro::sim
