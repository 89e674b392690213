#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

// What the experiments on landmarks ahead ask of our method, and whether rows of theirs show it.
namespace kantaro::scenarios {

/// "98.1 %", or a dash for null.
[[nodiscard]] std::string PercentText(const nlohmann::ordered_json& row, const char* key);

/// Whether something is asked of this row that it does not reach.
[[nodiscard]] bool FailsRequirement(const nlohmann::ordered_json& row);
/// What no row tells is not met: so few views may have none up to 1.0 m.
[[nodiscard]] bool MeetsRequirements(const nlohmann::ordered_json& rows);
/// A list in Markdown of what is asked of these rows and what they show; empty without `ours`.
[[nodiscard]] std::string RequirementsText(const nlohmann::ordered_json& rows);

}  // namespace kantaro::scenarios
