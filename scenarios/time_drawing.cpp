// The report's charts over time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scenarios/drawings.hpp"
#include "scenarios/html.hpp"
#include "scenarios/judge.hpp"
#include "scenarios/svg.hpp"

namespace kantaro::scenarios {
namespace {

using Point = std::pair<double, double>;  ///< time [s], value; NaN breaks the line

/// One chart of the stack that shares its time axis.
struct Panel {
  std::string title;
  double height_px{};
  std::vector<std::pair<std::string, std::vector<Point>>> lines;  ///< class, points
  std::optional<double> limit;
};

struct TimeAxis {
  double left_px{}, right_px{}, end_s{};
  [[nodiscard]] double operator()(double time_s) const {
    return left_px + (right_px - left_px) * std::clamp(time_s / end_s, 0.0, 1.0);
  }
};

std::pair<double, double> Range(const Panel& panel) {
  double low = 0.0, high = 1e-6;
  for (const auto& [kind, points] : panel.lines) {
    for (const auto& [time_s, value] : points) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (panel.limit) high = std::max(high, *panel.limit * 1.12);
  return {low < 0.0 ? low * 1.05 : low, high * 1.04};
}

std::string DrawPanel(const Panel& panel, const TimeAxis& axis, double top_px) {
  const auto [low, high] = Range(panel);
  const double bottom_px = top_px + panel.height_px;
  const auto y = [&, low = low, high = high](double value) {
    return bottom_px - (value - low) / (high - low) * panel.height_px;
  };
  std::string svg = Label("panel-title", axis.left_px, top_px - 9.0, "start", panel.title);
  const double step = RoundStep((high - low) / 3.2);
  for (double tick = std::ceil(low / step) * step; tick <= high + 1e-12; tick += step) {
    svg += Line(std::abs(tick) < step / 2.0 ? "axis" : "grid", axis.left_px, y(tick), axis.right_px,
                y(tick));
    svg += Label("tick", axis.left_px - 7.0, y(tick) + 4.0, "end", Short(tick, step));
  }
  if (panel.limit) {
    svg += Line("limit", axis.left_px, y(*panel.limit), axis.right_px, y(*panel.limit));
    svg += Label("limit-label", axis.right_px, y(*panel.limit) - 4.0, "end",
                 fmt::format("limit {:.2g}", *panel.limit));
  }
  for (const auto& [kind, points] : panel.lines) {
    Polyline line;
    for (const auto& [time_s, value] : points) {
      if (std::isfinite(value)) {
        line.Add(axis(time_s), y(value));
      } else {
        line.Break();
      }
    }
    svg += line.Svg(kind);
  }
  return svg;
}

std::string DrawTimeTicks(const TimeAxis& axis, double y_px) {
  std::string svg;
  const double step = RoundStep(axis.end_s / std::max(3.0, (axis.right_px - axis.left_px) / 95.0));
  for (double tick = 0.0; tick <= axis.end_s + 1e-9; tick += step) {
    svg += Label("tick", axis(tick), y_px, "middle", Short(tick, step) + (tick == 0.0 ? " s" : ""));
  }
  return svg;
}

/// The row, 0 lowest, in which each camera frame's number has room beside the one before; absent if
/// in none.
std::vector<std::optional<std::size_t>> MarkRows(const MissionTrace& trace, const TimeAxis& axis) {
  std::vector<std::optional<std::size_t>> rows;
  std::array<double, 3> row_end{-1e9, -1e9, -1e9};
  for (const LandmarkFrame& frame : trace.frames) {
    const double x = axis(frame.time_s);
    const auto row =
        std::find_if(row_end.begin(), row_end.end(), [&](double end) { return x - end > 18.0; });
    if (row == row_end.end()) {
      rows.emplace_back();
    } else {
      *row = x;
      rows.emplace_back(static_cast<std::size_t>(row - row_end.begin()));
    }
  }
  return rows;
}

constexpr double kMarkRow_px = 19.0;

std::string DrawFrameMarks(const MissionTrace& trace,
                           const std::vector<std::optional<std::size_t>>& rows,
                           const TimeAxis& axis, double top_px, double bottom_px) {
  std::string svg;
  for (std::size_t i = 0; i < trace.frames.size(); ++i) {
    const double x = axis(trace.frames[i].time_s);
    svg += Line("mark", x, top_px, x, bottom_px);
    if (!rows[i]) continue;
    const double y = top_px - 10.0 - kMarkRow_px * static_cast<double>(*rows[i]);
    svg +=
        Circle("pin", x, y, 8.5) + Label("pin-number", x, y + 3.4, "middle", std::to_string(i + 1));
  }
  return svg;
}

std::string DrawPhases(const MissionTrace& trace, const TimeAxis& axis, double top_px) {
  std::string svg;
  for (std::size_t first = 0; first < trace.estimate.size();) {
    std::size_t next = first;
    while (next < trace.estimate.size() &&
           trace.estimate[next].phase == trace.estimate[first].phase)
      ++next;
    const EstimateSample& sample = trace.estimate[first];
    const double end_s = next < trace.estimate.size() ? trace.estimate[next].time_s : axis.end_s;
    const double x = axis(sample.time_s), width = axis(end_s) - x;
    if (!sample.phase.empty()) {
      svg += fmt::format(
          R"(<rect class="phase{}" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="17"><title>{} {:.1f} to {:.1f} s</title></rect>)",
          sample.turning ? " turning" : "", x, top_px, std::max(width - 1.0, 0.6),
          Escape(sample.phase), sample.time_s, end_s);
      if (width > 7.0 * static_cast<double>(sample.phase.size()) + 8.0) {
        svg += Label(sample.turning ? "phase-name on" : "phase-name", x + width / 2.0,
                     top_px + 12.4, "middle", sample.phase);
      }
    }
    first = next;
  }
  return svg;
}

std::vector<Point> MeanSpeed(const MissionTrace& trace) {
  constexpr std::size_t kWindow = 10;  // 0.5 s at kTracePeriod_s
  std::vector<Point> points;
  double sum = 0.0;
  for (std::size_t i = 0; i < trace.truth.size(); ++i) {
    sum += trace.truth[i].speed_m_s;
    if (i >= kWindow) sum -= trace.truth[i - kWindow].speed_m_s;
    points.emplace_back(trace.truth[i].time_s, sum / static_cast<double>(std::min(i + 1, kWindow)));
  }
  return points;
}

std::vector<Panel> TimePanels(const Scenario& scenario, const MissionTrace& trace, bool narrow) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Point> truth, estimate, error;
  RouteRuler truth_ruler(scenario), estimate_ruler(scenario);
  for (std::size_t i = 0; i < trace.estimate.size(); ++i) {
    const EstimateSample& e = trace.estimate[i];
    estimate.emplace_back(
        e.time_s, e.pipe.empty()
                      ? kNone
                      : estimate_ruler.Measure({e.pipe, "", e.chainage_m}, Eigen::Vector3d::Zero())
                            .value_or(kNone));
    if (trace.truth.empty()) continue;
    const TruthSample& t = trace.truth[i];
    truth.emplace_back(t.time_s,
                       truth_ruler.Measure(t.place, t.X_WB.translation()).value_or(kNone));
    error.emplace_back(t.time_s, PositionError(scenario.network, t, e));
  }
  return {{"Distance along the route (m)",
           narrow ? 150.0 : 210.0,
           {{"truth", truth}, {"estimate", estimate}},
           {}},
          {"Speed, mean over 0.5 s (m/s)",
           narrow ? 100.0 : 120.0,
           {{"truth", MeanSpeed(trace)}},
           scenario.limits.speed_m_s},
          {"Position error (m)",
           narrow ? 90.0 : 100.0,
           {{"error", error}},
           scenario.limits.position_error_m}};
}

}  // namespace

std::string TimeSvg(const Scenario& scenario, const MissionTrace& trace, double width_px) {
  constexpr double kGap_px = 40.0;
  const TimeAxis axis{44.0, width_px - 8.0, std::max(trace.end_s, 1.0)};
  const std::vector<std::optional<std::size_t>> rows = MarkRows(trace, axis);
  const std::size_t highest_row =
      rows.empty() ? 0 : std::max_element(rows.begin(), rows.end())->value_or(0);
  const double top_px = 22.0 + kMarkRow_px * static_cast<double>(highest_row);
  std::string charts;
  double y = top_px + 26.0;
  for (const Panel& panel : TimePanels(scenario, trace, width_px < 600.0)) {
    charts += DrawPanel(panel, axis, y);
    y += panel.height_px + kGap_px;
  }
  const double bottom_px = y - kGap_px;
  const std::string ribbon =
      DrawPhases(trace, axis, bottom_px + 8.0) + DrawTimeTicks(axis, bottom_px + 42.0);
  return OpenSvg(width_px, bottom_px + 52.0, "time",
                 "Distance, speed and position error over time") +
         DrawFrameMarks(trace, rows, axis, top_px, bottom_px) + charts + ribbon + "</svg>";
}

}  // namespace kantaro::scenarios
