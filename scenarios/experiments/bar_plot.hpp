#pragma once

#include <optional>
#include <span>
#include <string>

namespace kantaro::scenarios {

struct Bar {
  std::string name;
  std::string label;   ///< its value in words
  double share{};      ///< of the longest bar, 0 to 1; more is drawn as 1
  bool highlighted{};  ///< what the chart is about
};

/// Horizontal bars, one below the other, as an SVG picture that fits any width of page.
/// @param limit  a share that is marked at each bar and named, if there is one.
[[nodiscard]] std::string PlotBars(const std::string& title, std::span<const Bar> bars,
                                   std::optional<double> limit, const std::string& limit_name);

}  // namespace kantaro::scenarios
