#include "sim/camera_rig.hpp"

#include <stdexcept>

#include "base/random.hpp"
#include "sim/sensor_noise.hpp"

namespace kantaro::sim {

CameraRig::CameraRig(std::shared_ptr<const Scenery> scenery, int threads) {
  if (threads < 1) throw std::invalid_argument("cameras need at least one render thread");
  for (int i = 0; i < threads; ++i) renderers_.push_back(std::make_unique<Renderer>(scenery));
  for (const auto& renderer : renderers_)
    threads_.emplace_back([this, &renderer] { Work(*renderer); });
}

CameraRig::~CameraRig() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  work_.notify_all();
}

std::future<cv::Mat> CameraRig::Capture(const CameraView& view, const Lamps& lamps,
                                        std::uint64_t seed, const std::string& noise_stream) {
  Job job([view, lamps, seed, noise_stream](Renderer& renderer) {
    cv::Mat image = renderer.Render(view, lamps);
    RandomStream noise(seed, noise_stream);
    AddSensorNoise(image, noise);
    return image;
  });
  std::future<cv::Mat> image = job.get_future();
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  work_.notify_one();
  return image;
}

void CameraRig::Work(Renderer& renderer) {
  for (;;) {
    std::unique_lock lock(mutex_);
    work_.wait(lock, [this] { return closing_ || !jobs_.empty(); });
    if (closing_) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job(renderer);
  }
}

}  // namespace kantaro::sim
