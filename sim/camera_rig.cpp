#include "sim/camera_rig.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/random.hpp"

namespace kantaro::sim {
namespace {

cv::Mat Take(const Shot& shot, const RayCaster& rays, Renderer& renderer,
             Imager::Scratch& scratch) {
  const LensMap& lens = shot.imager->lens();
  CameraView view = lens.ideal();
  view.X_WC = shot.X_WC;
  const MotionField field(lens, rays, shot.X_WC, shot.motion);
  RandomStream noise(shot.seed, shot.noise_stream);
  return shot.imager->Expose(renderer.Render(view, shot.lamps), field, noise, scratch);
}

}  // namespace

CameraRig::CameraRig(std::shared_ptr<const Scenery> scenery, std::shared_ptr<const RayCaster> rays,
                     cv::Size largest, int threads)
    : rays_(std::move(rays)) {
  if (threads < 0) throw std::invalid_argument("less than no render thread");
  const RendererOptions options{largest.width, largest.height};
  for (int i = 0; i < std::max(1, threads); ++i)
    renderers_.push_back(std::make_unique<Renderer>(scenery, options));
  for (const auto& renderer : renderers_) {
    if (threads == 0) break;
    threads_.emplace_back([this, &renderer] { Work(*renderer); });
  }
}

CameraRig::~CameraRig() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  work_.notify_all();
}

std::future<cv::Mat> CameraRig::Capture(Shot shot) {
  Job job([this, shot = std::move(shot)](Renderer& renderer, Imager::Scratch& scratch) {
    return Take(shot, *rays_, renderer, scratch);
  });
  std::future<cv::Mat> image = job.get_future();
  if (threads_.empty()) {
    job(*renderers_.front(), scratch_);
    return image;
  }
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  work_.notify_one();
  return image;
}

void CameraRig::Work(Renderer& renderer) {
  Imager::Scratch scratch;
  for (;;) {
    std::unique_lock lock(mutex_);
    work_.wait(lock, [this] { return closing_ || !jobs_.empty(); });
    if (closing_) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job(renderer, scratch);
  }
}

}  // namespace kantaro::sim
