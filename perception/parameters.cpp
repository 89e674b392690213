#include "perception/parameters.hpp"

#include <array>
#include <numbers>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "base/files.hpp"
#include "base/yaml.hpp"

namespace kantaro::perception {
namespace {

double Metres(const YamlNode& node, double low_mm, double high_mm) {
  return node.Number(low_mm, high_mm) / 1000;
}

/// One of several names. @param what  they name, "an edge operator"
template <typename Value>
Value ReadName(const YamlNode& node, std::span<const std::pair<const char*, Value>> names,
               const char* what) {
  const std::string text = node.Text();
  std::string known;
  for (const auto& [name, value] : names) {
    if (text == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw node.Error("\"" + text.substr(0, 40) + "\" is not " + what + "; there are " + known);
}

LaserParameters ReadLaser(const YamlNode& node) {
  static constexpr std::array<std::pair<const char*, LaserMethod>, 2> kMethods{
      {{"thesis", LaserMethod::kThesis}, {"ours", LaserMethod::kOurs}}};
  node.AllowOnly({"method", "threshold_mm", "window_deg", "far_limit_mm", "revolutions"});
  LaserParameters laser;
  laser.method = ReadName<LaserMethod>(node["method"], kMethods, "a way to read the laser");
  laser.threshold_m = Metres(node["threshold_mm"], 1, 10000);
  laser.window_rad = node["window_deg"].Number(0.1, 90) * std::numbers::pi / 180;
  laser.far_limit_m = Metres(node["far_limit_mm"], 1, 10000);
  laser.revolutions = static_cast<int>(node["revolutions"].Integer(1, 1000));
  if (laser.far_limit_m <= laser.threshold_m) {
    throw node["far_limit_mm"].Error("must be above threshold_mm, or nothing is ever open");
  }
  return laser;
}

IrParameters ReadIr(const YamlNode& node) {
  node.AllowOnly({"manhole_threshold", "junction_threshold", "readings"});
  IrParameters ir;
  ir.manhole_threshold = node["manhole_threshold"].Number(0, 1);
  ir.junction_threshold = node["junction_threshold"].Number(0, 1);
  ir.readings = static_cast<int>(node["readings"].Integer(1, 1000));
  return ir;
}

/// Reads near_mm and far_mm.
std::pair<double, double> ReadReach(const YamlNode& node) {
  const double near_m = Metres(node["near_mm"], 50, 10000),
               far_m = Metres(node["far_mm"], 50, 10000);
  if (far_m <= near_m) throw node["far_mm"].Error("must be above near_mm");
  return {near_m, far_m};
}

RingParameters ReadRings(const YamlNode& node) {
  node.AllowOnly({"near_mm", "far_mm", "center_search_px", "groove_mm", "joint_contrast",
                  "mouth_contrast", "min_significance", "support_contrast", "joint_min_support",
                  "mouth_min_support"});
  RingParameters rings;
  std::tie(rings.near_m, rings.far_m) = ReadReach(node);
  rings.center_search_px = static_cast<int>(node["center_search_px"].Integer(0, 100));
  rings.groove_m = Metres(node["groove_mm"], 0, 1000);
  rings.joint_contrast = node["joint_contrast"].Number(0.001, 10);
  rings.mouth_contrast = node["mouth_contrast"].Number(0.001, 10);
  rings.min_significance = node["min_significance"].Number(0, 1000);
  rings.support_contrast = node["support_contrast"].Number(0, 10);
  rings.joint_min_support = node["joint_min_support"].Number(0, 1);
  rings.mouth_min_support = node["mouth_min_support"].Number(0, 1);
  return rings;
}

EdgeOperator ReadOperator(const YamlNode& node) {
  static constexpr std::array<std::pair<const char*, EdgeOperator>, 3> kNames{
      {{"sobel", EdgeOperator::kSobel},
       {"prewitt", EdgeOperator::kPrewitt},
       {"laplacian", EdgeOperator::kLaplacian}}};
  return ReadName<EdgeOperator>(node, kNames, "an edge operator");
}

FaultParameters ReadFaults(const YamlNode& node) {
  node.AllowOnly({"near_mm", "far_mm", "edge_operator", "gaussian_px", "edge_gain",
                  "equalize_brightness", "horizontal_threshold", "vertical_threshold",
                  "ignore_joints", "joint_margin_px"});
  FaultParameters faults;
  std::tie(faults.near_m, faults.far_m) = ReadReach(node);
  faults.edge_operator = ReadOperator(node["edge_operator"]);
  faults.gaussian_px = node["gaussian_px"].Number(0.1, 50);
  faults.edge_gain = node["edge_gain"].Number(0.001, 1000);
  faults.equalize_brightness = node["equalize_brightness"].Boolean();
  faults.horizontal_threshold = node["horizontal_threshold"].Number(0, 1);
  faults.vertical_threshold = node["vertical_threshold"].Number(0, 1);
  faults.ignore_joints = node["ignore_joints"].Boolean();
  faults.joint_margin_px = node["joint_margin_px"].Number(0, 1000);
  return faults;
}

int ReadOdd(const YamlNode& node, int low, int high) {
  const auto value = static_cast<int>(node.Integer(low, high));
  if (value % 2 == 0) throw node.Error("must be odd: a window has a pixel in its middle");
  return value;
}

stereo::Parameters ReadStereo(const YamlNode& node) {
  using stereo::CornerDisparity;
  using stereo::FunctionValueConstraint;
  static constexpr std::array<std::pair<const char*, FunctionValueConstraint>, 3> kConstraints{
      {{"as-written", FunctionValueConstraint::kAsWritten},
       {"off", FunctionValueConstraint::kOff},
       {"inverted", FunctionValueConstraint::kInverted}}};
  static constexpr std::array<std::pair<const char*, CornerDisparity>, 2> kCorners{
      {{"combined", CornerDisparity::kCombined}, {"average", CornerDisparity::kAverage}}};
  node.AllowOnly({"method", "min_disparity_px", "disparities", "subpixel", "gaussian_window_px",
                  "gaussian_px", "window_px", "least_deviation", "feature_threshold",
                  "function_value_constraint", "peak_ratio", "neighbour_threshold_px", "ssd_scale",
                  "gradient_scale", "corner_disparity", "corner_support", "steepest_wall"});
  stereo::Parameters p;
  p.method = ReadName(node["method"], stereo::Methods(), "a matching method");
  p.min_disparity_px = static_cast<int>(node["min_disparity_px"].Integer(0, 4096));
  p.disparities = static_cast<int>(node["disparities"].Integer(1, stereo::kMostDisparities));
  p.subpixel = node["subpixel"].Boolean();
  p.gaussian_window_px = ReadOdd(node["gaussian_window_px"], 1, 31);
  p.gaussian_px = node["gaussian_px"].Number(0.1, 100);
  p.window_px = ReadOdd(node["window_px"], 3, 11);
  p.least_deviation = node["least_deviation"].Number(0, 255);
  p.feature_threshold = static_cast<int>(node["feature_threshold"].Integer(1, 255));
  p.function_value_constraint = ReadName<FunctionValueConstraint>(
      node["function_value_constraint"], kConstraints, "a function-value constraint");
  p.peak_ratio = node["peak_ratio"].Number(0, 1e6);
  p.neighbour_threshold_px = node["neighbour_threshold_px"].Number(0, 1e6);
  p.ssd_scale = node["ssd_scale"].Number(0.01, 1e6);
  p.gradient_scale = node["gradient_scale"].Number(0.01, 1e6);
  p.corner_disparity =
      ReadName<CornerDisparity>(node["corner_disparity"], kCorners, "a corner's disparity");
  p.corner_support = static_cast<int>(node["corner_support"].Integer(0, 8));
  p.steepest_wall = node["steepest_wall"].Number(0, 1000);
  return p;
}

LandmarkParameters ReadLandmarks(const YamlNode& node) {
  static constexpr std::array<std::pair<const char*, LandmarkMethod>, 2> kMethods{
      {{"thesis", LandmarkMethod::kThesis}, {"ours", LandmarkMethod::kOurs}}};
  node.AllowOnly({"mono_method", "stereo_method", "near_mm", "far_mm", "circle_low", "circle_high",
                  "canny_low", "canny_high", "shorter_high", "longer_high"});
  LandmarkParameters p;
  p.mono = ReadName<LandmarkMethod>(node["mono_method"], kMethods, "a landmark method");
  p.stereo = ReadName<LandmarkMethod>(node["stereo_method"], kMethods, "a landmark method");
  std::tie(p.near_m, p.far_m) = ReadReach(node);
  const auto threshold = [&](const char* key) {
    return static_cast<int>(node[key].Integer(1, 10000));
  };
  p.circle_low = threshold("circle_low");
  p.circle_high = threshold("circle_high");
  p.canny_low = threshold("canny_low");
  p.canny_high = threshold("canny_high");
  p.shorter_high = threshold("shorter_high");
  p.longer_high = threshold("longer_high");
  return p;
}

}  // namespace

Parameters ReadParameters(const std::filesystem::path& file) {
  return ParseParameters(ReadInputFile(file), file);
}

Parameters ParseParameters(const std::string& text, const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"laser", "infrared", "rings", "faults", "stereo", "landmarks", "stuck_readings"});
  return {ReadLaser(root["laser"]),
          ReadIr(root["infrared"]),
          ReadRings(root["rings"]),
          ReadFaults(root["faults"]),
          ReadStereo(root["stereo"]),
          ReadLandmarks(root["landmarks"]),
          static_cast<int>(root["stuck_readings"].Integer(2, 1000))};
}

}  // namespace kantaro::perception
