// What a 640 x 480 picture costs, lamps and all, in processor time of every thread that works on
// it: what one idle core would take. Views down each pipe that the robot can enter, from half a
// metre to half a metre, both ways; each view counts by the median of its turns. The aim is 15 ms
// for any of them.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "network/formats.hpp"
#include "sim/renderer.hpp"
#include "sim/robot_model.hpp"
#include "sim/twin.hpp"

namespace kantaro::sim {
namespace {

const std::filesystem::path kRoot = KANTARO_SOURCE_DIR;
constexpr double kEvery_m = 0.5;
constexpr int kTurns = 5;

const robot::Description& Robot() {
  static const robot::Description description = robot::ReadDescription(kRoot / "models/kantaro");
  return description;
}

struct Shot {
  CameraView view;
  Lamps lamps;
};

/// What the left stereo camera sees of a robot on the pipe's axis.
Shot Aim(const Sewer& sewer, std::size_t pipe, double chainage_m, bool downstream) {
  const robot::Camera& camera = Robot().stereo_left;
  const double mast_m = Robot().MastHeight(sewer.network.pipes[pipe].diameter_m);
  Eigen::Isometry3d X_WB = sewer.axes[pipe].PoseAt(chainage_m);
  if (!downstream) X_WB.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  Shot shot{{X_WB * MountPose(Robot(), camera.link, mast_m), camera.width_px, camera.height_px,
             camera.focal_px, camera.center_x_px, camera.center_y_px},
            {}};
  for (const std::string& light : Robot().lights) {
    shot.lamps.p_WLamp.push_back((X_WB * MountPose(Robot(), light, mast_m)).translation());
  }
  shot.lamps.direction_W = X_WB.linear().col(0);
  return shot;
}

double Frame_ms(Renderer& renderer, const Shot& shot) {
  std::vector<double> turns_ms;
  for (int i = 0; i < kTurns; ++i) {
    const std::clock_t began = std::clock();
    benchmark::DoNotOptimize(renderer.Render(shot.view, shot.lamps));
    turns_ms.push_back(1e3 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  }
  std::nth_element(turns_ms.begin(), turns_ms.begin() + kTurns / 2, turns_ms.end());
  return turns_ms[kTurns / 2];
}

void Network(benchmark::State& state, const std::string& name) {
  const World world =
      BuildWorld(network::ReadNetwork(kRoot / "models/networks" / (name + ".yaml")), 1, true);
  Renderer renderer(world.scenery, {640, 480});
  std::vector<double> frames_ms;
  std::string worst;
  for (auto _ : state) {
    for (std::size_t pipe = 0; pipe < world.sewer->network.pipes.size(); ++pipe) {
      if (!network::IsEnterable(world.sewer->network.pipes[pipe])) continue;
      const double length_m = world.sewer->axes[pipe].length_m();
      for (double chainage_m = 0.3; chainage_m < length_m - 0.3; chainage_m += kEvery_m) {
        for (const bool downstream : {true, false}) {
          const double frame_ms =
              Frame_ms(renderer, Aim(*world.sewer, pipe, chainage_m, downstream));
          if (frames_ms.empty() || frame_ms > *std::max_element(frames_ms.begin(), frames_ms.end()))
            worst = world.sewer->network.pipes[pipe].name + (downstream ? " down at " : " up at ") +
                    std::to_string(chainage_m);
          frames_ms.push_back(frame_ms);
        }
      }
    }
  }
  std::sort(frames_ms.begin(), frames_ms.end());
  state.counters["views"] = static_cast<double>(frames_ms.size());
  state.counters["median_ms"] = frames_ms[frames_ms.size() / 2];
  state.counters["p95_ms"] = frames_ms[frames_ms.size() * 95 / 100];
  state.counters["worst_ms"] = frames_ms.back();
  state.SetLabel("worst: " + worst);
}
BENCHMARK_CAPTURE(Network, test_field, "test_field")->Iterations(1);
BENCHMARK_CAPTURE(Network, every_element, "every_element")->Iterations(1);

}  // namespace
}  // namespace kantaro::sim
