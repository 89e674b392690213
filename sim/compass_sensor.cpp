#include "sim/compass_sensor.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kMu0Over4Pi = 1e-7;  // T m / A
constexpr double kTurn_rad = 2.0 * std::numbers::pi;

Vector3d Dipole(const Vector3d& moment_Am2, const Vector3d& away_m) {
  const double r = away_m.norm();
  const Vector3d u = away_m / r;
  return kMu0Over4Pi / (r * r * r) * (3.0 * u * u.dot(moment_Am2) - moment_Am2);
}

/// The magnetisation of a length of pipe: its direction is a matter of its name and number.
Vector3d Magnetised(const std::string& pipe, double number) {
  RandomStream stream(0, fmt::format("iron.{}.{:.0f}", pipe, number));
  const double up = stream.Uniform(-1.0, 1.0);
  const double turned = stream.Uniform(0.0, kTurn_rad);
  const double level = std::sqrt(1.0 - up * up);
  return MagneticField::kReinforcement_T *
         Vector3d(level * std::cos(turned), level * std::sin(turned), up);
}

}  // namespace

MagneticField::MagneticField(const Sewer& sewer, const robot::Compass& compass)
    : sewer_(sewer), earth_W_(0.0, compass.earth_horizontal_T, -compass.earth_down_T) {}

Vector3d MagneticField::At(const Vector3d& p_W, std::optional<std::size_t> pipe,
                           double chainage_m) const {
  Vector3d field = earth_W_;
  for (const network::Manhole& manhole : sewer_.network.manholes) {
    const Vector3d cover_W = manhole.p_WM + manhole.depth_m * Vector3d::UnitZ();
    field += Dipole({0.0, 0.0, -kCoverMoment_Am2}, p_W - cover_W);
  }
  if (pipe && sewer_.network.pipes[*pipe].material == network::Material::kConcrete) {
    // From the middle of one length to the middle of the next one's field goes over into the
    // other's.
    const double lengths = chainage_m / kLengthOfPipe_m - 0.5;
    const double number = std::floor(lengths);
    const double share = lengths - number;
    const std::string& name = sewer_.network.pipes[*pipe].name;
    field += (1.0 - share) * Magnetised(name, number) + share * Magnetised(name, number + 1.0);
  }
  return field;
}

CompassSensor::CompassSensor(const robot::Compass& compass, std::uint64_t seed)
    : compass_(compass), noise_(seed, "sensor.compass") {}

robot::CompassHeading CompassSensor::Measure(const Eigen::Matrix3d& R_WB, const Vector3d& field_T,
                                             double motor_current_A) {
  const Vector3d motors_B(0.0, -compass_.motor_field_T_per_A * motor_current_A, 0.0);
  const Vector3d felt_W = field_T + R_WB * motors_B;
  // Tilt-compensated: the heading is against the level part of what is felt.
  const double north = std::atan2(felt_W.x(), felt_W.y());
  const double ahead = std::atan2(R_WB(0, 0), R_WB(1, 0));
  const double heading =
      std::fmod(ahead - north + noise_.Normal(compass_.noise_rad) + 2.0 * kTurn_rad, kTurn_rad);
  const double expected_T = std::hypot(compass_.earth_horizontal_T, compass_.earth_down_T);
  const bool disturbed =
      std::abs(felt_W.norm() - expected_T) > compass_.strength_tolerance * expected_T;
  return {heading, disturbed};
}

}  // namespace kantaro::sim
