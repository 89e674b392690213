#pragma once

#include <string>

namespace kantaro::scenarios {

/// Elements of SVG as text. `kind` is the class by which the page's style sheet knows them; places
/// and sizes are pixels.

[[nodiscard]] std::string OpenSvg(double width, double height, const std::string& kind,
                                  const std::string& label);
[[nodiscard]] std::string Line(const std::string& kind, double x1, double y1, double x2, double y2);
[[nodiscard]] std::string Circle(const std::string& kind, double x, double y, double radius);
/// @param anchor  "start", "middle" or "end"
[[nodiscard]] std::string Label(const std::string& kind, double x, double y,
                                const std::string& anchor, const std::string& text);

/// A line through points, leaving out those that no eye could tell apart.
class Polyline {
 public:
  void Add(double x, double y);
  void Break() { drawing_ = false; }
  [[nodiscard]] std::string Svg(const std::string& kind, const std::string& attributes = "") const;

 private:
  std::string path_;
  double x_{}, y_{};
  bool drawing_{};
};

/// A round number near `rough`: 1, 2 or 5 times a power of ten.
[[nodiscard]] double RoundStep(double rough);
/// With as many digits as ticks at this step need.
[[nodiscard]] std::string Short(double value, double step);

}  // namespace kantaro::scenarios
