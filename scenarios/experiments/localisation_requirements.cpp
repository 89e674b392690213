#include "scenarios/experiments/localisation_requirements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

struct Requirement {
  const char* set;
  const char* condition;
  const char* key;
  double least, most;
};
/// Of `ours`, all landmarks together.
constexpr std::array<Requirement, 6> kRequired{{
    {"reproduction", "all", "within_5cm", 0.99, 1.0},
    {"stress", "all", "within_5cm", 0.97, 1.0},
    {"reproduction", "up to 1.0 m", "within_2cm", 0.95, 1.0},
    {"stress", "up to 1.0 m", "within_2cm", 0.95, 1.0},
    {"reproduction", "all", "in_stated_interval", 0.90, 0.98},
    {"stress", "all", "in_stated_interval", 0.90, 0.98},
}};

bool Asks(const Requirement& required, const Json& row) {
  return row.at("method") == "ours" && row.at("landmark") == "all" &&
         row.at("set") == required.set && row.at("condition") == required.condition;
}

bool IsMet(const Requirement& required, const Json& row) {
  const Json& value = row.at(required.key);
  return value.is_number() && value.get<double>() >= required.least &&
         value.get<double>() <= required.most;
}

}  // namespace

std::string PercentText(const Json& row, const char* key) {
  return row.at(key).is_null() ? "–" : fmt::format("{:.1f} %", 100.0 * row.at(key).get<double>());
}

bool FailsRequirement(const Json& row) {
  return std::ranges::any_of(kRequired, [&](const Requirement& required) {
    return Asks(required, row) && !IsMet(required, row);
  });
}

bool MeetsRequirements(const Json& rows) {
  return std::ranges::all_of(kRequired, [&](const Requirement& required) {
    return std::ranges::any_of(
        rows, [&](const Json& row) { return Asks(required, row) && IsMet(required, row); });
  });
}

std::string RequirementsText(const Json& rows) {
  std::string required_text;
  for (const Requirement& required : kRequired) {
    for (const Json& row : rows) {
      if (!Asks(required, row)) continue;
      required_text += fmt::format("- {}, {}: `{}` {:.0f} to {:.0f} %: {}, {}\n", required.set,
                                   required.condition, required.key, 100.0 * required.least,
                                   100.0 * required.most, PercentText(row, required.key),
                                   IsMet(required, row) ? "met" : "**not met**");
    }
  }
  if (required_text.empty()) return "";
  return "\nRequired of `ours`, all landmarks together:\n\n" + required_text;
}

}  // namespace kantaro::scenarios
