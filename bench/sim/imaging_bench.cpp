// What the way from the renderer's picture to the camera's costs: process CPU time, as OpenCV may
// use threads of its own.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>

#include "robot/description.hpp"
#include "robot/rectifier.hpp"
#include "sim/imager.hpp"
#include "sim/surface_mesh.hpp"

namespace {

using namespace kantaro;
using Eigen::Vector3d;

const robot::Description& Robot() {
  static const robot::Description robot =
      robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  return robot;
}

sim::RayCaster Pipe() {
  sim::VoidPrimitive pipe;
  pipe.length_m = 8.0;
  pipe.radius_m = 0.150;
  return sim::RayCaster(sim::Tessellate(std::span(&pipe, 1)));
}

/// @param state  range: 0 standing, 1 at 12 cm/s, 2 turning at 0.5 rad/s too.
void Expose(benchmark::State& state, const robot::Camera& camera) {
  const sim::Imager imager(camera);
  const sim::RayCaster rays = Pipe();
  cv::Mat ideal(imager.lens().ideal().height_px, imager.lens().ideal().width_px, CV_8UC3);
  cv::theRNG().state = 1;
  cv::randu(ideal, 30, 180);
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation().x() = 1.0;
  sim::CameraMotion motion;
  if (state.range(0) > 0) motion.velocity_C.z() = 0.12;
  if (state.range(0) > 1) motion.angular_velocity_C.y() = 0.5;
  RandomStream noise(1, "bench");
  sim::Imager::Scratch scratch;
  for (auto _ : state) {
    const sim::MotionField field(imager.lens(), rays, X_WC, motion);
    benchmark::DoNotOptimize(imager.Expose(ideal, field, noise, scratch).data);
  }
}

void ExposeStereo(benchmark::State& state) { Expose(state, Robot().stereo_left); }
void ExposeFront(benchmark::State& state) { Expose(state, Robot().front_camera); }
BENCHMARK(ExposeStereo)->DenseRange(0, 2)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ExposeFront)->DenseRange(0, 2)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

void RectifyFront(benchmark::State& state) {
  const robot::Rectifier rectifier(Robot().front_camera, robot::FrontRectification(Robot()));
  const cv::Mat image(480, 704, CV_8UC1, cv::Scalar(90));
  for (auto _ : state) benchmark::DoNotOptimize(rectifier.Rectify(image).data);
}
BENCHMARK(RectifyFront)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
