#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/renderer.hpp"

namespace kantaro::sim {

/// Draws camera images on worker threads while the physics goes on. An image depends on its view,
/// its lamps and its noise seed alone, never on the thread or the order.
class CameraRig {
 public:
  /// @throws RenderingUnavailable. @throws std::invalid_argument for less than one thread.
  CameraRig(std::shared_ptr<const Scenery> scenery, int threads);
  ~CameraRig();
  CameraRig(const CameraRig&) = delete;
  CameraRig& operator=(const CameraRig&) = delete;

  /// @param noise_stream  names the sensor noise of this one image.
  [[nodiscard]] std::future<cv::Mat> Capture(const CameraView& view, const Lamps& lamps,
                                             std::uint64_t seed, const std::string& noise_stream);

 private:
  using Job = std::packaged_task<cv::Mat(Renderer&)>;
  void Work(Renderer& renderer);

  std::vector<std::unique_ptr<Renderer>> renderers_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::deque<Job> jobs_;
  bool closing_{};
  std::vector<std::jthread> threads_;
};

}  // namespace kantaro::sim
