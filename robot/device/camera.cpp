#include "robot/device/camera.hpp"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <thread>
#include <utility>

namespace kantaro::robot {
namespace {

/// A live camera's oldest image is of no use to a host that cannot keep up.
constexpr std::size_t kMostWaiting = 32;
constexpr auto kLongestGoodbye = std::chrono::seconds(2);

}  // namespace

/// Owned by the reader and its thread: the thread may outlive the reader in a read that never ends.
struct CameraReader::Shared {
  CameraSource source;
  int wake;
  std::mutex mutex;
  std::condition_variable ended;
  State state{State::kOpening};
  std::deque<StampedImage> images;
  bool leaving{};

  void Tell(State now_in) {
    const std::scoped_lock lock(mutex);
    state = now_in;
    Wake();
    ended.notify_all();
  }
  void Wake() const {
    const std::uint64_t one = 1;
    if (!leaving) static_cast<void>(write(wake, &one, sizeof one));
  }
  bool Open(cv::VideoCapture& capture) const {
    if (const int* number = std::get_if<int>(&source)) return capture.open(*number, cv::CAP_V4L2);
    return capture.open(std::get<std::filesystem::path>(source).string(), cv::CAP_FFMPEG);
  }
  void Run() {
    cv::VideoCapture capture;
    if (!Open(capture)) return Tell(State::kUnusable);
    Tell(State::kOpen);
    for (;;) {
      cv::Mat image;  // a new one: the last is in the reader's hands
      const bool came = capture.read(image);
      const RunTime stamp(std::llround(capture.get(cv::CAP_PROP_POS_MSEC) * 1e6));
      const std::unique_lock lock(mutex);
      if (!came || leaving) break;
      if (images.size() == kMostWaiting) images.pop_front();
      images.push_back({std::move(image), stamp});
      Wake();
    }
    Tell(State::kEnded);
  }
};

CameraReader::CameraReader(CameraSource source, int wake) : shared_(std::make_shared<Shared>()) {
  shared_->source = std::move(source);
  shared_->wake = wake;
  std::thread([shared = shared_] { shared->Run(); }).detach();
}

CameraReader::~CameraReader() {
  std::unique_lock lock(shared_->mutex);
  shared_->leaving = true;
  shared_->ended.wait_for(lock, kLongestGoodbye, [&] {
    return shared_->state == State::kEnded || shared_->state == State::kUnusable;
  });
}

CameraReader::State CameraReader::state() const {
  const std::scoped_lock lock(shared_->mutex);
  return shared_->images.empty() || shared_->state != State::kEnded ? shared_->state : State::kOpen;
}

std::vector<StampedImage> CameraReader::Take() {
  const std::scoped_lock lock(shared_->mutex);
  std::vector<StampedImage> images(std::make_move_iterator(shared_->images.begin()),
                                   std::make_move_iterator(shared_->images.end()));
  shared_->images.clear();
  return images;
}

}  // namespace kantaro::robot
