#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace kantaro::robot {

/// A stamped row of named fields, for what no ROS message fits. A bag carries the definition of its
/// messages, so any reader understands these too.
template <typename Layout>
struct Row {
  std_msgs::Header header;
  typename Layout::Values values{};
};

/// What a field is called in a message definition.
template <typename Value>
inline constexpr const char* kRosType = nullptr;
template <>
inline constexpr const char* kRosType<double> = "float64";
template <>
inline constexpr const char* kRosType<std::string> = "string";
template <>
inline constexpr const char* kRosType<std::vector<double>> = "float64[]";
template <>
inline constexpr const char* kRosType<std::vector<std::uint8_t>> = "uint8[]";

/// The three IR values, 0 to 1 (thesis 4.3).
struct InfraredLayout {
  static constexpr const char* kType = "kantaro_msgs/Infrared";
  static constexpr const char* kMd5 = "ae514c2d459757832db1e8c665e34100";  ///< of its definition
  static constexpr std::array kNames{"up", "left", "right"};
  using Values = std::array<double, 3>;
};

/// One turn of the laser's mirror as it was measured: what a scan of 32-bit numbers and one
/// increment cannot hold. `status` is that of robot::RangeStatus.
struct LaserLayout {
  static constexpr const char* kType = "kantaro_msgs/LaserSamples";
  static constexpr const char* kMd5 = "5a1185fdc5e8731ef6524e1a2912757a";
  static constexpr std::array kNames{"angle_rad", "range_m", "status"};
  using Values = std::tuple<std::vector<double>, std::vector<double>, std::vector<std::uint8_t>>;
};

/// What the robot was told: wheel speeds [rad/s] and the lights' brightness, 0 to 1; and what
/// became of it, in the numbers of robot::CommandOutcome.
struct CommandLayout {
  static constexpr const char* kType = "kantaro_msgs/Command";
  static constexpr const char* kMd5 = "5760b5542a37218745718c8fe10f9f9f";
  static constexpr std::array kNames{"left_rad_s", "right_rad_s", "lights", "outcome"};
  using Values = std::array<double, 4>;
};

/// Where the robot believed to be, in its own terms.
struct EstimateLayout {
  static constexpr const char* kType = "kantaro_msgs/Estimate";
  static constexpr const char* kMd5 = "8c29f606f33c008ae2bc5f33545b7a3e";
  static constexpr std::array kNames{"leg", "distance_m", "deviation_m", "leg_length_m"};
  using Values = std::array<double, 4>;
};

/// How the base lies against gravity [rad].
struct InclinationLayout {
  static constexpr const char* kType = "kantaro_msgs/Inclination";
  static constexpr const char* kMd5 = "5915e330ca7976ae91c8b8d717f3198c";
  static constexpr std::array kNames{"roll_rad", "pitch_rad"};
  using Values = std::array<double, 2>;
};

/// Heading from magnetic north, clockwise from above [rad]; `disturbed` is 0 or 1.
struct CompassLayout {
  static constexpr const char* kType = "kantaro_msgs/Compass";
  static constexpr const char* kMd5 = "96b0936274b4307b06f8bff5fd4418b0";
  static constexpr std::array kNames{"heading_rad", "disturbed"};
  using Values = std::array<double, 2>;
};

/// The pack: terminal voltage, current drawn, charge left, 0 to 1.
struct BatteryLayout {
  static constexpr const char* kType = "kantaro_msgs/Battery";
  static constexpr const char* kMd5 = "e813db0668cf37e882bc575ae010ecec";
  static constexpr std::array kNames{"voltage_V", "current_A", "charge"};
  using Values = std::array<double, 3>;
};

/// Readings that were due and did not come: the sensor's number in robot::Sensor, how many, and
/// whether its line is down, 0 or 1.
struct LossLayout {
  static constexpr const char* kType = "kantaro_msgs/Loss";
  static constexpr const char* kMd5 = "0200073093b7c041de15f97a91e3b635";
  static constexpr std::array kNames{"sensor", "readings", "line_down"};
  using Values = std::array<double, 3>;
};

/// A piece of text and what it is: a file of the mission, or an event.
struct NoteLayout {
  static constexpr const char* kType = "kantaro_msgs/Note";
  static constexpr const char* kMd5 = "c9106a5aadde1f359fceb1d0e2ed98d9";
  static constexpr std::array kNames{"kind", "text"};
  using Values = std::array<std::string, 2>;
};

/// The lines that define a layout's fields.
template <typename Layout>
std::string FieldLines() {
  std::string text;
  std::size_t i = 0;
  const auto line = [&](const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    static_assert(kRosType<Value> != nullptr);
    text += std::string(kRosType<Value>) + " " + Layout::kNames[i++] + "\n";
  };
  std::apply([&](const auto&... values) { (line(values), ...); }, typename Layout::Values{});
  return text;
}

}  // namespace kantaro::robot

namespace ros::message_traits {

template <typename Layout>
struct MD5Sum<kantaro::robot::Row<Layout>> {
  static const char* value() { return Layout::kMd5; }
  static const char* value(const kantaro::robot::Row<Layout>& /*row*/) { return value(); }
};

template <typename Layout>
struct DataType<kantaro::robot::Row<Layout>> {
  static const char* value() { return Layout::kType; }
  static const char* value(const kantaro::robot::Row<Layout>& /*row*/) { return value(); }
};

template <typename Layout>
struct Definition<kantaro::robot::Row<Layout>> {
  static const char* value() {
    static const std::string kText = [] {
      return "Header header\n" + kantaro::robot::FieldLines<Layout>() + std::string(80, '=') +
             "\nMSG: std_msgs/Header\n" + Definition<std_msgs::Header>::value();
    }();
    return kText.c_str();
  }
  static const char* value(const kantaro::robot::Row<Layout>& /*row*/) { return value(); }
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <typename Layout>
struct Serializer<kantaro::robot::Row<Layout>> {
  template <typename Stream, typename Self>
  static void allInOne(Stream& stream, Self row) {
    stream.next(row.header);
    std::apply([&](auto&... values) { (stream.next(values), ...); }, row.values);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace ros::serialization
