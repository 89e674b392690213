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

#include "sim/imager.hpp"
#include "sim/renderer.hpp"

namespace kantaro::sim {

/// One exposure of one camera.
struct Shot {
  std::shared_ptr<const Imager> imager;
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< in its middle
  CameraMotion motion;
  Lamps lamps;
  std::uint64_t seed{};
  std::string noise_stream;  ///< names the sensor noise of this one image
};

/// Takes camera images on worker threads while the physics goes on, or at once. An image depends on
/// its shot alone, never on the thread or the order.
class CameraRig {
 public:
  /// @param rays  tell how far the walls are, for the blur of motion.
  /// @param largest  ideal picture that any shot will ask for.
  /// @param threads  beside the caller's; 0: Capture() takes the picture before it returns.
  /// @throws RenderingUnavailable. @throws std::invalid_argument for less than none.
  CameraRig(std::shared_ptr<const Scenery> scenery, std::shared_ptr<const RayCaster> rays,
            cv::Size largest, int threads);
  ~CameraRig();
  CameraRig(const CameraRig&) = delete;
  CameraRig& operator=(const CameraRig&) = delete;

  [[nodiscard]] std::future<cv::Mat> Capture(Shot shot);

 private:
  using Job = std::packaged_task<cv::Mat(Renderer&, Imager::Scratch&)>;
  void Work(Renderer& renderer);

  std::shared_ptr<const RayCaster> rays_;
  std::vector<std::unique_ptr<Renderer>> renderers_;
  Imager::Scratch scratch_;  ///< where there are no threads
  std::mutex mutex_;
  std::condition_variable work_;
  std::deque<Job> jobs_;
  bool closing_{};
  std::vector<std::jthread> threads_;
};

}  // namespace kantaro::sim
