#include "perception/parameters.hpp"

#include <array>
#include <numbers>
#include <tuple>
#include <utility>

#include "base/yaml.hpp"

namespace kantaro::perception {
namespace {

double Metres(const YamlNode& node, double low_mm, double high_mm) {
  return node.Number(low_mm, high_mm) / 1000;
}

LaserParameters ReadLaser(const YamlNode& node) {
  node.AllowOnly({"threshold_mm", "window_deg", "far_limit_mm", "revolutions"});
  LaserParameters laser;
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
  const std::string text = node.Text();
  for (const auto& [name, value] : kNames) {
    if (text == name) return value;
  }
  throw node.Error("\"" + text.substr(0, 40) +
                   "\" is no edge operator; there are sobel, prewitt, laplacian");
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

}  // namespace

Parameters ReadParameters(const std::filesystem::path& file) {
  const YamlNode root = YamlNode::Load(file);
  root.AllowOnly({"laser", "infrared", "rings", "faults"});
  return {ReadLaser(root["laser"]), ReadIr(root["infrared"]), ReadRings(root["rings"]),
          ReadFaults(root["faults"])};
}

}  // namespace kantaro::perception
