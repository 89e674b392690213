#include "perception/pipe_slice.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kantaro::perception {
namespace {

using Eigen::Vector2d;

/// Of choosing what is wall [m]: wide first, for the lower half alone may have the circle a little
/// off.
constexpr std::array kBands_m{kWallBand_m, 0.006, 0.004, 0.004, 0.004};
constexpr double kLeastWallShare = 0.25;
/// A 150 mm inlet opens a fifth of a 250 mm pipe; a channel and its walls up to 24° are 0.63 of a
/// turn.
constexpr double kShareToTakeOver = 0.8;
/// Before the far limit: the scanner's noise and the circle's error are within it.
constexpr double kReachMargin_m = 0.001;
/// Of a circle that was fitted to a whole wall, of the robot's sway from one revolution to the next
/// (in a tee it leans 20 mm within 2 s), and of a beam against the wall: noise, roughness, grooves.
constexpr double kFitted_m = 0.0003;
constexpr double kSway_m = 0.0006;
constexpr double kBeam_m = 0.003;
constexpr double kSameWall_m = 0.003;  ///< from one revolution to the next
/// Radii of pipes with some allowance [m]: 150 to 700 mm across.
constexpr double kLeastRadius_m = 0.070, kLargestRadius_m = 0.360;

struct Circle {
  Vector2d center_m;
  double radius_m{};

  [[nodiscard]] double Off(const Vector2d& point) const {
    return std::abs((point - center_m).norm() - radius_m);
  }
};

/// Kåsa: x² + y² = 2 a x + 2 b y + c is linear in a, b and c.
std::optional<Circle> FitCircle(const std::vector<Vector2d>& points) {
  if (points.size() < 3) return std::nullopt;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Vector2d& p : points) {
    const Eigen::Vector3d row(2.0 * p.x(), 2.0 * p.y(), 1.0);
    normal += row * row.transpose();
    right += p.squaredNorm() * row;
  }
  const Eigen::Vector3d abc = normal.ldlt().solve(right);
  const double square = abc.z() + abc.head<2>().squaredNorm();
  if (!abc.allFinite() || square <= 0.0) return std::nullopt;
  return Circle{abc.head<2>(), std::sqrt(square)};
}

std::vector<Vector2d> Within(const std::vector<Vector2d>& points, const Circle& circle,
                             double band_m) {
  std::vector<Vector2d> wall;
  for (const Vector2d& p : points) {
    if (circle.Off(p) < band_m) wall.push_back(p);
  }
  return wall;
}

bool Agree(const PipeSlice& a, const PipeSlice& b) {
  return std::abs(a.radius_m - b.radius_m) < kSameWall_m &&
         std::hypot(a.right_m - b.right_m, a.up_m - b.up_m) < kSameWall_m;
}

}  // namespace

double PipeSlice::RangeAt(double angle_rad) const {
  const Vector2d middle(right_m, up_m);
  const Vector2d along(std::cos(angle_rad), std::sin(angle_rad));
  const double towards = middle.dot(along);
  return towards +
         std::sqrt(std::max(0.0, radius_m * radius_m - middle.squaredNorm() + towards * towards));
}

double PipeSlice::DeviationAt(double angle_rad) const {
  const Vector2d along(std::cos(angle_rad), std::sin(angle_rad));
  return std::sqrt(along.dot(covariance_m2 * along));
}

std::optional<PipeSlice> FitPipeSlice(const robot::LaserRevolution& revolution,
                                      double far_limit_m) {
  std::vector<Vector2d> points, lower;
  for (const robot::LaserSample& sample : revolution.samples) {
    if (sample.status != robot::RangeStatus::kValid) continue;
    points.emplace_back(sample.range_m * std::cos(sample.angle_rad),
                        sample.range_m * std::sin(sample.angle_rad));
    if (points.back().y() < 0.0) lower.push_back(points.back());
  }
  std::optional<Circle> circle = FitCircle(lower);
  std::size_t wall = 0;
  for (const double band_m : kBands_m) {
    if (!circle) return std::nullopt;
    const std::vector<Vector2d> chosen = Within(points, *circle, band_m);
    wall = chosen.size();
    circle = FitCircle(chosen);
  }
  if (!circle || circle->radius_m < kLeastRadius_m || circle->radius_m > kLargestRadius_m)
    return std::nullopt;
  if (circle->center_m.norm() >= circle->radius_m) return std::nullopt;
  if (static_cast<double>(wall) < kLeastWallShare * static_cast<double>(revolution.samples.size()))
    return std::nullopt;
  PipeSlice slice{circle->center_m.x(), circle->center_m.y(), circle->radius_m, 0.0,
                  kFitted_m * kFitted_m * Eigen::Matrix2d::Identity()};
  const auto in_reach =
      std::ranges::count_if(revolution.samples, [&](const robot::LaserSample& sample) {
        return slice.RangeAt(sample.angle_rad) < far_limit_m - kReachMargin_m;
      });
  slice.wall_share = std::min(
      1.0, static_cast<double>(wall) / static_cast<double>(std::max<std::ptrdiff_t>(1, in_reach)));
  return slice;
}

const std::optional<PipeSlice>& PipeSliceTracker::Update(const robot::LaserRevolution& revolution,
                                                         double far_limit_m) {
  const std::optional<PipeSlice> fit = FitPipeSlice(revolution, far_limit_m);
  const bool pipe = fit && fit->wall_share >= kShareToTakeOver;
  if (pipe && held_ && Agree(*fit, *held_)) {
    held_ = fit;
    seen_ = 0;
    return held_;
  }
  seen_ = !pipe ? 0 : other_ && Agree(*fit, *other_) ? seen_ + 1 : 1;
  if (pipe) other_ = fit;
  if (pipe && (!held_ || seen_ >= settled_)) {
    held_ = fit;
  } else if (held_) {
    Follow(revolution);
  }
  return held_;
}

void PipeSliceTracker::Follow(const robot::LaserRevolution& revolution) {
  // In the filter's information form: each beam on the wall pulls along its normal.
  held_->covariance_m2 += kSway_m * kSway_m * Eigen::Matrix2d::Identity();
  Eigen::Matrix2d information = held_->covariance_m2.inverse();
  Vector2d pull = Vector2d::Zero();
  const Vector2d middle(held_->right_m, held_->up_m);
  for (const robot::LaserSample& sample : revolution.samples) {
    if (sample.status != robot::RangeStatus::kValid || std::sin(sample.angle_rad) > 0.0) continue;
    const Vector2d from_middle =
        sample.range_m * Vector2d(std::cos(sample.angle_rad), std::sin(sample.angle_rad)) - middle;
    const double off_m = from_middle.norm() - held_->radius_m;
    if (std::abs(off_m) > kBands_m.back()) continue;
    const Vector2d outward = from_middle.normalized();
    information += outward * outward.transpose() / (kBeam_m * kBeam_m);
    pull += off_m * outward / (kBeam_m * kBeam_m);
  }
  held_->covariance_m2 = information.inverse();
  const Vector2d step = held_->covariance_m2 * pull;
  held_->right_m += step.x();
  held_->up_m += step.y();
}

}  // namespace kantaro::perception
