#include "perception/wall_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "perception/stereo/interpolation.hpp"

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kLowest = 0.75;  ///< of the wall below the axis, in radii: water lies under it
constexpr double kLeast_m = 0.1;  ///< nothing nearer is unrolled
constexpr float kFlat = 1e-5F;    ///< variance of log brightness where there is no texture
constexpr double kNearby = 12.0, kFarther = 17.0;  ///< widths of means, in the smoothing's

/// Wall that was farther off then is seen in less detail then: pictures taken later are sampled so
/// much more finely, and averaged.
constexpr int kFiner = 2;

int OddWidth(double widths, double smooth_px) {
  return 2 * static_cast<int>(widths * smooth_px / 2.0) + 1;
}

/// How far off a picture still comes into a texture: by its smoothing, the farther mean, and the
/// mean of its scatter.
int Reach(double smooth_px) {
  return static_cast<int>(std::ceil(4.0 * smooth_px)) + OddWidth(kFarther, smooth_px) / 2 +
         OddWidth(kNearby, smooth_px) / 2;
}

/// How much each of the pixels at -1, 0, 1 and 2 counts in between, and how that changes.
struct Taps {
  explicit Taps(double at) {
    for (int k = 0; k < 4; ++k) {
      weights[k] = stereo::KeysKernel(at - (k - 1));
      slopes[k] = stereo::KeysKernelSlope(at - (k - 1));
    }
  }
  std::array<double, 4> weights, slopes;
};

cv::Mat Mean(const cv::Mat& of, int width_px) {
  cv::Mat mean;
  cv::blur(of, mean, {width_px, width_px});
  return mean;
}

/// Less what lies around it: two means, of such weights that a quadratic leaves nothing; in
/// deviations. The light stays with the robot; what is left of it would too. So would a manhole's
/// edges, far stronger than any texture, if contrast counted as it is.
cv::Mat Contrast(const cv::Mat& unrolled, double smooth_px) {
  cv::Mat contrast;
  cv::GaussianBlur(unrolled, contrast, {}, smooth_px);
  const auto spread = [](int width_px) { return (width_px * width_px - 1) / 12.0; };
  const int near = OddWidth(kNearby, smooth_px), far = OddWidth(kFarther, smooth_px);
  const double far_weight = spread(near) / (spread(near) - spread(far));
  contrast -= (1.0 - far_weight) * Mean(contrast, near) + far_weight * Mean(contrast, far);
  cv::Mat scatter;
  cv::sqrt(Mean(contrast.mul(contrast), near) + kFlat, scatter);
  return contrast / scatter;
}

}  // namespace

WallPlace WallSighting::PlaceAt(const cv::Point2d& pixel) const {
  const Vector3d p_C = wall.PointAt(pixel - cv::Point2d(shift_px, 0.0));
  return {p_C.dot(wall.Along()) - ahead_m, turn.inverse() * wall.DirectionOf(p_C)};
}

WallGrid::WallGrid(double ring_px_m, double behind_m, double near_m, double far_m,
                   const TextureScale& scale)
    : scale_(scale),
      ring_px_m_(ring_px_m / scale.shrink),
      behind_m_(behind_m),
      pad_px_(Reach(scale.smooth_px)) {
  const double smallest_px = ring_px_m_ / (far_m + behind_m),
               largest_px = ring_px_m_ / (near_m + behind_m);
  first_px_ = smallest_px - pad_px_;
  columns_ = static_cast<int>(largest_px - smallest_px) + 2 * pad_px_;
  rows_ = std::max(1, static_cast<int>(std::lround(kTurn_rad * 0.5 * (smallest_px + largest_px))));
}

double WallGrid::DistanceAt(double column) const {
  constexpr double kSmallest_px = 0.5;  // of a ring, where columns are padded beyond the axis
  return ring_px_m_ / std::max(kSmallest_px, first_px_ + column) - behind_m_;
}

double WallGrid::AngleAt(double row) const { return kTurn_rad * row / rows_; }

std::vector<WallPlace> WallGrid::Places(int apart_px) const {
  std::vector<WallPlace> places;
  for (int k = pad_px_; k < columns_ - pad_px_; k += apart_px) {
    for (int t = 0; t < rows_; t += apart_px) {
      const double a = AngleAt(t);
      if (std::sin(a) < kLowest) places.push_back({DistanceAt(k), {std::cos(a), std::sin(a)}});
    }
  }
  return places;
}

cv::Mat WallGrid::Unroll(const cv::Mat& log_brightness, const WallSighting& sighting) const {
  const int shrink = scale_.shrink;
  cv::Mat picture = log_brightness;
  if (shrink > 1) {
    const cv::Size size = log_brightness.size() / shrink;
    cv::resize(log_brightness({{0, 0}, size * shrink}), picture, size, 0, 0, cv::INTER_AREA);
  }
  cv::Mat from(rows_ * kFiner, columns_ * kFiner, CV_32FC2);
  std::vector<double> distances_m;
  for (int k = 0; k < from.cols; ++k)
    distances_m.push_back(std::max(kLeast_m, DistanceAt((k + 0.5) / kFiner - 0.5)));
  for (int t = 0; t < from.rows; ++t) {
    const double a = AngleAt((t + 0.5) / kFiner - 0.5);
    const Vector3d beside = sighting.PointAt({0.0, {std::cos(a), std::sin(a)}});
    auto* const row = from.ptr<cv::Vec2f>(t);
    for (int k = 0; k < from.cols; ++k) {
      const cv::Point2d at = sighting.PixelOf(beside + distances_m[k] * sighting.wall.Along());
      row[k] = {static_cast<float>((at.x + 0.5) / shrink - 0.5),
                static_cast<float>((at.y + 0.5) / shrink - 0.5)};
    }
  }
  cv::Mat fine, unrolled;
  cv::remap(picture, fine, from, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::resize(fine, unrolled, {columns_, rows_}, 0, 0, cv::INTER_AREA);
  return unrolled;
}

cv::Mat WallGrid::Texture(const cv::Mat& log_brightness, const WallSighting& sighting) const {
  cv::Mat wrapped;
  cv::copyMakeBorder(Unroll(log_brightness, sighting), wrapped, pad_px_, pad_px_, 0, 0,
                     cv::BORDER_WRAP);
  return Contrast(wrapped, scale_.smooth_px);
}

std::optional<WallGrid::Sample> WallGrid::Take(const cv::Mat& texture,
                                               const WallPlace& place) const {
  const double ring_px = ring_px_m_ / (place.distance_m + behind_m_);
  const double column = ring_px - first_px_;
  const int rim_px = pad_px_ / 2;
  if (!(column >= rim_px && column < columns_ - rim_px - 1)) return std::nullopt;
  const double angle_rad = std::atan2(place.direction.y(), place.direction.x());
  const double row =
      (angle_rad < 0.0 ? angle_rad + kTurn_rad : angle_rad) * rows_ / kTurn_rad + pad_px_;
  const int x = static_cast<int>(column), y = static_cast<int>(row);
  // Cubic: what linear interpolation smooths between pixels draws a fit to where it smooths most.
  const Taps across(column - x), down(row - y);
  double value = 0.0, by_column = 0.0, by_row = 0.0;
  for (int j = 0; j < 4; ++j) {
    const float* const from = texture.ptr<float>(y - 1 + j) + x - 1;
    double in_row = 0.0, slope_in_row = 0.0;
    for (int i = 0; i < 4; ++i) {
      in_row += across.weights[i] * from[i];
      slope_in_row += across.slopes[i] * from[i];
    }
    value += down.weights[j] * in_row;
    by_column += down.weights[j] * slope_in_row;
    by_row += down.slopes[j] * in_row;
  }
  return Sample{value, -by_column * ring_px * ring_px / ring_px_m_, by_row * rows_ / kTurn_rad};
}

}  // namespace kantaro::perception
