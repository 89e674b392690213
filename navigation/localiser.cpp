#include "navigation/localiser.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kantaro::navigation {
namespace {

constexpr double kNoGate = std::numeric_limits<double>::infinity();

double Square(double value) { return value * value; }

}  // namespace

Localiser::Localiser(const MapLeg& leg, double distance_m, const Parameters& parameters)
    : parameters_(parameters) {
  x_(2) = 1.0;
  P_(2, 2) = Square(parameters.scale_error);
  Begin(leg, distance_m, parameters.start_error_m);
}

void Localiser::Begin(const MapLeg& leg, double distance_m, double deviation_m) {
  mapped_length_m_ = leg.length_m;
  const double scale_variance = P_(2, 2);
  x_ = {distance_m, leg.length_m, x_(2)};
  P_.setZero();
  P_(0, 0) = Square(deviation_m);
  P_(1, 1) = Square(parameters_.map_error * leg.length_m);
  P_(2, 2) = scale_variance;
}

void Localiser::Advance(double wheel_travel_m) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = wheel_travel_m;
  x_ = F * x_;
  P_ = F * P_ * F.transpose();
  // A random walk: its variance grows with the distance travelled, by (travel_error)² per metre.
  P_(0, 0) += Square(parameters_.travel_error) * std::abs(wheel_travel_m);
}

bool Localiser::Update(const Eigen::RowVector3d& h, double measured, double deviation,
                       double gate_deviations) {
  const double innovation = measured - h * x_;
  const double variance = h * P_ * h.transpose() + Square(deviation);
  if (std::abs(innovation) > gate_deviations * std::sqrt(variance)) return false;
  const Eigen::Vector3d gain = P_ * h.transpose() / variance;
  x_ += gain * innovation;
  P_ -= gain * h * P_;
  P_ = 0.5 * (P_ + P_.transpose()).eval();
  return true;
}

bool Localiser::SeeEndWall(double ahead_m, double deviation_m) {
  return Update({-1.0, 1.0, 0.0}, ahead_m, deviation_m, parameters_.gate_deviations);
}

void Localiser::ForgetLength() {
  x_(1) = mapped_length_m_;
  P_.row(1).setZero();
  P_.col(1).setZero();
  P_(1, 1) = Square(parameters_.map_error * mapped_length_m_);
}

bool Localiser::SeeStartWall(double behind_m, double deviation_m) {
  return Update({1.0, 0.0, 0.0}, behind_m, deviation_m, parameters_.gate_deviations);
}

bool Localiser::SeeLandmark(double mapped_m, double ahead_m, double deviation_m) {
  return Update({-1.0, mapped_m / mapped_length_m_, 0.0}, ahead_m, deviation_m,
                parameters_.gate_deviations);
}

void Localiser::SeeScale(double scale, double deviation) {
  Update({0.0, 0.0, 1.0}, scale, deviation, kNoGate);
}

double Localiser::deviation_m() const { return std::sqrt(P_(0, 0)); }

double Localiser::to_landmark_deviation_m(double mapped_m) const {
  const double share = mapped_m / mapped_length_m_;
  return std::sqrt(std::max(0.0, P_(0, 0) + share * share * P_(1, 1) - 2.0 * share * P_(0, 1)));
}

}  // namespace kantaro::navigation
