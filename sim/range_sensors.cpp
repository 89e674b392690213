#include "sim/range_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Beyond it an IR sensor sees nothing: its value is below a hundredth.
constexpr double kInfraredReach_m = 2.0;

Isometry3d Between(const Isometry3d& X_from, const Isometry3d& X_to, double share) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = X_from.translation() + share * (X_to.translation() - X_from.translation());
  X.linear() = Eigen::Quaterniond(X_from.linear())
                   .slerp(share, Eigen::Quaterniond(X_to.linear()))
                   .toRotationMatrix();
  return X;
}

}  // namespace

LaserScanner::LaserScanner(const robot::Laser& laser, const RayCaster& rays, RandomStream noise)
    : laser_(laser),
      rays_(rays),
      noise_(std::move(noise)),
      beams_per_revolution_(std::llround(laser.samples_Hz / laser.revolutions_Hz)) {
  if (std::abs(static_cast<double>(beams_per_revolution_) * laser.revolutions_Hz -
               laser.samples_Hz) > 1e-9) {
    throw std::invalid_argument("the laser's samples must be a whole number to a revolution");
  }
}

std::vector<LaserScanner::Completed> LaserScanner::Scan(double from_s, double to_s,
                                                        const Isometry3d& X_WL_from,
                                                        const Isometry3d& X_WL_to) {
  std::vector<Completed> completed;
  for (;;) {
    const double time_s = static_cast<double>(beams_ + 1) / laser_.samples_Hz;
    if (time_s > to_s) break;
    const std::int64_t beam = beams_++ % beams_per_revolution_;
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(beam) /
                         static_cast<double>(beams_per_revolution_);
    const double share = std::clamp((time_s - from_s) / (to_s - from_s), 0.0, 1.0);
    current_.samples.push_back(Measure(Between(X_WL_from, X_WL_to, share), angle));
    if (beam + 1 == beams_per_revolution_)
      completed.push_back({time_s, std::exchange(current_, {})});
  }
  return completed;
}

robot::LaserSample LaserScanner::Measure(const Isometry3d& X_WL, double angle_rad) {
  const Vector3d beam_L(0.0, -std::cos(angle_rad), std::sin(angle_rad));
  // The bound of Table 5.1 as three standard deviations. Drawn for every beam, so that one miss
  // moves no other's noise.
  const double error_m =
      std::clamp(noise_.Normal(laser_.accuracy_m / 3.0), -laser_.accuracy_m, laser_.accuracy_m);
  const auto hit = rays_.Cast(X_WL.translation(), X_WL.linear() * beam_L,
                              laser_.range_max_m + laser_.accuracy_m);
  // The scanner's own number is a single: what a recording keeps is what perception got.
  const double range_m = hit ? static_cast<float>(hit->range_m + error_m) : laser_.range_max_m;
  if (!hit || range_m > laser_.range_max_m)
    return {angle_rad, laser_.range_max_m, robot::RangeStatus::kTooFar};
  if (range_m < laser_.range_min_m)
    return {angle_rad, laser_.range_min_m, robot::RangeStatus::kTooNear};
  return {angle_rad, range_m, robot::RangeStatus::kValid};
}

robot::IrReading MeasureInfrared(const robot::Infrared& sensor, const RayCaster& rays,
                                 const Isometry3d& X_WS, RandomStream& noise) {
  const auto hit = rays.Cast(X_WS.translation(), X_WS.linear().col(0), kInfraredReach_m);
  const double ratio = (hit ? hit->range_m : kInfraredReach_m) / sensor.half_range_m;
  return {std::clamp(1.0 / (1.0 + ratio * ratio) + noise.Normal(sensor.noise), 0.0, 1.0)};
}

}  // namespace kantaro::sim
