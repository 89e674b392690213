#include "scenarios/experiments/bar_plot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scenarios/svg.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kWidth = 440.0, kMargin = 12.0, kTop = 48.0, kRow = 34.0;
constexpr double kBarTop = 19.0, kBar = 8.0;  ///< in its row
constexpr const char* kStyle =
    "<style>text{font:12px sans-serif;fill:#222}.title{font-weight:bold;font-size:14px}"
    ".bar{fill:#9db4c8}.ours{fill:#c0392b}.limit{stroke:#222}"
    "svg{width:100%;max-width:44em;height:auto;background:white}</style>\n";

double X(double share) { return kMargin + (kWidth - 2.0 * kMargin) * std::clamp(share, 0.0, 1.0); }

std::string Draw(const Bar& bar, double y) {
  return Label("name", kMargin, y + 14.0, "start", bar.name) +
         Label("value", kWidth - kMargin, y + 14.0, "end", bar.label) +
         fmt::format(R"(<rect class="{}" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}"/>)",
                     bar.highlighted ? "ours" : "bar", kMargin, y + kBarTop, X(bar.share) - kMargin,
                     kBar) +
         "\n";
}

}  // namespace

std::string PlotBars(const std::string& title, std::span<const Bar> bars,
                     std::optional<double> limit, const std::string& limit_name) {
  const double height = kTop + kRow * static_cast<double>(bars.size()) + kMargin;
  std::string text = OpenSvg(kWidth, height, "bars", title) + "\n" + kStyle +
                     Label("title", kMargin, 20.0, "start", title) + "\n";
  double y = kTop;
  for (const Bar& bar : bars) {
    text += Draw(bar, y);
    y += kRow;
  }
  if (limit) {
    for (std::size_t i = 0; i < bars.size(); ++i) {  // not across the words
      const double top = kTop + kRow * static_cast<double>(i) + kBarTop;
      text += Line("limit", X(*limit), top - 2.0, X(*limit), top + kBar + 2.0);
    }
    text += Label("limit-name", X(*limit), kTop - 8.0, *limit < 0.5 ? "start" : "end", limit_name) +
            "\n";
  }
  return text + "</svg>\n";
}

}  // namespace kantaro::scenarios
