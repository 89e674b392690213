#include "perception/perception.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "perception/brightness.hpp"
#include "perception/fault_detector.hpp"
#include "perception/ring_finder.hpp"

namespace kantaro::perception {
namespace {

/// The pipe's centre in the image near this radius: that of the ring of the nearest radius, else
/// the principal point. A robot that is turned by 2° in the pipe moves the centre by 20 px.
cv::Point2d PipeCenter(const std::vector<RingSighting>& rings, const robot::Camera& camera,
                       double radius_px) {
  cv::Point2d center(camera.center_x_px, camera.center_y_px);
  double least_px = HUGE_VAL;
  for (const RingSighting& ring : rings) {
    const double apart_px = std::abs(ring.radius_px - radius_px);
    if (apart_px >= least_px) continue;
    least_px = apart_px;
    center = {ring.center_x_px, ring.center_y_px};
  }
  return center;
}

/// No reading of a sensor that works.
bool IsImplausible(const robot::Reading& reading, double gyro_range_rad_s) {
  if (const auto* inertial = std::get_if<robot::InertialReading>(&reading.value)) {
    return inertial->angular_velocity_rad_s.cwiseAbs().maxCoeff() >= gyro_range_rad_s;
  }
  if (const auto* laser = std::get_if<robot::LaserRevolution>(&reading.value)) {
    return !laser->samples.empty() &&
           std::all_of(laser->samples.begin(), laser->samples.end(), [](const auto& sample) {
             return sample.status == robot::RangeStatus::kTooFar;
           });
  }
  return false;
}

/// 1 s: 0.15 m at 15 cm/s, more than any channel keeps up a circle that is not its pipe's.
constexpr int kRevolutionsToAnotherPipe = 30;

/// Edges are dated within the turn where the thesis does not ask for less.
robot::RunTime MirrorTurn(const robot::Description& description, LaserMethod method) {
  if (method == LaserMethod::kThesis || description.laser.speed_rpm <= 0.0) return {};
  return std::chrono::duration_cast<robot::RunTime>(
      std::chrono::duration<double>(60.0 / description.laser.speed_rpm));
}

}  // namespace

Perception::Perception(robot::Description description, Parameters parameters)
    : camera_(description.front_camera),
      rectifier_(camera_, robot::FrontRectification(description)),
      gyro_range_rad_s_(description.inertial.gyro_range_rad_s > 0.0
                            ? description.inertial.gyro_range_rad_s
                            : std::numeric_limits<double>::infinity()),
      parameters_(parameters),
      odometry_(description),
      wall_(kRevolutionsToAnotherPipe),
      laser_(parameters.laser.revolutions, MirrorTurn(description, parameters.laser.method)),
      ir_(parameters.ir),
      repetition_(parameters.stuck_readings) {}

void Perception::SetPipeDiameter(double diameter_m) {
  if (!(diameter_m > 0 && std::isfinite(diameter_m))) {
    throw std::invalid_argument("the pipe's diameter must be above 0");
  }
  if (pipe_diameter_m_ == diameter_m) return;
  rings_.emplace(camera_, diameter_m / 2, parameters_.rings);
  pipe_diameter_m_ = diameter_m;
}

std::optional<LossObservation> Perception::Distrust(const robot::Reading& reading) {
  using Cause = LossObservation::Cause;
  const auto because = [&](Cause cause) {
    return LossObservation{reading.captured_at, robot::SensorOf(reading), cause};
  };
  if (const auto* loss = std::get_if<robot::Loss>(&reading.value))
    return because(loss->line_down ? Cause::kLineDown : Cause::kMissing);
  if (repetition_.IsStuck(reading)) return because(Cause::kStuck);
  if (IsImplausible(reading, gyro_range_rad_s_)) return because(Cause::kImplausible);
  return {};
}

std::vector<Observation> Perception::Process(const robot::Reading& reading) {
  if (const auto loss = Distrust(reading)) return {*loss};
  const robot::RunTime at = reading.captured_at;
  return std::visit(
      [&](const auto& value) -> std::vector<Observation> {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, robot::FrontImage>) {
          return Look(value, at);
        } else if constexpr (std::is_same_v<Value, robot::LaserRevolution>) {
          return Scan(value, at);
        } else if constexpr (std::is_same_v<Value, robot::IrRanges>) {
          return {ir_.Update(value, at)};
        } else if constexpr (std::is_same_v<Value, robot::WheelEncoders>) {
          return {odometry_.Travel(value, at)};
        } else if constexpr (std::is_same_v<Value, robot::InertialReading>) {
          return {attitude_.Update(value, at)};
        } else if constexpr (std::is_same_v<Value, robot::Inclination>) {
          return {InclinationObservation{at, value.roll_rad, value.pitch_rad}};
        } else if constexpr (std::is_same_v<Value, robot::BatteryState>) {
          return {BatteryObservation{at, value.charge, value.voltage_V}};
        } else {
          return {};
        }
      },
      reading.value);
}

std::vector<Observation> Perception::Look(const robot::FrontImage& front,
                                          robot::RunTime captured_at) const {
  const cv::Mat seen = Brightness(front.image);
  if (seen.size() != cv::Size(camera_.width_px, camera_.height_px)) {
    throw std::invalid_argument("the front image has not the front camera's size");
  }
  if (!pipe_diameter_m_) return {};
  const cv::Mat brightness = rectifier_.Rectify(seen);

  RingObservation rings{captured_at, rings_->Find(brightness)};
  FaultObservation faults{captured_at, {}};
  const double scale = camera_.focal_px * *pipe_diameter_m_ / 2;
  const double middle_px =
      (scale / parameters_.faults.near_m + scale / parameters_.faults.far_m) / 2;
  const Ring ring = FaultRing(camera_, *pipe_diameter_m_,
                              PipeCenter(rings.rings, camera_, middle_px), parameters_.faults);
  faults.candidates = FindFaults(brightness, ring, camera_.focal_px, *pipe_diameter_m_, rings.rings,
                                 parameters_.faults);
  return {std::move(rings), std::move(faults)};
}

std::vector<Observation> Perception::Scan(const robot::LaserRevolution& revolution,
                                          robot::RunTime captured_at) {
  std::optional<PipeSlice> wall;
  if (parameters_.laser.method == LaserMethod::kOurs)
    wall = wall_.Update(revolution, parameters_.laser.far_limit_m);
  auto observation = ReadWindows(revolution, captured_at, parameters_.laser, wall);
  if (!observation) return {};
  observation->edges = laser_.Update(*observation);
  return {*std::move(observation)};
}

}  // namespace kantaro::perception
