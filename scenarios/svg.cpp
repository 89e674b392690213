#include "scenarios/svg.hpp"

#include <fmt/format.h>

#include <cmath>

#include "scenarios/html.hpp"

namespace kantaro::scenarios {

std::string OpenSvg(double width, double height, const std::string& kind,
                    const std::string& label) {
  return fmt::format(
      R"(<svg class="{}" viewBox="0 0 {:.0f} {:.0f}" role="img" aria-label="{}" xmlns="http://www.w3.org/2000/svg">)",
      kind, width, height, Escape(label));
}

std::string Line(const std::string& kind, double x1, double y1, double x2, double y2) {
  return fmt::format(R"(<line class="{}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>)", kind,
                     x1, y1, x2, y2);
}

std::string Circle(const std::string& kind, double x, double y, double radius) {
  return fmt::format(R"(<circle class="{}" cx="{:.1f}" cy="{:.1f}" r="{:.1f}"/>)", kind, x, y,
                     radius);
}

std::string Label(const std::string& kind, double x, double y, const std::string& anchor,
                  const std::string& text) {
  return fmt::format(R"(<text class="{}" x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", kind,
                     x, y, anchor, Escape(text));
}

void Polyline::Add(double x, double y) {
  const bool near = !path_.empty() && drawing_ && std::hypot(x - x_, y - y_) < 0.6;
  if (near) return;
  path_ += fmt::format("{}{:.1f} {:.1f}", drawing_ ? 'L' : 'M', x, y);
  x_ = x, y_ = y, drawing_ = true;
}

std::string Polyline::Svg(const std::string& kind, const std::string& attributes) const {
  return path_.empty() ? ""
                       : fmt::format(R"(<path class="{}"{} d="{}"/>)", kind, attributes, path_);
}

double RoundStep(double rough) {
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double leading = rough / power;
  return power * (leading < 1.5 ? 1.0 : leading < 3.5 ? 2.0 : leading < 7.5 ? 5.0 : 10.0);
}

std::string Short(double value, double step) {
  if (std::abs(value) < step / 2.0) value = 0.0;  // no "-0.0"
  return fmt::format("{:.{}f}", value, step >= 1.0 ? 0 : step >= 0.1 ? 1 : 2);
}

}  // namespace kantaro::scenarios
