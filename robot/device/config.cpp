#include "robot/device/config.hpp"

#include <fmt/format.h>
#include <cmath>

#include "base/files.hpp"
#include "base/yaml.hpp"
#include "robot/device/line.hpp"

namespace kantaro::robot {
namespace {

constexpr std::size_t kLargestConfig = 1 << 16;
constexpr double kLongestPatience_s = 60.0;

RunTime Duration(const YamlNode& node) {
  return RunTime(std::llround(node.Number(0.01, kLongestPatience_s) * 1e9));
}

std::filesystem::path PathIn(const YamlNode& node) {
  return node.file().parent_path() / node.Text();
}

DeviceConfig::SerialLine ReadLine(const YamlNode& node) {
  node.AllowOnly({"line", "bits_per_s"});
  const int bits_per_s = static_cast<int>(node["bits_per_s"].Integer(1, 100'000'000));
  if (!IsSerialSpeed(bits_per_s)) {
    throw node["bits_per_s"].Error(
        "a serial line has one of 115200, 230400, 460800, 921600, 1000000, 2000000");
  }
  return {PathIn(node["line"]), bits_per_s, node.line()};
}

StampClock ReadStamps(const YamlNode& node) {
  const std::string word = node.Text();
  if (word == "controller") return StampClock::kController;
  if (word == "host") return StampClock::kHost;
  if (word == "none") return StampClock::kNone;
  throw node.Error(fmt::format("\"{:.40}\" is none of controller, host, none", word));
}

DeviceConfig::Camera ReadCamera(const YamlNode& node) {
  node.AllowOnly({"video", "stream", "stamps"});
  if (node.Find("video").has_value() == node.Find("stream").has_value()) {
    throw node.Error("either \"video\", a number, or \"stream\", a file or pipe, is wanted");
  }
  DeviceConfig::Camera camera;
  if (const auto video = node.Find("video")) {
    camera.source = static_cast<int>(video->Integer(0, 255));
  } else {
    camera.source = PathIn(node["stream"]);
  }
  camera.stamps = ReadStamps(node["stamps"]);
  camera.config_line = node.line();
  return camera;
}

std::map<Sensor, RunTime> ReadPatience(const YamlNode& node) {
  std::map<Sensor, RunTime> patience;
  for (const auto& [name, value] : node.Entries()) {
    std::string known;
    for (std::size_t i = 0; i < kSensorCount; ++i) {
      const auto sensor = static_cast<Sensor>(i);
      if (name == ToString(sensor)) patience[sensor] = Duration(value);
      known += fmt::format("{}{}", i == 0 ? "" : ", ", ToString(sensor));
    }
    if (known.find(name) == std::string::npos) {
      throw value.Error(fmt::format("\"{:.40}\" is no sensor; known are {}", name, known));
    }
  }
  return patience;
}

}  // namespace

const char* ToString(CameraPort camera) {
  switch (camera) {
    case CameraPort::kFront:
      return "front";
    case CameraPort::kStereoLeft:
      return "stereo_left";
    case CameraPort::kStereoRight:
      return "stereo_right";
  }
  return "";
}

DeviceConfig ParseDeviceConfig(const std::string& text, const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"controller", "laser", "cameras", "silent_after_s", "line_silent_after_s",
                  "answer_within_s"});
  DeviceConfig config;
  config.file = name;
  config.controller = ReadLine(root["controller"]);
  if (const auto laser = root.Find("laser")) config.laser = ReadLine(*laser);
  if (const auto cameras = root.Find("cameras")) {
    cameras->AllowOnly({"front", "stereo_left", "stereo_right"});
    for (std::size_t i = 0; i < kCameraPorts; ++i) {
      if (const auto camera = cameras->Find(ToString(static_cast<CameraPort>(i)))) {
        config.cameras[i] = ReadCamera(*camera);
      }
    }
    if (config.cameras[1].has_value() != config.cameras[2].has_value()) {
      throw cameras->Error("one stereo camera stands here without the other");
    }
  }
  if (const auto patience = root.Find("silent_after_s")) config.patience = ReadPatience(*patience);
  if (const auto line = root.Find("line_silent_after_s")) config.line_patience = Duration(*line);
  if (const auto answer = root.Find("answer_within_s")) config.answer_within = Duration(*answer);
  return config;
}

DeviceConfig ReadDeviceConfig(const std::filesystem::path& file) {
  return ParseDeviceConfig(ReadInputFile(file, kLargestConfig), file);
}

}  // namespace kantaro::robot
