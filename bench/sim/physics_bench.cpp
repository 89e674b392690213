// How much faster than time the physics alone runs, and how much of a step is the contact function:
// a wheel's search beside MuJoCo's whole step in the same program. One thread.
#include <benchmark/benchmark.h>

#include <chrono>
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
int CountContacts(const Physics& physics, std::vector<mjContact>& contacts) {
  const mjModel& model = physics.model();
  int count = 0;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const mjfCollision collide = mjCOLLISIONFUNC[mjGEOM_ELLIPSOID][model.geom_type[geom]];
    if (model.geom_type[geom] == mjGEOM_ELLIPSOID) continue;
    count += collide(&model, &physics.data(), contacts.data(), 0, geom, 0.0);
  }
  return count;
}

void Contacts(benchmark::State& state, const StartPose& start) {
  Physics physics(TheBench().field, TheBench().description, TheBench().Options());
  TheBench().Start(physics, start);
  std::vector<mjContact> contacts(mjMAXCONPAIR);
  for (auto _ : state) benchmark::DoNotOptimize(CountContacts(physics, contacts));
}
void BM_ContactInAStraightPipe(benchmark::State& state) {
  Contacts(state, {"P1", 2.5, true, 0.0, 0.0});
}
void BM_ContactAtAJoint(benchmark::State& state) { Contacts(state, {"P1", 1.68, true, 0.0, 0.0}); }
BENCHMARK(BM_ContactInAStraightPipe)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_ContactAtAJoint)->Unit(benchmark::kMicrosecond);

/// The contact function's share of a step on a drive over joints, both timed by turns.
void BM_ContactShare(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  Physics physics(TheBench().field, TheBench().description, TheBench().Options());
  const StartPose start{"P1", 0.5, true, 0.0, 0.0};
  TheBench().Start(physics, start);
  std::vector<mjContact> contacts(mjMAXCONPAIR);
  Clock::duration steps{}, searches{};
  for (auto _ : state) {
    const auto began = Clock::now();
    physics.Step();
    const auto stepped = Clock::now();
    benchmark::DoNotOptimize(CountContacts(physics, contacts));
    searches += Clock::now() - stepped;
    steps += stepped - began;
    if (physics.time_s() > 30.0) TheBench().Start(physics, start);
  }
  state.counters["contact_share"] =
      static_cast<double>(searches.count()) / static_cast<double>(steps.count());
}
BENCHMARK(BM_ContactShare)->Unit(benchmark::kMicrosecond)->Iterations(30'000);

}  // namespace
}  // namespace kantaro::sim
