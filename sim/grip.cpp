#include "sim/grip.hpp"

#include "base/yaml.hpp"

namespace kantaro::sim {
namespace {

constexpr std::array<const char*, kGroundCount> kGrounds{"pvc", "clay", "concrete", "lined",
                                                         "sediment"};
constexpr std::array<const char*, kConditionCount> kConditions{"dry", "wet", "slimy"};

Grip ReadGrip(const YamlNode& node) {
  node.AllowOnly(
      {"tyre_friction", "hull_friction", "rolling_resistance_mm", "infrared_return", "source"});
  if (node["source"].Text().size() < 5) throw node["source"].Error("say where the values are from");
  return {node["tyre_friction"].Number(0.01, 2.0), node["hull_friction"].Number(0.01, 2.0),
          node["rolling_resistance_mm"].Number(0.0, 20.0) / 1000.0,
          node["infrared_return"].Number(0.01, 10.0)};
}

GripTable ReadTable(const YamlNode& root) {
  root.AllowOnly({"pvc", "clay", "concrete", "lined", "sediment"});
  GripTable table;
  for (std::size_t i = 0; i < kGroundCount; ++i) {
    const YamlNode ground = root[kGrounds[i]];
    ground.AllowOnly({"dry", "wet", "slimy"});
    for (std::size_t k = 0; k < kConditionCount; ++k) {
      const YamlNode node = ground[kConditions[k]];
      table.grips[i][k] = ReadGrip(node);
      if (k > 0 && table.grips[i][k].tyre_friction > table.grips[i][k - 1].tyre_friction) {
        throw node["tyre_friction"].Error(
            "a tyre grips dry walls best and slimy ones least: no more than the condition before");
      }
    }
  }
  return table;
}

}  // namespace

Ground GroundOf(network::Material material) { return static_cast<Ground>(material); }

GripTable ReadGripTable(const std::filesystem::path& file) {
  return ReadTable(YamlNode::Load(file));
}

GripTable ParseGripTable(const std::string& text, const std::filesystem::path& name) {
  return ReadTable(YamlNode::Parse(text, name));
}

}  // namespace kantaro::sim
