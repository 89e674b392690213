#include "sim/image_motion.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace kantaro::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Whole and fractional pixels as cv::remap wants them: 1/32 px each way.
constexpr int kShift = 5;  // from 1/1024 to 1/32
constexpr int kHalf = 1 << (kShift - 1);
constexpr int kFractionMask = cv::INTER_TAB_SIZE - 1;
static_assert(LensMap::kUnit >> kShift == cv::INTER_TAB_SIZE);

/// The shift of each pixel of a row, in LensMap units, from its two rows of nodes.
void ShiftsOfRow(const MotionField& field, int row, double time_s, std::vector<int>& shifts) {
  constexpr int kGrid = MotionField::kGrid_px;
  const int upper = row / kGrid;
  const double below = static_cast<double>(row % kGrid) / kGrid;
  const auto* above_nodes = field.nodes().ptr<cv::Vec2d>(upper);
  const auto* below_nodes = field.nodes().ptr<cv::Vec2d>(upper + 1);
  // A 16-bit fraction more than the map's own keeps the steps along the row exact enough.
  const double scale = -time_s * LensMap::kUnit * 65536.0;
  const auto node = [&](int i, int axis) {
    const double limit = 65536.0 * LensMap::kUnit * (LensMap::kMargin_px - 2);
    const double shift =
        scale * ((1.0 - below) * above_nodes[i][axis] + below * below_nodes[i][axis]);
    return static_cast<int>(std::lround(std::clamp(shift, -limit, limit)));
  };
  int* to = shifts.data();
  const int width = static_cast<int>(shifts.size() / 2);
  for (int i = 0; i * kGrid < width; ++i) {
    const int x0 = node(i, 0), y0 = node(i, 1);
    const int dx = (node(i + 1, 0) - x0) / kGrid, dy = (node(i + 1, 1) - y0) / kGrid;
    const int count = std::min(kGrid, width - i * kGrid);
    for (int k = 0; k < count; ++k) {
      to[2 * k] = (x0 + k * dx) >> 16;
      to[2 * k + 1] = (y0 + k * dy) >> 16;
    }
    to += 2 * kGrid;
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
    : nodes_((lens.size().height - 1) / kGrid_px + 2, (lens.size().width - 1) / kGrid_px + 2,
             CV_64FC2) {
  for (int row = 0; row < nodes_.rows; ++row) {
    for (int col = 0; col < nodes_.cols; ++col) {
      const Vector2d p_px(std::min(col * kGrid_px, lens.size().width - 1),
                          std::min(row * kGrid_px, lens.size().height - 1));
      const Vector3d direction = lens.Direction(p_px);
      const auto hit =
          rays.Cast(X_WC.translation(), X_WC.linear() * direction.normalized(), Renderer::kReach_m);
      const double depth_m = (hit ? hit->range_m : Renderer::kReach_m) / direction.norm();
      const Vector2d velocity =
          lens.ideal().focal_px * ImageVelocity(motion, direction.head<2>(), depth_m);
      nodes_.at<cv::Vec2d>(row, col) = {velocity.x(), velocity.y()};
      fastest_px_s_ = std::max(fastest_px_s_, velocity.norm());
    }
  }
}

void FillMaps(const LensMap& lens, const MotionField& field, double time_s, double odd_rows_s,
              RemapMaps& maps) {
  const cv::Size size = lens.size();
  maps.whole.create(size, CV_16SC2);
  maps.fraction.create(size, CV_16UC1);
  std::vector<int> shifts(2 * static_cast<std::size_t>(size.width));
  for (int row = 0; row < size.height; ++row) {
    if (field.nodes().empty())
      std::ranges::fill(shifts, 0);
    else
      ShiftsOfRow(field, row, time_s + (row % 2 == 1 ? odd_rows_s : 0.0), shifts);
    FillRow(lens.base().ptr<int>(row), shifts, maps.whole.ptr<std::int16_t>(row),
            maps.fraction.ptr<std::uint16_t>(row));
  }
}

}  // namespace kantaro::sim
