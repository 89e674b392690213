#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// Finds the trigger of each image. The controller tells when it triggered a camera; the image
/// comes another way, with a stamp of its own (of exposure or read-out) or none, and each may be
/// first.
class ImageMatcher {
 public:
  /// @param images  that one trigger exposes: 1, or 2 for a stereo pair. @param period  of
  /// triggers.
  ImageMatcher(std::size_t images, RunTime period) : period_(period), open_images_(images) {}

  struct Match {
    RunTime captured_at{};        ///< when the camera was triggered
    std::uint32_t lost_before{};  ///< triggers since the last match that left no image
    std::array<cv::Mat, 2> images;
  };

  void Trigger(std::uint32_t frame, RunTime at);
  /// @param stamp  on the run's clock; absent: the oldest trigger that has no such image yet.
  void Image(std::size_t which, cv::Mat image, std::optional<RunTime> stamp);
  /// The oldest trigger all of whose images are there.
  [[nodiscard]] std::optional<Match> Take();

 private:
  struct Triggered {
    std::uint32_t frame{};
    RunTime at{};
    std::array<cv::Mat, 2> images;
  };
  struct Waiting {
    cv::Mat image;
    std::optional<RunTime> stamp;
  };
  [[nodiscard]] bool Place(std::size_t which, const Waiting& waiting);
  [[nodiscard]] bool Complete(const Triggered& triggered) const;

  RunTime period_;
  std::vector<std::deque<Waiting>> open_images_;  ///< without a trigger yet, by camera
  std::deque<Triggered> triggers_;
  std::optional<std::uint32_t> matched_;
};

}  // namespace kantaro::robot
