#include "perception/stereo/fast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

#include "perception/stereo/window_matching.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr int kLanes = 8;        ///< 16-bit numbers of a vector
constexpr int kDisparities = 4;  ///< that are correlated at once

/// The rows of the right image that one row of corners looks at, and the sums of its windows.
class RightBand {
 public:
  explicit RightBand(const Frame& frame)
      : frame_(frame),
        stride_(frame.right.cols + 4 * kLanes),
        pixels_(static_cast<std::size_t>(frame.parameters.window_px) * stride_),
        sums_(frame.right.cols),
        squares_(frame.right.cols),
        weights_(frame.right.cols) {}

  void Move(int y) {
    const int width = frame_.right.cols;
    column_sums_.assign(width, 0);
    column_squares_.assign(width, 0);
    for (int j = 0; j < frame_.parameters.window_px; ++j) {
      const std::uint8_t* const in = frame_.right.ptr(y - frame_.radius + j);
      std::int16_t* const out = pixels_.data() + j * stride_;
      std::int32_t* const sum = column_sums_.data();
      std::int32_t* const square = column_squares_.data();
      for (int x = 0; x < width; ++x) {
        out[x] = in[x];
        sum[x] += in[x];
        square[x] += in[x] * in[x];
      }
    }
    Slide(column_sums_, sums_);
    Slide(column_squares_, squares_);
    for (int x = 0; x < width; ++x) {
      const auto spread = static_cast<float>(frame_.area * squares_[x] - sums_[x] * sums_[x]);
      weights_[x] = 1.0F / std::sqrt(std::max(spread, 1.0F));
    }
  }

  /// Pixels from a column on, of the window's row j.
  [[nodiscard]] const std::int16_t* Pixels(int j, int x) const {
    return pixels_.data() + j * stride_ + x;
  }
  /// Of the window around each column: Σ R, Σ R² and 1 / √(area Σ R² − (Σ R)²), 1 for a flat one.
  [[nodiscard]] const std::int32_t* Sums(int x) const { return sums_.data() + x; }
  [[nodiscard]] const std::int32_t* Squares(int x) const { return squares_.data() + x; }
  [[nodiscard]] const float* Weights(int x) const { return weights_.data() + x; }

 private:
  void Slide(const std::vector<std::int32_t>& columns, std::vector<std::int32_t>& windows) const {
    const int radius = frame_.radius, width = frame_.right.cols;
    std::int32_t sum = 0;
    for (int x = 0; x < 2 * radius; ++x) sum += columns[x];
    for (int x = radius; x < width - radius; ++x) {
      sum += columns[x + radius];
      windows[x] = sum;
      sum -= columns[x - radius];
    }
  }

  const Frame& frame_;
  int stride_;
  std::vector<std::int16_t> pixels_;
  std::vector<std::int32_t> column_sums_, column_squares_, sums_, squares_;
  std::vector<float> weights_;
};

/// The left window of a corner. Its rows are filled up with zeros, which add nothing to a product.
struct LeftWindow {
  std::array<std::int16_t, kMaxWindow_px * 2 * kLanes> pixels{};
  std::int32_t sum{}, squares{}, spread{};
  float weight{};

  /// @tparam kVectors  that hold a row
  template <int kVectors>
  void Move(const Frame& frame, int x, int y) {
    sum = squares = 0;
    for (int j = 0; j < frame.parameters.window_px; ++j) {
      const std::uint8_t* const in = frame.left.ptr(y - frame.radius + j) + x - frame.radius;
      for (int i = 0; i < frame.parameters.window_px; ++i) {
        pixels[j * kVectors * kLanes + i] = in[i];
        sum += in[i];
        squares += in[i] * in[i];
      }
    }
    spread = frame.area * squares - sum * sum;
    weight = 1.0F / std::sqrt(std::max(static_cast<float>(spread), 1.0F));
  }
};

/// The largest of what it is offered; of equals the last.
struct Peak {
  float value{-std::numeric_limits<float>::infinity()};
  int at{};
  void Offer(float candidate, int index) {
    if (candidate >= value) {
      value = candidate;
      at = index;
    }
  }
};

class CornerMatcher {
 public:
  explicit CornerMatcher(const Frame& frame)
      : frame_(frame),
        band_(frame),
        products_(frame.parameters.disparities + kDisparities),
        ssd_(products_.size()),
        correlation_(products_.size()),
        combined_(products_.size()) {
    const Parameters& p = frame.parameters;
    const double least = p.least_deviation * frame.area;
    least_spread_ = std::max(1.0, least * least);
    ssd_share_ = static_cast<float>(1.0 / (frame.area * p.ssd_scale * p.ssd_scale));
  }

  template <int kVectors>
  void Row(int y, float* out, int count) {
    band_.Move(y);
    for (int corner = 0; corner < count; ++corner) {
      const int x = std::clamp(corner * kBlock_px, frame_.radius, frame_.end_column - 1);
      out[corner] = kNone;
      if (x < frame_.first_column) continue;
      window_.Move<kVectors>(frame_, x, y);
      if (window_.spread < least_spread_) continue;
      Correlate<kVectors>(x);
      out[corner] = Best(x, y);
    }
  }

 private:
  // Candidates stand in the order of the right image's columns, so the last is the least disparity.

  /// Σ L R for each candidate.
  template <int kVectors>
  void Correlate(int x) {
    const int first = x - frame_.max_disparity - frame_.radius;
    for (int k = 0; k < frame_.parameters.disparities; k += kDisparities) {
      std::array<cv::v_int32x4, kDisparities> sums{cv::v_setzero_s32(), cv::v_setzero_s32(),
                                                   cv::v_setzero_s32(), cv::v_setzero_s32()};
      for (int j = 0; j < frame_.parameters.window_px; ++j) {
        for (int v = 0; v < kVectors; ++v) {
          const cv::v_int16x8 left = cv::v_load(&window_.pixels[(j * kVectors + v) * kLanes]);
          const std::int16_t* const right = band_.Pixels(j, first + k + v * kLanes);
          for (int n = 0; n < kDisparities; ++n)
            sums[n] = cv::v_dotprod(left, cv::v_load(right + n), sums[n]);
        }
      }
      cv::v_int32x4 a, b, c, d;
      cv::v_transpose4x4(sums[0], sums[1], sums[2], sums[3], a, b, c, d);
      cv::v_store(&products_[k], a + b + c + d);
    }
  }

  /// Com_d's maximum, or the mean of SSD′_d's and Cor_d's (eq. 5.12).
  float Best(int x, int y) {
    const Parameters& p = frame_.parameters;
    const int count = p.disparities, first = x - frame_.max_disparity;
    const std::uint8_t* const row = frame_.left.ptr(y);
    const auto omega = static_cast<float>(std::abs(row[x] - row[x - 1]) / p.gradient_scale);
    const float omega_weight = window_.weight * omega;
    const std::int32_t* const sums = band_.Sums(first);
    const std::int32_t* const squares = band_.Squares(first);
    const float* const weights = band_.Weights(first);
    for (int k = 0; k < count; ++k) {
      const std::int32_t ssd = window_.squares + squares[k] - 2 * products_[k];
      const auto covariance =
          static_cast<float>(frame_.area * products_[k] - window_.sum * sums[k]);
      ssd_[k] = -ssd_share_ * static_cast<float>(ssd);
      correlation_[k] = omega_weight * (covariance * weights[k]);
      combined_[k] = ssd_[k] + correlation_[k];
    }
    if (p.corner_disparity == CornerDisparity::kCombined) return DisparityAtPeak(combined_);
    if (omega == 0) return DisparityAtPeak(ssd_);
    return (DisparityAtPeak(ssd_) + omega * DisparityAtPeak(correlation_)) / (1 + omega);
  }

  [[nodiscard]] float DisparityAtPeak(const std::vector<float>& measure) const {
    const int count = frame_.parameters.disparities;
    Peak peak;
    for (int k = 0; k < count; ++k) peak.Offer(measure[k], k);
    double position = peak.at;
    if (frame_.parameters.subpixel && peak.at > 0 && peak.at + 1 < count)
      position += ParabolaOffset(-measure[peak.at - 1], -peak.value, -measure[peak.at + 1]);
    return static_cast<float>(frame_.max_disparity - position);
  }

  const Frame& frame_;
  RightBand band_;
  LeftWindow window_;
  std::vector<std::int32_t> products_;
  std::vector<float> ssd_, correlation_, combined_;
  double least_spread_{};
  float ssd_share_{};
};

/// One of each two opposite neighbours; distance in blocks.
struct Neighbour {
  int right, down;
  float distance;
};
constexpr float kDiagonal = std::numbers::sqrt2_v<float>;
constexpr std::array<Neighbour, 4> kNeighbours{
    {{1, 0, 1.0F}, {0, 1, 1.0F}, {1, 1, kDiagonal}, {1, -1, kDiagonal}}};

float SteepestPerBlock(const Parameters& parameters) {
  return static_cast<float>(kBlock_px * parameters.steepest_wall);
}

/// With one more corner on each side, so that all have eight neighbours.
cv::Mat Framed(const cv::Mat& corners, int border) {
  cv::Mat framed;
  cv::copyMakeBorder(corners, framed, 1, 1, 1, 1, border | cv::BORDER_ISOLATED, cv::Scalar(kNone));
  return framed;
}

std::array<float, 2> Opposite(const cv::Mat& framed, int x, int y, const Neighbour& to) {
  return {framed.at<float>(y + 1 + to.down, x + 1 + to.right),
          framed.at<float>(y + 1 - to.down, x + 1 - to.right)};
}

}  // namespace

cv::Mat MatchCorners(const Frame& frame) {
  cv::Mat corners(CornersAlong(frame.left.rows), CornersAlong(frame.left.cols), CV_32F);
  CornerMatcher matcher(frame);
  for (int row = 0; row < corners.rows; ++row) {
    const int y = std::clamp(row * kBlock_px, frame.radius, frame.left.rows - 1 - frame.radius);
    if (frame.parameters.window_px <= kLanes) {
      matcher.Row<1>(y, corners.ptr<float>(row), corners.cols);
    } else {
      matcher.Row<2>(y, corners.ptr<float>(row), corners.cols);
    }
  }
  return corners;
}

cv::Mat KeepSupported(const cv::Mat& corners, const Parameters& parameters) {
  const cv::Mat framed = Framed(corners, cv::BORDER_REFLECT_101);
  const float steepest = SteepestPerBlock(parameters);
  cv::Mat kept = corners.clone();
  for (int y = 0; y < kept.rows; ++y) {
    for (int x = 0; x < kept.cols; ++x) {
      float& corner = kept.at<float>(y, x);
      int support = 0;
      for (const Neighbour& to : kNeighbours) {
        const float most = to.distance * steepest;
        for (const float neighbour : Opposite(framed, x, y, to))
          support += std::abs(neighbour - corner) <= most ? 1 : 0;
      }
      if (support < parameters.corner_support) corner = kNone;
    }
  }
  return kept;
}

cv::Mat Bridge(const cv::Mat& corners, const Parameters& parameters) {
  const cv::Mat framed = Framed(corners, cv::BORDER_CONSTANT);
  const float steepest = SteepestPerBlock(parameters);
  cv::Mat bridged = corners.clone();
  for (int y = 0; y < bridged.rows; ++y) {
    for (int x = 0; x < bridged.cols; ++x) {
      if (!std::isnan(corners.at<float>(y, x))) continue;
      float sum = 0;
      int count = 0;
      for (const Neighbour& to : kNeighbours) {
        const auto [one, other] = Opposite(framed, x, y, to);
        const float most = 2.0F * to.distance * steepest;
        if (!(std::abs(one - other) <= most)) continue;
        sum += 0.5F * (one + other);
        ++count;
      }
      if (count > 0) bridged.at<float>(y, x) = sum / static_cast<float>(count);
    }
  }
  return bridged;
}

cv::Mat MatchFast(const Frame& frame, Interpolation interpolation) {
  cv::Mat corners = MatchCorners(frame);
  if (frame.parameters.corner_support > 0)
    corners = Bridge(KeepSupported(corners, frame.parameters), frame.parameters);
  return Interpolate(corners, frame.left.size(), interpolation);
}

}  // namespace kantaro::perception::stereo
