// Rays per second in the test field's sewer, ours beside MuJoCo's mj_ray on the same triangles, one
// thread each; and how long the triangles take to make.
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "base/random.hpp"
#include "network/formats.hpp"
#include "sim/ray_caster.hpp"
#include "sim/sewer.hpp"

namespace kantaro::sim {
namespace {

constexpr double kRange_m = 100.0;

const Sewer& TestField() {
  static const Sewer sewer = BuildSewer(network::ReadNetwork(
      std::filesystem::path(KANTARO_SOURCE_DIR) / "models/networks/test_field.yaml"));
  return sewer;
}

const SurfaceMesh& Wall() {
  static const SurfaceMesh mesh = Tessellate(TestField().voids, TestField().solids);
  return mesh;
}

// As a turning laser sends them: whole revolutions across the axis, from points near it.
std::vector<Ray> LaserRays(std::size_t count) {
  RandomStream random(1, "ray caster bench");
  const auto& voids = TestField().voids;
  std::vector<Ray> rays;
  Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 100 == 0) {
      const auto& host = voids[(i / 100) % voids.size()];
      X_WL = AxisPose(host, host.length_m * random.Uniform(0.2, 0.8)) *
             Eigen::AngleAxisd(random.Uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ());
    }
    const double angle = 2.0 * std::numbers::pi * random.Uniform(0.0, 1.0);
    rays.push_back({X_WL * Eigen::Vector3d(0.0, 0.01, -0.02),
                    X_WL.linear() * Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle))});
  }
  return rays;
}

// The wall as a MuJoCo world of one mesh, read from memory.
class MujocoWall {
 public:
  explicit MujocoWall(const SurfaceMesh& mesh) {
    const std::vector<char> file = MeshFile(mesh);
    const char xml[] =
        "<mujoco><asset><mesh name='wall' file='wall.msh'/></asset>"
        "<worldbody><geom type='mesh' mesh='wall' contype='0' "
        "conaffinity='0'/></worldbody></mujoco>";
    const auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    AddFile(*vfs, "wall.msh", file.data(), file.size());
    AddFile(*vfs, "world.xml", xml, sizeof(xml) - 1);
    char error[500] = "";
    model_ = mj_loadXML("world.xml", vfs.get(), error, sizeof(error));
    mj_deleteVFS(vfs.get());
    if (model_ == nullptr) throw std::runtime_error(error);
    data_ = mj_makeData(model_);
    mj_kinematics(model_, data_);
  }
  ~MujocoWall() {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoWall(const MujocoWall&) = delete;
  MujocoWall& operator=(const MujocoWall&) = delete;

  [[nodiscard]] double Cast(const Ray& ray) const {
    int geom = -1;
    return mj_ray(model_, data_, ray.p_WR.data(), ray.direction_W.data(), nullptr, 1, -1, &geom);
  }

 private:
  // MuJoCo's binary format: four counts, then vertices and triangles. It wants the outside in
  // front.
  static std::vector<char> MeshFile(const SurfaceMesh& mesh) {
    std::vector<char> bytes;
    const auto append = [&](const auto& item) {
      const auto* const first = reinterpret_cast<const char*>(&item);
      bytes.insert(bytes.end(), first, first + sizeof(item));
    };
    append(std::array{static_cast<int>(mesh.positions.size()), 0, 0,
                      static_cast<int>(mesh.triangles.size())});
    for (const auto& p_WV : mesh.positions) append(Eigen::Vector3f(p_WV.cast<float>()));
    for (const auto& [a, b, c] : mesh.triangles) append(std::array{a, c, b});
    return bytes;
  }

  static void AddFile(mjVFS& vfs, const char* name, const char* bytes, std::size_t count) {
    if (mj_makeEmptyFileVFS(&vfs, name, static_cast<int>(count)) != 0) {
      throw std::runtime_error("MuJoCo's file system took no file");
    }
    std::memcpy(vfs.filedata[mj_findFileVFS(&vfs, name)], bytes, count);
  }

  mjModel* model_{};
  mjData* data_{};
};

void Ours(benchmark::State& state) {
  const RayCaster caster(Wall());
  const std::vector<Ray> rays = LaserRays(10000);
  std::vector<std::optional<RayHit>> hits(rays.size());
  for (auto _ : state) {
    caster.Cast(rays, kRange_m, hits);
    benchmark::DoNotOptimize(hits.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
  state.counters["triangles"] = static_cast<double>(Wall().triangles.size());
}
BENCHMARK(Ours)->Unit(benchmark::kMicrosecond);

// `times_ours` is the time of a ray over the time of ours, measured in turn.
void Mujoco(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const MujocoWall wall(Wall());
  const RayCaster caster(Wall());
  const std::vector<Ray> rays = LaserRays(1000);
  std::vector<std::optional<RayHit>> hits(rays.size());
  std::size_t next = 0;
  double disagreement_m = 0.0;
  Clock::duration mujoco_time{};
  Clock::duration our_time{};
  for (auto _ : state) {
    const auto start = Clock::now();
    const double range_m = wall.Cast(rays[next]);
    mujoco_time += Clock::now() - start;
    state.PauseTiming();
    const auto our_start = Clock::now();
    caster.Cast(rays, kRange_m, hits);
    our_time += Clock::now() - our_start;
    const double ours_m = hits[next] ? hits[next]->range_m : -1.0;
    disagreement_m = std::max(disagreement_m, std::abs(range_m - ours_m));
    next = (next + 1) % rays.size();
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["times_ours"] = static_cast<double>(mujoco_time.count()) *
                                 static_cast<double>(rays.size()) /
                                 static_cast<double>(our_time.count());
  state.counters["disagreement_m"] = disagreement_m;
}
BENCHMARK(Mujoco)->Unit(benchmark::kMicrosecond);

void Tessellating(benchmark::State& state) {
  const auto& voids = TestField().voids;
  for (auto _ : state) benchmark::DoNotOptimize(Tessellate(voids));
}
BENCHMARK(Tessellating)->Unit(benchmark::kMillisecond);

void BuildingTheCaster(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(RayCaster(Wall()));
}
BENCHMARK(BuildingTheCaster)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kantaro::sim
