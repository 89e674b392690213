#include "perception/landmark_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "base/files.hpp"
#include "base/yaml.hpp"

namespace kantaro::perception {
namespace {

constexpr std::size_t kMostEntries = 1000;

RadiusTable ReadTable(const YamlNode& node) {
  RadiusTable table;
  for (const YamlNode& entry : node.Elements()) {
    const std::vector<double> pair = entry.Numbers(2);
    const double distance_m = pair[0] / 1000.0, radius_px = pair[1];
    if (!(distance_m > 0.0 && radius_px > 0.0)) {
      throw entry.Error("must be a distance in mm and a radius in px, both above 0");
    }
    if (!table.distance_radius.empty() && (distance_m <= table.distance_radius.back().first ||
                                           radius_px >= table.distance_radius.back().second)) {
      throw entry.Error("distances must rise and radii fall from entry to entry");
    }
    table.distance_radius.emplace_back(distance_m, radius_px);
  }
  if (table.distance_radius.size() < 2 || table.distance_radius.size() > kMostEntries) {
    throw node.Error(fmt::format("must hold 2 to {} entries", kMostEntries));
  }
  return table;
}

EdgeFit ReadEdgeFit(const YamlNode& node) {
  node.AllowOnly({"at_none_mm", "per_edge_mm"});
  return {node["at_none_mm"].Number(-1e6, 1e6) / 1000.0,
          node["per_edge_mm"].Number(-1e6, 1e6) / 1000.0};
}

ErrorFit ReadErrorFit(const YamlNode& node) {
  node.AllowOnly({"bias_percent", "deviation_factor"});
  return {node["bias_percent"].Number(-50.0, 50.0) / 100.0,
          node["deviation_factor"].Number(0.001, 1000.0)};
}

ClassCalibration ReadClass(const YamlNode& node) {
  node.AllowOnly({"thesis_radius", "thesis_shorter", "thesis_longer", "ours_mono", "ours_stereo"});
  return {ReadTable(node["thesis_radius"]), ReadEdgeFit(node["thesis_shorter"]),
          ReadEdgeFit(node["thesis_longer"]), ReadErrorFit(node["ours_mono"]),
          ReadErrorFit(node["ours_stereo"])};
}

std::string Write(const EdgeFit& fit) {
  return fmt::format("{{at_none_mm: {:.2f}, per_edge_mm: {:.5f}}}", 1000.0 * fit.at_none_m,
                     1000.0 * fit.per_edge_m);
}

std::string Write(const ErrorFit& fit) {
  return fmt::format("{{bias_percent: {:.3f}, deviation_factor: {:.3f}}}", 100.0 * fit.bias,
                     fit.factor);
}

}  // namespace

LandmarkClass ClassOf(LandmarkKind kind) {
  return kind == LandmarkKind::kManhole ? LandmarkClass::kManhole
         : kind == LandmarkKind::kJoint ? LandmarkClass::kJoint
                                        : LandmarkClass::kInlet;
}

const char* ToString(LandmarkClass landmark) {
  return landmark == LandmarkClass::kManhole ? "manhole"
         : landmark == LandmarkClass::kJoint ? "joint"
                                             : "inlet";
}

double RadiusTable::DistanceAt(double radius_px) const {
  if (distance_radius.size() < 2) throw std::invalid_argument("radius table: needs two entries");
  const auto farther =
      std::find_if(distance_radius.begin() + 1, distance_radius.end() - 1,
                   [radius_px](const auto& entry) { return entry.second <= radius_px; });
  const auto& [far_m, far_px] = *farther;
  const auto& [near_m, near_px] = *(farther - 1);
  const double share = (1.0 / radius_px - 1.0 / near_px) / (1.0 / far_px - 1.0 / near_px);
  return near_m + share * (far_m - near_m);
}

const ClassCalibration& LandmarkCalibration::Of(LandmarkKind kind) const {
  return classes[static_cast<std::size_t>(ClassOf(kind))];
}

LandmarkCalibration ReadLandmarkCalibration(const std::filesystem::path& file) {
  return ParseLandmarkCalibration(ReadInputFile(file), file);
}

LandmarkCalibration ParseLandmarkCalibration(const std::string& text,
                                             const std::filesystem::path& name) {
  const YamlNode root = YamlNode::Parse(text, name);
  root.AllowOnly({"manhole", "joint", "inlet"});
  LandmarkCalibration calibration;
  for (const LandmarkClass landmark : kLandmarkClasses) {
    calibration.classes[static_cast<std::size_t>(landmark)] = ReadClass(root[ToString(landmark)]);
  }
  return calibration;
}

std::string ToYaml(const LandmarkCalibration& calibration, const std::string& remark) {
  std::string text = "# " + remark + "\n";
  for (const LandmarkClass landmark : kLandmarkClasses) {
    const ClassCalibration& one = calibration.classes[static_cast<std::size_t>(landmark)];
    text += fmt::format("{}:\n  thesis_radius:  # [distance in mm, radius in px], thesis 4.3\n",
                        ToString(landmark));
    for (const auto& [distance_m, radius_px] : one.radius.distance_radius)
      text += fmt::format("    - [{:.2f}, {:.2f}]\n", 1000.0 * distance_m, radius_px);
    text += "  thesis_shorter: " + Write(one.shorter) + "  # thesis fig 5.25\n";
    text += "  thesis_longer: " + Write(one.longer) + "\n";
    text += "  ours_mono: " + Write(one.mono) + "\n";
    text += "  ours_stereo: " + Write(one.stereo) + "\n";
  }
  return text;
}

}  // namespace kantaro::perception
