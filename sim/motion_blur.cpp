#include "sim/motion_blur.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;

/// Pixels that are blurred alike, each way.
constexpr int kTile_px = 16;
/// Of the last pass' neighbours.
constexpr int kFarthest_px = 4;
/// The most variance that weights `apart` pixels apart give before they leave gaps [px²/apart²].
constexpr double kMost = 0.5;

/// What is added to a level of its second differences along x, y and a diagonal [1/2¹⁶].
struct Weights {
  std::int16_t x, y, diagonal;
  int side;  ///< of the diagonal: 1 if y grows along it with x, -1 if it falls
};

/// Those of the pass whose neighbours are `apart` pixels apart, if it has anything to do.
std::optional<Weights> WeightsOf(const Vector2d& way_px, int apart) {
  if (way_px.norm() < kUnseenBlur_px) return std::nullopt;
  const double whole = way_px.squaredNorm() / 12.0;
  // Passes before this one took kMost (1 + 4 + ... ) of it.
  const double left = whole - kMost * (apart * apart - 1) / 3.0;
  if (left <= 0.0) return std::nullopt;
  const double variance = std::min(left / (apart * apart), kMost);
  const Vector2d along = way_px.normalized();
  const double both = std::abs(along.x() * along.y());
  const auto weight = [&](double share) {
    return static_cast<std::int16_t>(std::lround(65536.0 * 0.5 * variance * share));
  };
  return Weights{weight(along.x() * along.x() - both), weight(along.y() * along.y() - both),
                 weight(both), along.x() * along.y() < 0.0 ? -1 : 1};
}

/// The upper half of the product: processors have it for eight numbers at once.
std::int16_t High(std::int16_t a, std::int16_t b) {
  return static_cast<std::int16_t>((static_cast<std::int32_t>(a) * b) >> 16);
}

/// @param from  the first value; @param row, step  to the next row's and to the next pixel's.
void BlurRow(const std::uint8_t* from, std::ptrdiff_t row, std::ptrdiff_t step, int count,
             const Weights& weights, std::uint8_t* __restrict to) {
  const std::uint8_t *left = from - step, *right = from + step, *up = from - row,
                     *down = from + row;
  const std::ptrdiff_t corner = row + weights.side * step;
  const std::uint8_t *before = from - corner, *after = from + corner;
  const Weights w = weights;
  for (int i = 0; i < count; ++i) {
    const int twice = 2 * from[i];
    const auto curve = [twice](int a, int b) {
      return static_cast<std::int16_t>((a + b - twice) * 32);
    };
    const int added = High(curve(left[i], right[i]), w.x) + High(curve(up[i], down[i]), w.y) +
                      High(curve(before[i], after[i]), w.diagonal);
    // In 1/32 levels: 16 rounds, and what three upper halves lack on average is 1.5.
    to[i] = static_cast<std::uint8_t>(std::clamp(from[i] + ((added + 17) >> 5), 0, 255));
  }
}

}  // namespace

const cv::Mat& MotionBlur::Apply(const cv::Mat& sharp, const MotionField& field,
                                 double exposure_s) {
  const double most_px = field.Fastest() * exposure_s;
  if (most_px < kUnseenBlur_px) return sharp;
  // No lens looks at the rim.
  constexpr int kRim_px = LensMap::kBlurMargin_px;
  static_assert(kRim_px >= kFarthest_px);
  const cv::Rect inner(kRim_px, kRim_px, sharp.cols - 2 * kRim_px, sharp.rows - 2 * kRim_px);
  for (int apart = 1; apart <= kFarthest_px && WeightsOf({most_px, 0.0}, apart); apart *= 2) {
    if (apart > 1) blurred_.copyTo(before_);
    const cv::Mat& before = apart > 1 ? before_ : sharp;
    before.copyTo(blurred_);
    for (int top = 0; top < sharp.rows; top += kTile_px) {
      for (int left = 0; left < sharp.cols; left += kTile_px) {
        const Vector2d middle(left + kTile_px / 2, top + kTile_px / 2);
        const auto weights = WeightsOf(exposure_s * field.At(middle), apart);
        if (!weights) continue;
        const cv::Rect tile = cv::Rect(left, top, kTile_px, kTile_px) & inner;
        for (int row = tile.y; row < tile.y + tile.height; ++row) {
          BlurRow(before.ptr<std::uint8_t>(row) + 3 * tile.x,
                  apart * static_cast<std::ptrdiff_t>(before.step), 3 * apart, 3 * tile.width,
                  *weights, blurred_.ptr<std::uint8_t>(row) + 3 * tile.x);
        }
      }
    }
  }
  return blurred_;
}

}  // namespace kantaro::sim
