#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <array>
#include <string>

namespace kantaro::robot {

/// A stamped row of named numbers, for readings that no ROS message fits. A bag carries the
/// definition of its messages, so any reader understands these too.
template <typename Layout>
struct Row {
  std_msgs::Header header;
  std::array<double, Layout::kNames.size()> values{};
};

/// The three IR values, 0 to 1 (thesis 4.3).
struct InfraredLayout {
  static constexpr const char* kType = "kantaro_msgs/Infrared";
  static constexpr const char* kMd5 = "ae514c2d459757832db1e8c665e34100";  ///< of its definition
  static constexpr std::array kNames{"up", "left", "right"};
};

/// What the robot was told: wheel speeds [rad/s] and the lights' brightness, 0 to 1.
struct CommandLayout {
  static constexpr const char* kType = "kantaro_msgs/Command";
  static constexpr const char* kMd5 = "1348a1d9df9ac8b523dc5a2631b73d4e";
  static constexpr std::array kNames{"left_rad_s", "right_rad_s", "lights"};
};

/// How the base lies against gravity [rad].
struct InclinationLayout {
  static constexpr const char* kType = "kantaro_msgs/Inclination";
  static constexpr const char* kMd5 = "5915e330ca7976ae91c8b8d717f3198c";
  static constexpr std::array kNames{"roll_rad", "pitch_rad"};
};

/// Heading from magnetic north, clockwise from above [rad]; `disturbed` is 0 or 1.
struct CompassLayout {
  static constexpr const char* kType = "kantaro_msgs/Compass";
  static constexpr const char* kMd5 = "96b0936274b4307b06f8bff5fd4418b0";
  static constexpr std::array kNames{"heading_rad", "disturbed"};
};

/// The pack: terminal voltage, current drawn, charge left, 0 to 1.
struct BatteryLayout {
  static constexpr const char* kType = "kantaro_msgs/Battery";
  static constexpr const char* kMd5 = "e813db0668cf37e882bc575ae010ecec";
  static constexpr std::array kNames{"voltage_V", "current_A", "charge"};
};

/// Readings that were due and did not come: the sensor's number in robot::Sensor, how many, and
/// whether its line is down, 0 or 1.
struct LossLayout {
  static constexpr const char* kType = "kantaro_msgs/Loss";
  static constexpr const char* kMd5 = "0200073093b7c041de15f97a91e3b635";
  static constexpr std::array kNames{"sensor", "readings", "line_down"};
};

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
      std::string text = "Header header\n";
      for (const char* name : Layout::kNames) text += std::string("float64 ") + name + "\n";
      return text + std::string(80, '=') + "\nMSG: std_msgs/Header\n" +
             Definition<std_msgs::Header>::value();
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
    for (auto& value : row.values) stream.next(value);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace ros::serialization
