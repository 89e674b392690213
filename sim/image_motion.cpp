#include "sim/image_motion.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kGrid_px = MotionField::kGrid_px;

/// Whole and fractional pixels as cv::remap wants them: 1/32 px each way.
constexpr int kShift = 5;  // from 1/1024 to 1/32
constexpr int kHalf = 1 << (kShift - 1);
constexpr int kFractionMask = cv::INTER_TAB_SIZE - 1;
static_assert(LensMap::kUnit >> kShift == cv::INTER_TAB_SIZE);

/// How far a place of the real picture is shifted in the ideal one after a time [1/65536 of
/// LensMap's unit, whose steps along a row would not add up].
using Shift = cv::Vec2i;

/// At the nodes of a grid over the real picture.
cv::Mat ShiftsAtNodes(const LensMap& lens, const MotionField& field, double time_s) {
  constexpr double kScale = 65536.0 * LensMap::kUnit, kMost = LensMap::kFieldMargin_px;
  const CameraView& ideal = lens.ideal();
  cv::Mat nodes((lens.size().height - 1) / kGrid_px + 2, (lens.size().width - 1) / kGrid_px + 2,
                CV_32SC2);
  for (int row = 0; row < nodes.rows; ++row) {
    for (int col = 0; col < nodes.cols; ++col) {
      const Vector2d place =
          ideal.focal_px * lens.Direction(kGrid_px * Vector2d(col, row)).head<2>();
      const Vector2d velocity = field.At(Vector2d(ideal.center_x_px, ideal.center_y_px) + place);
      const auto shift = [&](double px_s) {
        return static_cast<int>(std::lround(kScale * std::clamp(-time_s * px_s, -kMost, kMost)));
      };
      nodes.at<Shift>(row, col) = {shift(velocity.x()), shift(velocity.y())};
    }
  }
  return nodes;
}

/// The shift of each pixel of a row, in LensMap units.
void ShiftsOfRow(const cv::Mat& nodes, int row, std::vector<int>& shifts) {
  const auto *above = nodes.ptr<Shift>(row / kGrid_px),
             *below = nodes.ptr<Shift>(row / kGrid_px + 1);
  const int down = row % kGrid_px;
  const auto node = [&](int i, int axis) {
    return above[i][axis] + (below[i][axis] - above[i][axis]) / kGrid_px * down;
  };
  int* to = shifts.data();
  const int width = static_cast<int>(shifts.size() / 2);
  for (int i = 0; i * kGrid_px < width; ++i) {
    const int x0 = node(i, 0), y0 = node(i, 1);
    const int dx = (node(i + 1, 0) - x0) / kGrid_px, dy = (node(i + 1, 1) - y0) / kGrid_px;
    const int count = std::min(kGrid_px, width - i * kGrid_px);
    for (int k = 0; k < count; ++k) {
      to[2 * k] = (x0 + k * dx) >> 16;
      to[2 * k + 1] = (y0 + k * dy) >> 16;
    }
    to += 2 * kGrid_px;
  }
}

/// x and y by turns. Both are kept together, so that processors reckon many at a time.
void FillRow(const int* base, std::vector<int>& shifts, std::int16_t* __restrict whole,
             std::uint16_t* __restrict fraction) {
  int* at = shifts.data();
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    at[i] = (base[i] + at[i] + kHalf) >> kShift;
    whole[i] = static_cast<std::int16_t>(at[i] >> cv::INTER_BITS);
  }
  for (std::size_t col = 0; col < shifts.size() / 2; ++col) {
    fraction[col] = static_cast<std::uint16_t>(
        ((at[2 * col + 1] & kFractionMask) << cv::INTER_BITS) + (at[2 * col] & kFractionMask));
  }
}

}  // namespace

Vector2d ImageVelocity(const CameraMotion& motion, const Vector2d& direction, double depth_m) {
  const Vector3d& v = motion.velocity_C;
  const Vector3d& w = motion.angular_velocity_C;
  const double x = direction.x(), y = direction.y(), near = 1.0 / depth_m;
  return {near * (x * v.z() - v.x()) - w.y() + w.z() * y + x * (w.x() * y - w.y() * x),
          near * (y * v.z() - v.y()) + w.x() - w.z() * x + y * (w.x() * y - w.y() * x)};
}

MotionField::MotionField(const LensMap& lens, const RayCaster& rays, const Eigen::Isometry3d& X_WC,
                         const CameraMotion& motion)
    : nodes_((lens.ideal().height_px - 1) / kGrid_px + 2,
             (lens.ideal().width_px - 1) / kGrid_px + 2, CV_64FC2) {
  const CameraView& ideal = lens.ideal();
  for (int row = 0; row < nodes_.rows; ++row) {
    for (int col = 0; col < nodes_.cols; ++col) {
      const Vector3d direction((kGrid_px * col - ideal.center_x_px) / ideal.focal_px,
                               (kGrid_px * row - ideal.center_y_px) / ideal.focal_px, 1.0);
      const auto hit =
          rays.Cast(X_WC.translation(), X_WC.linear() * direction.normalized(), Renderer::kReach_m);
      const double depth_m = (hit ? hit->range_m : Renderer::kReach_m) / direction.norm();
      const Vector2d velocity =
          ideal.focal_px * ImageVelocity(motion, direction.head<2>(), depth_m);
      nodes_.at<cv::Vec2d>(row, col) = {velocity.x(), velocity.y()};
      fastest_px_s_ = std::max(fastest_px_s_, velocity.norm());
    }
  }
}

Vector2d MotionField::At(const Vector2d& p_px) const {
  if (nodes_.empty()) return Vector2d::Zero();
  const auto share = [](double px, int nodes) {
    return std::clamp(px / kGrid_px, 0.0, static_cast<double>(nodes - 1));
  };
  const double x = share(p_px.x(), nodes_.cols), y = share(p_px.y(), nodes_.rows);
  const int col = std::min(static_cast<int>(x), nodes_.cols - 2);
  const int row = std::min(static_cast<int>(y), nodes_.rows - 2);
  const auto along = [&](int at) {
    const auto* node = nodes_.ptr<cv::Vec2d>(at) + col;
    return node[0] + (x - col) * (node[1] - node[0]);
  };
  const cv::Vec2d above = along(row), at = above + (y - row) * (along(row + 1) - above);
  return {at[0], at[1]};
}

void FillMaps(const LensMap& lens, const MotionField& field, double odd_rows_s, RemapMaps& maps) {
  const cv::Size size = lens.size();
  maps.whole.create(size, CV_16SC2);
  maps.fraction.create(size, CV_16UC1);
  const cv::Mat nodes = ShiftsAtNodes(lens, field, odd_rows_s);
  std::vector<int> shifts(2 * static_cast<std::size_t>(size.width));
  for (int row = 0; row < size.height; ++row) {
    if (row % 2 == 1)
      ShiftsOfRow(nodes, row, shifts);
    else
      std::ranges::fill(shifts, 0);
    FillRow(lens.base().ptr<int>(row), shifts, maps.whole.ptr<std::int16_t>(row),
            maps.fraction.ptr<std::uint16_t>(row));
  }
}

}  // namespace kantaro::sim
