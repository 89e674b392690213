#include "robot/device/image_pipe.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "robot/device/matroska.hpp"

namespace kantaro::robot {
namespace {

constexpr std::size_t kMostQueued = 8;
/// FFmpeg looks at 5 MB and at a frame more before it calls a stream known.
constexpr std::size_t kProbed = 5'000'000;
constexpr int kLookAgain_ms = 20;

}  // namespace

ImagePipe::ImagePipe(std::filesystem::path file, cv::Size size, RunTime period)
    : file_(std::move(file)), size_(size), period_(period) {
  unlink(file_.c_str());
  if (mkfifo(file_.c_str(), 0600) != 0) {
    throw std::system_error(errno, std::generic_category(),
                            "no pipe can be made at " + file_.string());
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Work(stop); });
}

ImagePipe::~ImagePipe() {
  thread_.request_stop();
  thread_.join();
  unlink(file_.c_str());
}

void ImagePipe::Serve(const cv::Mat& image, RunTime stamp) {
  if (image.size() != size_ || image.type() != CV_8UC3) {
    throw std::invalid_argument("the image is not the camera's");
  }
  const std::scoped_lock lock(mutex_);
  if (queue_.size() == kMostQueued) queue_.pop_front();
  queue_.push_back(MatroskaImage(image, stamp));
  changed_.notify_one();
}

void ImagePipe::Close() {
  const std::scoped_lock lock(mutex_);
  closing_ = true;
  changed_.notify_one();
}

void ImagePipe::Work(const std::stop_token& stop) {
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);  // a reader that leaves ends this stream only

  const int descriptor = WaitForReader(stop);
  if (descriptor < 0) return;
  bool read = WriteAll(descriptor, MatroskaHead(size_.width, size_.height, period_), stop);
  const cv::Mat black = cv::Mat::zeros(size_, CV_8UC3);
  const std::size_t images = kProbed / (black.total() * black.elemSize()) + 2;
  for (std::size_t i = 0; read && i < images; ++i) {
    read = WriteAll(descriptor, MatroskaImage(black, std::chrono::microseconds(i)), stop);
  }
  while (read && !stop.stop_requested()) {
    wire::Bytes next;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return closing_ || !queue_.empty(); });
      if (queue_.empty()) break;
      next = std::move(queue_.front());
      queue_.pop_front();
    }
    read = WriteAll(descriptor, next, stop);
  }
  close(descriptor);
}

int ImagePipe::WaitForReader(const std::stop_token& stop) const {
  while (!stop.stop_requested()) {
    const int descriptor = open(file_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor >= 0) return descriptor;
    poll(nullptr, 0, kLookAgain_ms);
  }
  return -1;
}

bool ImagePipe::WriteAll(int descriptor, const wire::Bytes& bytes, const std::stop_token& stop) {
  std::size_t sent = 0;
  while (sent < bytes.size() && !stop.stop_requested()) {
    const ssize_t took = write(descriptor, bytes.data() + sent, bytes.size() - sent);
    if (took > 0) {
      sent += static_cast<std::size_t>(took);
    } else if (errno == EAGAIN) {
      pollfd wait{descriptor, POLLOUT, 0};
      poll(&wait, 1, kLookAgain_ms);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return sent == bytes.size();
}

}  // namespace kantaro::robot
