#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace kantaro::scenarios {

/// Errors over distances as an SVG picture: a panel for each set and method that `result` holds
/// points of. Errors beyond 0.2 m and views without an answer lie on the upper edge.
/// @param result  of mono-localisation or stereo-localisation
[[nodiscard]] std::string PlotErrors(const nlohmann::ordered_json& result);

}  // namespace kantaro::scenarios
