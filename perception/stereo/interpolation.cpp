#include "perception/stereo/interpolation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace kantaro::perception::stereo {
namespace {

/// Weights of the corners at −1, 0, 1 and 2 blocks for each pixel of a block.
using Weights = std::array<std::array<float, kBlock_px>, 4>;

double Weight(Interpolation kind, double distance) {
  switch (kind) {
    case Interpolation::kNearest:  // half way the left one
      return distance > -0.5 && distance <= 0.5 ? 1.0 : 0.0;
    case Interpolation::kLinear:
      return std::max(0.0, 1.0 - std::abs(distance));
    case Interpolation::kCubic:
      return KeysKernel(distance);
  }
  throw std::invalid_argument("no such interpolation");
}

Weights WeightsOf(Interpolation kind) {
  Weights weights{};
  for (int tap = 0; tap < 4; ++tap) {
    for (int pixel = 0; pixel < kBlock_px; ++pixel) {
      const double position = static_cast<double>(pixel) / kBlock_px;
      weights[tap][pixel] = static_cast<float>(Weight(kind, position - (tap - 1)));
    }
  }
  return weights;
}

/// The corners with one more beyond each border, the last ones again, and 0 for those without
/// disparity; which those are is kept apart.
class Lattice {
 public:
  explicit Lattice(const cv::Mat& corners)
      : values_(corners.rows + 2, corners.cols + 2, CV_32F),
        known_(corners.rows + 2, corners.cols + 2, CV_8U) {
    for (int y = 0; y < values_.rows; ++y) {
      const auto* const in = corners.ptr<float>(std::clamp(y - 1, 0, corners.rows - 1));
      for (int x = 0; x < values_.cols; ++x) {
        const float value = in[std::clamp(x - 1, 0, corners.cols - 1)];
        known_.at<std::uint8_t>(y, x) = std::isnan(value) ? 0 : 1;
        values_.at<float>(y, x) = std::isnan(value) ? 0.0F : value;
      }
    }
  }

  [[nodiscard]] int width() const { return values_.cols; }
  /// A row of corners, −1 being the one beyond the border; [0] is the corner before the first.
  [[nodiscard]] const float* Row(int row) const { return values_.ptr<float>(row + 1); }
  [[nodiscard]] float At(int row, int column) const {
    return known_.at<std::uint8_t>(row + 1, column + 1) != 0
               ? values_.at<float>(row + 1, column + 1)
               : std::numeric_limits<float>::quiet_NaN();
  }

  /// The best kind for a block: all corners that take part have a disparity.
  [[nodiscard]] Interpolation KindFor(Interpolation wanted, int row, int column) const {
    if (wanted == Interpolation::kCubic && AllKnown(row - 1, column - 1, 4))
      return Interpolation::kCubic;
    if (wanted != Interpolation::kNearest && AllKnown(row, column, 2))
      return Interpolation::kLinear;
    return Interpolation::kNearest;
  }

 private:
  [[nodiscard]] bool AllKnown(int row, int column, int count) const {
    bool known = true;
    for (int y = row; y < row + count; ++y) {
      const std::uint8_t* const line = known_.ptr(y + 1) + column + 1;
      for (int x = 0; x < count; ++x) known &= line[x] != 0;
    }
    return known;
  }

  cv::Mat values_, known_;
};

/// Fills the rows of pixels below one row of corners.
class BlockRow {
 public:
  BlockRow(const Lattice& lattice, int row, Interpolation wanted) : lattice_(lattice), row_(row) {
    for (int column = 0; column + 3 < lattice.width(); ++column)
      kinds_.push_back(lattice.KindFor(wanted, row, column));
  }

  void Fill(int y_in_block, float* out, int width) {
    for (const Interpolation kind : {Interpolation::kCubic, Interpolation::kLinear}) {
      if (std::find(kinds_.begin(), kinds_.end(), kind) == kinds_.end()) continue;
      const Weights& weights = kind == Interpolation::kCubic ? kCubic : kLinear;
      CombineRows(weights, y_in_block);
      for (std::size_t column = 0; column < kinds_.size(); ++column) {
        if (kinds_[column] != kind) continue;
        const int x = static_cast<int>(column) * kBlock_px;
        FillBlock(weights, line_.data() + column, out + x, std::min(kBlock_px, width - x));
      }
    }
    for (std::size_t column = 0; column < kinds_.size(); ++column) {
      if (kinds_[column] == Interpolation::kNearest)
        FillNearest(y_in_block, static_cast<int>(column), out, width);
    }
  }

 private:
  static inline const Weights kLinear = WeightsOf(Interpolation::kLinear);
  static inline const Weights kCubic = WeightsOf(Interpolation::kCubic);

  /// Eq. 5.15, down the columns.
  void CombineRows(const Weights& weights, int y_in_block) {
    line_.assign(lattice_.width(), 0.0F);
    for (int tap = 0; tap < 4; ++tap) {
      const float weight = weights[tap][y_in_block];
      const float* const corners = lattice_.Row(row_ + tap - 1);
      for (std::size_t x = 0; x < line_.size(); ++x) line_[x] += weight * corners[x];
    }
  }

  /// Eq. 5.16, along the row.
  static void FillBlock(const Weights& weights, const float* line, float* out, int count) {
    std::array<float, kBlock_px> block;
    for (int x = 0; x < kBlock_px; ++x) {
      block[x] = weights[0][x] * line[0] + weights[1][x] * line[1] + weights[2][x] * line[2] +
                 weights[3][x] * line[3];
    }
    std::copy_n(block.data(), count, out);
  }

  void FillNearest(int y_in_block, int column, float* out, int width) const {
    const int below = 2 * y_in_block > kBlock_px ? 1 : 0;
    const int end = std::min(kBlock_px, width - column * kBlock_px);
    for (int x = 0; x < end; ++x) {
      const int right = 2 * x > kBlock_px ? 1 : 0;
      out[column * kBlock_px + x] = lattice_.At(row_ + below, column + right);
    }
  }

  const Lattice& lattice_;
  int row_;
  std::vector<Interpolation> kinds_;  ///< of each block
  std::vector<float> line_;
};

}  // namespace

double KeysKernel(double distance) {
  const double d = std::abs(distance);
  if (d <= 1) return 1.5 * d * d * d - 2.5 * d * d + 1;
  if (d <= 2) return -0.5 * d * d * d + 2.5 * d * d - 4 * d + 2;
  return 0;
}

double KeysKernelSlope(double distance) {
  const double d = std::abs(distance);
  if (d <= 1) return (4.5 * d - 5) * distance;
  if (d <= 2) return ((-1.5 * d + 5) * d - 4) * std::copysign(1.0, distance);
  return 0;
}

int CornersAlong(int pixels) { return (pixels + kBlock_px - 1) / kBlock_px + 1; }

cv::Mat Interpolate(const cv::Mat& corners, cv::Size size, Interpolation kind) {
  if (corners.type() != CV_32FC1 || size.width < 1 || size.height < 1 ||
      corners.cols != CornersAlong(size.width) || corners.rows != CornersAlong(size.height))
    throw std::invalid_argument("interpolation: the corners do not fit the image");
  const Lattice lattice(corners);
  cv::Mat pixels(size, CV_32F);
  for (int row = 0; row * kBlock_px < size.height; ++row) {
    BlockRow blocks(lattice, row, kind);
    for (int y = 0; y < kBlock_px && row * kBlock_px + y < size.height; ++y)
      blocks.Fill(y, pixels.ptr<float>(row * kBlock_px + y), size.width);
  }
  return pixels;
}

}  // namespace kantaro::perception::stereo
