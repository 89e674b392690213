#include "sim/range_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "robot/mirror_angle.hpp"

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
    : laser_(laser), rays_(rays), noise_(std::move(noise)) {}

double LaserScanner::Turns(std::int64_t beam) const {
  // The product is exact: a beam count times a whole number of rpm.
  return static_cast<double>(beam) * laser_.speed_rpm / (60.0 * laser_.samples_Hz);
}

std::vector<LaserScanner::Completed> LaserScanner::Scan(double from_s, double to_s,
                                                        const Isometry3d& X_WL_from,
                                                        const Isometry3d& X_WL_to) {
  std::vector<Completed> completed;
  if (laser_.speed_rpm == 0.0) return completed;
  for (;;) {
    const double time_s = static_cast<double>(beams_ + 1) / laser_.samples_Hz;
    if (time_s > to_s) break;
    const double turns = Turns(beams_++);
    const double share = std::clamp((time_s - from_s) / (to_s - from_s), 0.0, 1.0);
    current_.samples.push_back(
        Measure(Between(X_WL_from, X_WL_to, share), turns - std::floor(turns)));
    if (std::floor(Turns(beams_)) > std::floor(turns))
      completed.push_back({time_s, std::exchange(current_, {})});
  }
  return completed;
}

robot::LaserSample LaserScanner::Measure(const Isometry3d& X_WL, double turn) {
  // The light goes where the mirror stands; what is told is the last count that it passed.
  const auto count = static_cast<std::uint32_t>(turn * laser_.mirror_counts);
  const double told_rad = robot::MirrorAngle(count, laser_.mirror_counts);
  // The bound of Table 5.1 as three standard deviations. Drawn for every beam, so that one miss
  // moves no other's noise.
  const double error_m =
      std::clamp(noise_.Normal(laser_.accuracy_m / 3.0), -laser_.accuracy_m, laser_.accuracy_m);
  const std::optional<double> true_m = Footprint(X_WL, 2.0 * std::numbers::pi * turn);
  // The scanner's own number is a single: what a recording keeps is what perception got.
  const double range_m = true_m ? static_cast<float>(*true_m + error_m) : laser_.range_max_m;
  if (!true_m || range_m > laser_.range_max_m)
    return {told_rad, laser_.range_max_m, robot::RangeStatus::kTooFar};
  if (range_m < laser_.range_min_m)
    return {told_rad, laser_.range_min_m, robot::RangeStatus::kTooNear};
  return {told_rad, range_m, robot::RangeStatus::kValid};
}

std::optional<double> LaserScanner::Footprint(const Isometry3d& X_WL, double angle_rad) const {
  const Vector3d beam_W = X_WL.linear() * Vector3d(0.0, -std::cos(angle_rad), std::sin(angle_rad));
  const Vector3d across_W = X_WL.linear() * Vector3d(0.0, std::sin(angle_rad), std::cos(angle_rad));
  const Vector3d along_W = X_WL.linear().col(0);
  const auto range = [&](double across_m, double along_m) -> std::optional<double> {
    const auto hit = rays_.Cast(X_WL.translation() + across_m * across_W + along_m * along_W,
                                beam_W, laser_.range_max_m + laser_.accuracy_m);
    return hit ? std::optional(hit->range_m) : std::nullopt;
  };
  // Two rays, on opposite sides of the disc's middle, see a plane as the whole disc does: their
  // mean is its mean. Where they disagree there is an edge, and the disc is looked at closely. Near
  // the disc's rim, they miss edges that cut off an eighth of it at most.
  const double r = 0.9 * std::numbers::sqrt2 / 2.0 * laser_.beam_radius_m;
  const auto one = range(r, r);
  const auto other = range(-r, -r);
  if (one.has_value() != other.has_value() ||
      (one && std::abs(*one - *other) > laser_.accuracy_m)) {
    return EdgeFootprint(range);
  }
  return one ? std::optional(0.5 * (*one + *other)) : std::nullopt;
}

template <typename Range>
std::optional<double> LaserScanner::EdgeFootprint(const Range& range) const {
  // Rings and spokes of equal areas.
  constexpr int kRings = 3;
  constexpr int kSpokes = 8;
  double sum_m = 0.0;
  int returned = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double r = laser_.beam_radius_m * std::sqrt((ring + 0.5) / kRings);
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const double a = 2.0 * std::numbers::pi * (spoke + 0.5) / kSpokes;
      const auto range_m = range(r * std::cos(a), r * std::sin(a));
      sum_m += range_m.value_or(0.0);
      returned += range_m ? 1 : 0;
    }
  }
  // The detector finds the middle of the light that returns; half a spot is too faint for it.
  if (2 * returned < kRings * kSpokes) return std::nullopt;
  return sum_m / returned;
}

robot::IrReading MeasureInfrared(const robot::Infrared& sensor, const RayCaster& rays,
                                 const GroundAt& ground, const Isometry3d& X_WS,
                                 RandomStream& noise) {
  // The middle and two rings stand for equal solid angles of the cone.
  constexpr int kSpokes = 6;
  const auto light = [&](double angle_rad, double spoke_rad) {
    const Vector3d beam_S(std::cos(angle_rad), std::sin(angle_rad) * std::cos(spoke_rad),
                          std::sin(angle_rad) * std::sin(spoke_rad));
    const Vector3d beam_W = X_WS.linear() * beam_S;
    const auto hit = rays.Cast(X_WS.translation(), beam_W, kInfraredReach_m);
    const double range_m = hit ? hit->range_m : kInfraredReach_m;
    const double ratio = sensor.half_range_m / range_m;
    if (!ground) return ratio * ratio;
    const Vector3d p_W = X_WS.translation() + range_m * beam_W;
    return ground(p_W).grip.infrared_return * ratio * ratio;
  };
  double sum = light(0.0, 0.0);
  int beams = 1;
  for (const double share : {0.5, 0.9}) {
    for (int spoke = 0; spoke < kSpokes && sensor.cone_half_angle_rad > 0.0; ++spoke, ++beams)
      sum += light(share * sensor.cone_half_angle_rad,
                   2.0 * std::numbers::pi * (spoke + 0.25) / kSpokes);
  }
  const double returned = sum / beams;
  return {std::clamp(returned / (1.0 + returned) + noise.Normal(sensor.noise), 0.0, 1.0)};
}

}  // namespace kantaro::sim
