#include "scenarios/experiments/localisation_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWidth = 328.0, kHeight = 200.0, kMargin = 36.0, kLeft = 44.0;
constexpr double kFarthest_m = 1.5, kMost_m = 0.2;

double X(double distance_m) {
  return kLeft + (kWidth - kLeft) * std::min(distance_m / kFarthest_m, 1.0);
}
double Y(double error_m) {
  return kMargin + (kHeight - 2.0 * kMargin) * (1.0 - std::min(error_m / kMost_m, 1.0));
}

const char* ColourOf(const std::string& landmark) {
  return landmark == "manhole" ? "#c0392b" : landmark == "joint" ? "#2c6fbb" : "#2e8b57";
}

std::string Line(double error_m, const char* style, const std::string& words) {
  return fmt::format(
      "<line x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" {3}/>"
      "<text x=\"{4:.1f}\" y=\"{5:.1f}\" text-anchor=\"end\">{6}</text>\n",
      X(0.0), kWidth, Y(error_m), style, kLeft - 4.0, Y(error_m) + 4.0, words);
}

std::string Axes(const std::string& title) {
  std::string text = fmt::format("<text x=\"{:.1f}\" y=\"20\">{}</text>\n", kLeft, title);
  const char* const solid = "stroke=\"#888\"";
  const char* const dashed = "stroke=\"#888\" stroke-dasharray=\"4 3\"";
  text += Line(0.0, solid, "0") + Line(0.02, dashed, "2") + Line(0.05, dashed, "5") +
          Line(kMost_m, solid, "20 cm");
  for (const double distance_m : {0.5, 1.0, 1.5}) {
    text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.1f} m</text>\n",
                        X(distance_m), Y(0.0) + 16.0, distance_m);
  }
  return text;
}

}  // namespace

std::string PlotErrors(const Json& result) {
  std::vector<std::pair<std::string, std::string>> panels;  // title, marks
  for (const Json& point : result.at("points")) {
    const auto title = fmt::format("{}, {}: error", point.at(0).get<std::string>(),
                                   point.at(1).get<std::string>());
    auto panel = std::ranges::find(panels, title, &std::pair<std::string, std::string>::first);
    if (panel == panels.end()) panel = panels.insert(panels.end(), {title, ""});
    const double error_m = point.at(5).is_null() ? kMost_m : std::abs(point.at(5).get<double>());
    panel->second += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"1.8\" fill=\"{}\"/>\n",
                                 X(point.at(4).get<double>()), Y(error_m), ColourOf(point.at(2)));
  }
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"white\"/>\n",
      kWidth + 20.0, kHeight * static_cast<double>(panels.size()) + 24.0);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    text += fmt::format("<g transform=\"translate(0 {:.0f})\">\n{}{}</g>\n",
                        kHeight * static_cast<double>(i), Axes(panels[i].first), panels[i].second);
  }
  double x = kLeft;
  for (const char* landmark : {"manhole", "joint", "inlet"}) {
    text += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" fill=\"{}\">{}</text>\n", x,
                        kHeight * static_cast<double>(panels.size()) + 8.0, ColourOf(landmark),
                        landmark);
    x += 70.0;
  }
  return text + "</svg>\n";
}

}  // namespace kantaro::scenarios
