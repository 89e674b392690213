#include "perception/repetition.hpp"

#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <variant>

namespace kantaro::perception {
namespace {

bool Same(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  const std::size_t row_bytes = a.elemSize() * static_cast<std::size_t>(a.cols);
  for (int row = 0; row < a.rows; ++row) {
    if (a.ptr(row) != b.ptr(row) && std::memcmp(a.ptr(row), b.ptr(row), row_bytes) != 0)
      return false;
  }
  return true;
}

bool Same(const robot::FrontImage& a, const robot::FrontImage& b) { return Same(a.image, b.image); }
bool Same(const robot::StereoPair& a, const robot::StereoPair& b) {
  return Same(a.left, b.left) && Same(a.right, b.right);
}
bool Same(const robot::LaserRevolution& a, const robot::LaserRevolution& b) {
  if (a.samples.empty() || a.samples.size() != b.samples.size()) return false;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    if (a.samples[i].range_m != b.samples[i].range_m || a.samples[i].status != b.samples[i].status)
      return false;
  }
  return true;
}
bool Same(const robot::IrRanges& a, const robot::IrRanges& b) {
  return a.up.value == b.up.value && a.left.value == b.left.value && a.right.value == b.right.value;
}
bool Same(const robot::InertialReading& a, const robot::InertialReading& b) {
  return a.angular_velocity_rad_s == b.angular_velocity_rad_s &&
         a.specific_force_m_s2 == b.specific_force_m_s2;
}
bool Same(const robot::Inclination& a, const robot::Inclination& b) {
  return a.roll_rad == b.roll_rad && a.pitch_rad == b.pitch_rad;
}
template <typename Other>
bool Same(const Other&, const Other&) {
  return false;  // may well repeat itself
}

}  // namespace

Repetition::Repetition(int readings) : readings_(readings) {
  if (readings < 2) throw std::invalid_argument("one reading is no repetition");
}

bool Repetition::IsStuck(const robot::Reading& reading) {
  if (std::holds_alternative<robot::Loss>(reading.value)) return false;
  Said& said = said_[static_cast<std::size_t>(robot::SensorOf(reading))];
  const bool same = said.last && std::visit(
                                     [&](const auto& value) {
                                       using Value = std::decay_t<decltype(value)>;
                                       const auto* last = std::get_if<Value>(&said.last->value);
                                       return last != nullptr && Same(*last, value);
                                     },
                                     reading.value);
  said.times = same ? said.times + 1 : 1;
  if (!same) said.last = reading;
  return said.times >= readings_;
}

}  // namespace kantaro::perception
