// How much faster than time the physics alone runs, and how much of a step is the contact function:
// a wheel's search beside MuJoCo's whole step in the same program. One thread.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "network/formats.hpp"
#include "sim/physics.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {
namespace {

const std::filesystem::path kRoot = KANTARO_SOURCE_DIR;

struct Bench {
  robot::Description description = robot::ReadDescription(kRoot / "models/kantaro");
  Sewer sewer = BuildSewer(network::ReadNetwork(kRoot / "models/networks/test_field.yaml"));
  VoidField field{sewer.voids, sewer.solids};

  PhysicsOptions Options() const {
    PhysicsOptions options;
    options.mast_height_m = description.MastHeight(0.300);
    return options;
  }

  void Start(Physics& physics, const StartPose& start) const {
    physics.Place(sewer, start);
    physics.Drive(0.13 / 0.045, 0.13 / 0.045);
  }
};

const Bench& TheBench() {
  static const Bench bench;
  return bench;
}

/// Drives on from a place; simulated seconds per second is the ratio to real time.
void DriveFrom(benchmark::State& state, const StartPose& start, double drive_s) {
  Physics physics(TheBench().field, TheBench().description, TheBench().Options());
  TheBench().Start(physics, start);
  double simulated_s = 0.0;
  for (auto _ : state) {
    physics.Step();
    simulated_s += physics.timestep_s();
    if (physics.time_s() > drive_s) {
      state.PauseTiming();
      TheBench().Start(physics, start);
      state.ResumeTiming();
    }
  }
  state.counters["real_time_factor"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}

void BM_StraightPipe(benchmark::State& state) {
  DriveFrom(state, {"P1", 0.5, true, 0.0, 0.0}, 30.0);
}
void BM_AcrossATee(benchmark::State& state) { DriveFrom(state, {"P2", 6.6, true, 0.0, 0.0}, 8.0); }
BENCHMARK(BM_StraightPipe)->Unit(benchmark::kMicrosecond)->MinTime(2.0);
BENCHMARK(BM_AcrossATee)->Unit(benchmark::kMicrosecond)->MinTime(2.0);

/// Everything the contact function does in one step: four wheels and every box, where the robot
/// stands.
void Contacts(benchmark::State& state, const StartPose& start) {
  Physics physics(TheBench().field, TheBench().description, TheBench().Options());
  TheBench().Start(physics, start);
  const mjModel& model = physics.model();
  const mjData& data = physics.data();
  std::vector<mjContact> contacts(mjMAXCONPAIR);
  for (auto _ : state) {
    int count = 0;
    for (int geom = 0; geom < model.ngeom; ++geom) {
      const mjfCollision collide = mjCOLLISIONFUNC[mjGEOM_ELLIPSOID][model.geom_type[geom]];
      if (model.geom_type[geom] == mjGEOM_ELLIPSOID) continue;
      count += collide(&model, &data, contacts.data(), 0, geom, 0.0);
    }
    benchmark::DoNotOptimize(count);
  }
}
void BM_ContactInAStraightPipe(benchmark::State& state) {
  Contacts(state, {"P1", 2.5, true, 0.0, 0.0});
}
void BM_ContactAtAJoint(benchmark::State& state) { Contacts(state, {"P1", 1.68, true, 0.0, 0.0}); }
BENCHMARK(BM_ContactInAStraightPipe)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_ContactAtAJoint)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace kantaro::sim
