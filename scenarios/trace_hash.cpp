#include "scenarios/trace_hash.hpp"

#include <cstdint>
#include <span>
#include <type_traits>

namespace kantaro::scenarios {
namespace {

/// Feeds values byte by byte; only types without padding.
class Feed {
 public:
  explicit Feed(Sha256& sha) : sha_(sha) {}

  template <typename... Values>
  void Numbers(const Values&... values) {
    (Number(values), ...);
  }
  void operator()(const robot::FrontImage& front) { Image(front.image); }
  void operator()(const robot::StereoPair& pair) {
    Image(pair.left);
    Image(pair.right);
  }
  void operator()(const robot::LaserRevolution& revolution) {
    Numbers(std::uint64_t{revolution.samples.size()});
    for (const robot::LaserSample& sample : revolution.samples) {
      Numbers(sample.angle_rad, sample.range_m, static_cast<std::uint8_t>(sample.status));
    }
  }
  void operator()(const robot::IrRanges& ranges) {
    Numbers(ranges.up.value, ranges.left.value, ranges.right.value);
  }
  void operator()(const robot::WheelEncoders& encoders) {
    for (const double angle_rad : encoders.angle_rad) Number(angle_rad);
  }
  void operator()(const robot::InertialReading& inertial) {
    for (int i = 0; i < 3; ++i)
      Numbers(inertial.angular_velocity_rad_s[i], inertial.specific_force_m_s2[i]);
  }
  void operator()(const robot::Inclination& inclination) {
    Numbers(inclination.roll_rad, inclination.pitch_rad);
  }
  void operator()(const robot::CompassHeading& compass) {
    Numbers(compass.heading_rad, compass.disturbed);
  }
  void operator()(const robot::BatteryState& battery) {
    Numbers(battery.voltage_V, battery.current_A, battery.charge);
  }
  void operator()(const robot::Loss& loss) {
    Numbers(static_cast<std::uint8_t>(loss.sensor), loss.readings, loss.line_down);
  }

 private:
  template <typename Value>
  void Number(const Value& value) {
    static_assert(std::is_arithmetic_v<Value>);
    sha_.Add(std::as_bytes(std::span(&value, 1)));
  }
  void Image(const cv::Mat& image) {
    Numbers(image.rows, image.cols, image.type());
    const std::size_t row_bytes = image.elemSize() * static_cast<std::size_t>(image.cols);
    for (int row = 0; row < image.rows; ++row)
      sha_.Add(std::as_bytes(std::span(image.ptr(row), row_bytes)));
  }

  Sha256& sha_;
};

enum class Kind : std::uint8_t { kReading, kCommand, kEstimate };

}  // namespace

void TraceHash::Add(const robot::Reading& reading) {
  Feed feed(sha_);
  feed.Numbers(static_cast<std::uint8_t>(Kind::kReading),
               static_cast<std::uint8_t>(reading.value.index()), reading.captured_at.count(),
               reading.arrived_at.count());
  std::visit(feed, reading.value);
}

void TraceHash::Add(const robot::Command& command) {
  Feed(sha_).Numbers(static_cast<std::uint8_t>(Kind::kCommand), command.left_rad_s,
                     command.right_rad_s, command.lights);
}

void TraceHash::Add(const navigation::Estimate& estimate) {
  Feed(sha_).Numbers(static_cast<std::uint8_t>(Kind::kEstimate), std::uint64_t{estimate.leg},
                     estimate.distance_m, estimate.deviation_m, estimate.leg_length_m);
}

}  // namespace kantaro::scenarios
