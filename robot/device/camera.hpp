#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <variant>
#include <vector>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// A Video4Linux number, or a file or named pipe.
using CameraSource = std::variant<int, std::filesystem::path>;

/// An image and its stamp as the source tells it: a Video4Linux camera's is the host's monotonic
/// clock, a stream's is its own.
struct StampedImage {
  cv::Mat image;
  RunTime stamp{};
};

/// Images of one camera, as OpenCV's VideoCapture hands them over, read on a thread.
class CameraReader {
 public:
  /// Begins to open the source, which may take long.
  /// @param wake  an eventfd that is written when there is something new; it must outlive this.
  CameraReader(CameraSource source, int wake);
  /// Waits for a read that goes on, but not for ever: one that never ends keeps its thread.
  ~CameraReader();
  CameraReader(const CameraReader&) = delete;
  CameraReader& operator=(const CameraReader&) = delete;

  enum class State { kOpening, kOpen, kEnded, kUnusable };
  [[nodiscard]] State state() const;
  /// Images that came since the last call.
  [[nodiscard]] std::vector<StampedImage> Take();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace kantaro::robot
