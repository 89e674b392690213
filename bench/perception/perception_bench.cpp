// What one front image costs: 704 x 480, one thread. The camera delivers five a second.

#include <benchmark/benchmark.h>

#include <string>

#include "perception/brightness.hpp"
#include "perception/fault_detector.hpp"
#include "perception/parameters.hpp"
#include "perception/ring_finder.hpp"
#include "tests/perception/pipe_view.hpp"

namespace kantaro::perception {
namespace {

Parameters Shipped() {
  return ReadParameters(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/perception.yaml");
}

cv::Mat View() {
  return Draw({.joints = {{.distance_m = 0.5}},
               .mouth_m = 0.9,
               .cracks = {{.clock_h = 3.0, .near_m = 0.60, .far_m = 0.70}}});
}

void BrightnessOfAFrontImage(benchmark::State& state) {
  const cv::Mat image = View();
  for (auto _ : state) benchmark::DoNotOptimize(Brightness(image));
}
BENCHMARK(BrightnessOfAFrontImage)->Unit(benchmark::kMillisecond);

void RingsOfAFrontImage(benchmark::State& state) {
  const cv::Mat brightness = Brightness(View());
  const RingFinder finder(FrontCamera(), 0.150, Shipped().rings);
  for (auto _ : state) benchmark::DoNotOptimize(finder.Find(brightness));
}
BENCHMARK(RingsOfAFrontImage)->Unit(benchmark::kMillisecond);

void FaultsOfAFrontImage(benchmark::State& state) {
  const cv::Mat brightness = Brightness(View());
  const FaultParameters parameters = Shipped().faults;
  const robot::Camera camera = FrontCamera();
  const Ring ring = FaultRing(camera, 0.300, {camera.center_x_px, camera.center_y_px}, parameters);
  for (auto _ : state) {
    benchmark::DoNotOptimize(FindFaults(brightness, ring, camera.focal_px, 0.300, {}, parameters));
  }
}
BENCHMARK(FaultsOfAFrontImage)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kantaro::perception
