#include "robot/device/image_matcher.hpp"

#include <algorithm>
#include <utility>

namespace kantaro::robot {
namespace {

/// Triggers and images that wait for each other; what is older is given up.
constexpr std::size_t kMostWaiting = 16;

}  // namespace

void ImageMatcher::Trigger(std::uint32_t frame, RunTime at) {
  if (!triggers_.empty() && frame <= triggers_.back().frame) return;
  triggers_.push_back({frame, at, {}});
  if (triggers_.size() > kMostWaiting) triggers_.pop_front();
  for (std::size_t which = 0; which < open_images_.size(); ++which) {
    auto& waiting = open_images_[which];
    while (!waiting.empty() && Place(which, waiting.front())) waiting.pop_front();
  }
}

void ImageMatcher::Image(std::size_t which, cv::Mat image, std::optional<RunTime> stamp) {
  Waiting waiting{std::move(image), stamp};
  if (Place(which, waiting)) return;
  open_images_[which].push_back(std::move(waiting));
  if (open_images_[which].size() > kMostWaiting) open_images_[which].pop_front();
}

bool ImageMatcher::Place(std::size_t which, const Waiting& waiting) {
  // A stamp may be a little early, for clocks are mapped by frames that took some time, or late by
  // exposure and read-out.
  const RunTime early = period_ / 4;
  const auto is_of = [&](const Triggered& triggered) {
    if (!triggered.images[which].empty()) return false;
    if (!waiting.stamp) return true;
    const RunTime after = *waiting.stamp - triggered.at;
    return after >= -early && after < period_ - early;
  };
  const auto found = std::find_if(triggers_.begin(), triggers_.end(), is_of);
  if (found == triggers_.end()) {
    // An image from before every trigger that is known will not find one any more.
    return waiting.stamp && !triggers_.empty() && *waiting.stamp < triggers_.front().at - early;
  }
  found->images[which] = waiting.image;
  return true;
}

bool ImageMatcher::Complete(const Triggered& triggered) const {
  return std::none_of(triggered.images.begin(),
                      triggered.images.begin() + static_cast<long>(open_images_.size()),
                      [](const cv::Mat& image) { return image.empty(); });
}

std::optional<ImageMatcher::Match> ImageMatcher::Take() {
  const auto complete =
      std::find_if(triggers_.begin(), triggers_.end(),
                   [&](const Triggered& triggered) { return Complete(triggered); });
  if (complete == triggers_.end()) return std::nullopt;
  Match match{complete->at, matched_ ? complete->frame - *matched_ - 1 : 0,
              std::move(complete->images)};
  matched_ = complete->frame;
  triggers_.erase(triggers_.begin(), complete + 1);
  return match;
}

}  // namespace kantaro::robot
