#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <thread>

#include "robot/device/frame.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// The far end of a camera that is played: a named pipe out of which VideoCapture reads images.
///
/// VideoCapture looks at the first megabytes of a stream before it hands on any image, so the
/// stream begins with some black images, stamped before the first millisecond.
class ImagePipe {
 public:
  /// Makes the pipe. @throws std::system_error if it cannot be made.
  ImagePipe(std::filesystem::path file, cv::Size size, RunTime period);
  ~ImagePipe();
  ImagePipe(const ImagePipe&) = delete;
  ImagePipe& operator=(const ImagePipe&) = delete;

  /// Queues an image of the pipe's size; if nobody reads, the oldest in the queue is dropped.
  void Serve(const cv::Mat& image, RunTime stamp);
  /// The stream ends here.
  void Close();

 private:
  void Work(const std::stop_token& stop);
  [[nodiscard]] int WaitForReader(const std::stop_token& stop) const;
  [[nodiscard]] static bool WriteAll(int descriptor, const wire::Bytes& bytes,
                                     const std::stop_token& stop);

  std::filesystem::path file_;
  cv::Size size_;
  RunTime period_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<wire::Bytes> queue_;
  bool closing_{};
  std::jthread thread_;
};

}  // namespace kantaro::robot
