#include "scenarios/drawings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "network/pipe_axis.hpp"
#include "network/topology.hpp"
#include "scenarios/html.hpp"
#include "scenarios/judge.hpp"

namespace kantaro::scenarios {
namespace {

using std::numbers::pi;

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

/// @param anchor  "start", "middle" or "end"
std::string Label(const std::string& kind, double x, double y, const std::string& anchor,
                  const std::string& text) {
  return fmt::format(R"(<text class="{}" x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", kind,
                     x, y, anchor, Escape(text));
}

/// A line through points, leaving out those that no eye could tell apart.
class Polyline {
 public:
  void Add(double x, double y) {
    const bool near = !path_.empty() && drawing_ && std::hypot(x - x_, y - y_) < 0.6;
    if (near) return;
    path_ += fmt::format("{}{:.1f} {:.1f}", drawing_ ? 'L' : 'M', x, y);
    x_ = x, y_ = y, drawing_ = true;
  }
  void Break() { drawing_ = false; }
  [[nodiscard]] std::string Svg(const std::string& kind, const std::string& attributes = "") const {
    return path_.empty() ? ""
                         : fmt::format(R"(<path class="{}"{} d="{}"/>)", kind, attributes, path_);
  }

 private:
  std::string path_;
  double x_{}, y_{};
  bool drawing_{};
};

/// A round number near `rough`: 1, 2 or 5 times a power of ten.
double RoundStep(double rough) {
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double leading = rough / power;
  return power * (leading < 1.5 ? 1.0 : leading < 3.5 ? 2.0 : leading < 7.5 ? 5.0 : 10.0);
}

std::string Short(double value, double step) {
  if (std::abs(value) < step / 2.0) value = 0.0;  // no "-0.0"
  return fmt::format("{:.{}f}", value, step >= 1.0 ? 0 : step >= 0.1 ? 1 : 2);
}

// ---------------------------------------------------------------- the plan

/// From world metres to the drawing's pixels.
class PlanView {
 public:
  PlanView(const network::Network& network, double width_px) {
    Eigen::AlignedBox2d box;
    for (const network::Manhole& manhole : network.manholes) {
      const double radius_m = network.ShaftDiameter(manhole) / 2.0;
      box.extend(Eigen::Vector2d(manhole.p_WM.head<2>() - Eigen::Vector2d::Constant(radius_m)));
      box.extend(Eigen::Vector2d(manhole.p_WM.head<2>() + Eigen::Vector2d::Constant(radius_m)));
    }
    for (const network::Pipe& pipe : network.pipes) {
      for (const network::Bend& bend : pipe.bends) box.extend(bend.p_W);
    }
    const double highest_px = width_px > 600.0 ? 560.0 : 460.0;
    const Eigen::Vector2d room(width_px - 2.0 * kMargin_px, highest_px - 2.0 * kMargin_px);
    const Eigen::Vector2d size = box.sizes().cwiseMax(1e-3);
    scale_ = std::min({room.x() / size.x(), room.y() / size.y(), 140.0});
    height_px_ = size.y() * scale_ + 2.0 * kMargin_px;
    origin_ = {width_px / 2.0 - box.center().x() * scale_,
               height_px_ / 2.0 + box.center().y() * scale_};
  }

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& p_W) const {
    return {origin_.x() + p_W.x() * scale_, origin_.y() - p_W.y() * scale_};
  }
  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector3d& p_W) const {
    return (*this)(Eigen::Vector2d(p_W.head<2>()));
  }
  [[nodiscard]] double Pixels(double length_m, double at_least_px) const {
    return std::max(length_m * scale_, at_least_px);
  }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double height_px() const { return height_px_; }

 private:
  static constexpr double kMargin_px = 44.0;
  double scale_{}, height_px_{};
  Eigen::Vector2d origin_{Eigen::Vector2d::Zero()};
};

constexpr double kThinnestPipe_px = 7.0;

std::string DrawPipeBody(const PlanView& view, const network::PipeAxis& axis,
                         const network::Pipe& pipe) {
  Polyline line;
  const int steps = pipe.bends.empty() ? 1 : 64;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p =
        view(Eigen::Vector3d(axis.PoseAt(axis.length_m() * i / steps).translation()));
    line.Add(p.x(), p.y());
  }
  return line.Svg("pipe", fmt::format(R"( stroke-width="{:.1f}")",
                                      view.Pixels(pipe.diameter_m, kThinnestPipe_px)));
}

/// Links that are not built, between those of their ends that the network has.
std::string DrawUnbuilt(const PlanView& view, const network::Network& network) {
  std::string svg;
  for (const network::SkippedLink& link : network.skipped) {
    Polyline line;
    const auto add = [&](const Eigen::Vector2d& p_W) {
      const Eigen::Vector2d p = view(p_W);
      line.Add(p.x(), p.y());
    };
    const auto from = network.FindManhole(link.upstream), to = network.FindManhole(link.downstream);
    if (!from || !to) continue;
    add(network.manholes[*from].p_WM.head<2>());
    for (const Eigen::Vector2d& p_W : link.via_W) add(p_W);
    add(network.manholes[*to].p_WM.head<2>());
    svg += fmt::format("<g><title>{}: {}, not enterable</title>{}</g>", Escape(link.name),
                       Escape(link.reason), line.Svg("unbuilt"));
  }
  return svg;
}

/// Joints, inlets and faults of a pipe, where the scale leaves room for them.
std::string DrawPipeDetail(const PlanView& view, const network::PipeAxis& axis,
                           const network::Pipe& pipe) {
  std::string svg;
  const double half_px = view.Pixels(pipe.diameter_m, kThinnestPipe_px) / 2.0;
  const auto across = [&](double chainage_m) {
    const Eigen::Isometry3d X_WA = axis.PoseAt(chainage_m);
    const Eigen::Vector2d left = X_WA.linear().col(1).head<2>().normalized();
    return std::pair(view(Eigen::Vector3d(X_WA.translation())),
                     Eigen::Vector2d(left.x(), -left.y()));
  };
  double last_joint_m = -std::numeric_limits<double>::infinity();
  for (const network::Joint& joint : pipe.joints) {
    if ((joint.chainage_m - last_joint_m) * view.scale() < 5.0) continue;
    last_joint_m = joint.chainage_m;
    const auto [p, left] = across(joint.chainage_m);
    svg += Line("joint", p.x() - left.x() * half_px, p.y() - left.y() * half_px,
                p.x() + left.x() * half_px, p.y() + left.y() * half_px);
  }
  for (const network::Inlet& inlet : pipe.inlets) {
    const auto [p, left] = across(inlet.chainage_m);
    // Clock positions past 6 lie to the left, looking downstream.
    const double side = -network::ClockDirection(inlet.clock_h).y() > 0.0 ? -1.0 : 1.0;
    const Eigen::Vector2d from = p + left * side * half_px, to = p + left * side * (half_px + 9.0);
    svg += fmt::format(
        R"(<line class="inlet" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke-width="{:.1f}">)"
        "<title>inlet {} at {:.2f} m</title></line>",
        from.x(), from.y(), to.x(), to.y(), view.Pixels(inlet.diameter_m, 3.0), Escape(inlet.name),
        inlet.chainage_m);
  }
  return svg;
}

std::string DrawFaults(const PlanView& view, const network::PipeAxis& axis,
                       const network::Pipe& pipe) {
  std::string svg;
  for (const network::Fault& fault : pipe.faults) {
    const Eigen::Isometry3d X_WA = axis.PoseAt(fault.chainage_m);
    const Eigen::Vector3d aside = X_WA.linear() * network::ClockDirection(fault.clock_h);
    const Eigen::Vector2d shift(aside.x(), -aside.y());
    const Eigen::Vector2d p = view(Eigen::Vector3d(X_WA.translation())) +
                              shift * view.Pixels(pipe.diameter_m, kThinnestPipe_px) / 2.0;
    svg += fmt::format(
        R"(<path class="fault" d="M{0:.1f} {1:.1f}l5 5l-5 5l-5 -5z"><title>planted fault {2} at {3:.2f} m</title></path>)",
        p.x(), p.y() - 5.0, Escape(fault.name), fault.chainage_m);
  }
  return svg;
}

/// The direction around a manhole that is farthest from its pipes, as a unit vector on the drawing.
Eigen::Vector2d FreeDirection(const network::Network& network, const network::Manhole& manhole) {
  std::vector<Eigen::Vector2d> taken;
  for (const std::size_t pipe : network.PipesAt(manhole.name)) {
    const Eigen::Vector2d out = network::DirectionFrom(network, network.pipes[pipe], manhole);
    taken.emplace_back(out.x(), -out.y());
  }
  Eigen::Vector2d best(0.0, -1.0);
  double least = 2.0;
  for (const double degrees : {-90.0, 90.0, -45.0, -135.0, 45.0, 135.0, 0.0, 180.0}) {
    const Eigen::Vector2d direction(std::cos(degrees * pi / 180.0), std::sin(degrees * pi / 180.0));
    double nearest = -1.0;
    for (const Eigen::Vector2d& pipe : taken) nearest = std::max(nearest, direction.dot(pipe));
    if (nearest < least - 0.05) least = nearest, best = direction;
    if (nearest < 0.3) break;  // above or below reads best, where no pipe is in the way
  }
  return best;
}

std::string DrawManhole(const PlanView& view, const network::Network& network,
                        const network::Manhole& manhole, const std::string& role) {
  const Eigen::Vector2d p = view(manhole.p_WM);
  const double radius_px = view.Pixels(network.ShaftDiameter(manhole) / 2.0, 7.0);
  const Eigen::Vector2d free = FreeDirection(network, manhole);
  const Eigen::Vector2d at = p + free * (radius_px + 7.0);
  const std::string anchor = free.x() > 0.3 ? "start" : free.x() < -0.3 ? "end" : "middle";
  const double drop = free.y() > 0.3 ? 11.0 : free.y() < -0.3 ? 0.0 : 5.0;
  const std::string name = role.empty() ? manhole.name : manhole.name + " · " + role;
  return Circle(role.empty() ? "manhole" : "manhole terminal", p.x(), p.y(), radius_px) +
         Label("name", at.x(), at.y() + drop, anchor, name);
}

std::string DrawScale(const PlanView& view, double height_px) {
  const double metres = RoundStep(90.0 / view.scale());
  const double length_px = metres * view.scale();
  const double y = height_px - 12.0;
  return fmt::format(R"(<path class="scale" d="M16 {0:.1f}v5h{1:.1f}v-5"/>)", y - 5.0, length_px) +
         Label("small", 16.0 + length_px + 7.0, y + 3.0, "start", Short(metres, metres) + " m");
}

std::string DrawPaths(const PlanView& view, const Scenario& scenario, const MissionTrace& trace) {
  Polyline truth, estimate;
  for (const TruthSample& sample : trace.truth) {
    const Eigen::Vector2d p = view(Eigen::Vector3d(sample.X_WB.translation()));
    truth.Add(p.x(), p.y());
  }
  std::vector<std::optional<network::PipeAxis>> axes(scenario.network.pipes.size());
  for (const EstimateSample& sample : trace.estimate) {
    const auto pipe = scenario.network.FindPipe(sample.pipe);
    if (!pipe) {
      estimate.Break();
      continue;
    }
    if (!axes[*pipe]) axes[*pipe].emplace(scenario.network, scenario.network.pipes[*pipe]);
    Eigen::Vector3d p_WB = axes[*pipe]->PoseAt(sample.chainage_m).translation();
    if (sample.p_WChannel) p_WB.head<2>() = *sample.p_WChannel;
    const Eigen::Vector2d p = view(p_WB);
    estimate.Add(p.x(), p.y());
  }
  std::string svg = truth.Svg("truth") + estimate.Svg("estimate");
  if (!trace.truth.empty()) {
    const Eigen::Vector2d start = view(Eigen::Vector3d(trace.truth.front().X_WB.translation()));
    const Eigen::Vector2d end = view(Eigen::Vector3d(trace.truth.back().X_WB.translation()));
    svg += Circle("dot", start.x(), start.y(), 4.5) + Circle("dot end", end.x(), end.y(), 5.5);
  }
  return svg;
}

/// Where each numbered camera frame was taken.
std::string DrawFramePins(const PlanView& view, const MissionTrace& trace) {
  std::string svg;
  Eigen::Vector2d last(-1e9, -1e9);
  for (std::size_t i = 0; i < trace.frames.size(); ++i) {
    const auto sample =
        std::lower_bound(trace.truth.begin(), trace.truth.end(), trace.frames[i].time_s,
                         [](const TruthSample& s, double time_s) { return s.time_s < time_s; });
    if (sample == trace.truth.end()) continue;
    const Eigen::Vector2d p = view(Eigen::Vector3d(sample->X_WB.translation()));
    if ((p - last).norm() < 18.0) continue;  // would cover the one before
    last = p;
    svg += Circle("pin", p.x(), p.y(), 8.5) +
           Label("pin-number", p.x(), p.y() + 3.4, "middle", std::to_string(i + 1));
  }
  return svg;
}

// ---------------------------------------------------------------- over time

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

// ---------------------------------------------------------------- the laser

constexpr double kLaserScale_px_m = 720.0;  // 190 mm reach 137 px

Eigen::Vector2d OnDial(double angle_rad, double range_m) {
  return {170.0 + std::cos(angle_rad) * range_m * kLaserScale_px_m,
          170.0 - std::sin(angle_rad) * range_m * kLaserScale_px_m};
}

std::string DrawWindow(double middle_rad, double reach_m) {
  const double half_rad = 7.5 * pi / 180.0;
  const Eigen::Vector2d a = OnDial(middle_rad - half_rad, reach_m),
                        b = OnDial(middle_rad + half_rad, reach_m);
  return fmt::format(
      R"(<path class="window" d="M170 170L{0:.1f} {1:.1f}A{4:.1f} {4:.1f} 0 0 0 {2:.1f} {3:.1f}Z"/>)",
      a.x(), a.y(), b.x(), b.y(), reach_m * kLaserScale_px_m);
}

}  // namespace

RouteRuler::RouteRuler(const Scenario& scenario) {
  const network::Network& network = scenario.network;
  double start_m = 0.0;
  for (const network::RouteLeg& leg : PlannedRoute(scenario)) {
    const network::Pipe& pipe = network.PipeNamed(leg.pipe);
    const network::PipeAxis axis(network, pipe);
    const network::Manhole& end =
        network.ManholeNamed(leg.downstream ? pipe.downstream : pipe.upstream);
    legs_.push_back({leg.pipe, end.name, leg.downstream, start_m, axis.length_m(),
                     network.ShaftDiameter(end),
                     axis.PoseAt(leg.downstream ? axis.length_m() : 0.0).translation()});
    start_m += axis.length_m() + legs_.back().shaft_m;
  }
}

std::optional<double> RouteRuler::Measure(const Place& place, const Eigen::Vector3d& p_WB) {
  std::optional<std::size_t> found;
  const auto distance = [&](std::size_t leg) {
    return leg > current_ ? leg - current_ : current_ - leg;
  };
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    const bool here =
        place.pipe.empty() ? legs_[i].end_manhole == place.manhole : legs_[i].pipe == place.pipe;
    if (here && (!found || distance(i) < distance(*found))) found = i;
  }
  if (!found) return {};
  current_ = *found;
  const Leg& leg = legs_[*found];
  if (!place.pipe.empty()) {
    return leg.start_m + (leg.downstream ? place.chainage_m : leg.length_m - place.chainage_m);
  }
  const double inside_m = (p_WB - leg.p_WEnd).head<2>().norm();
  return leg.start_m + leg.length_m + std::min(inside_m, leg.shaft_m);
}

double RouteRuler::length_m() const {
  return legs_.empty() ? 0.0 : legs_.back().start_m + legs_.back().length_m;
}

std::string PlanSvg(const Scenario& scenario, const MissionTrace& trace, double width_px) {
  const network::Network& shown = scenario.network;
  const PlanView view(shown, width_px);
  std::string bodies, details, faults, manholes;
  for (const network::Pipe& pipe : shown.pipes) {
    const network::PipeAxis axis(shown, pipe);
    bodies += DrawPipeBody(view, axis, pipe);
    details += DrawPipeDetail(view, axis, pipe);
    faults += DrawFaults(view, axis, pipe);
  }
  for (const network::Manhole& manhole : shown.manholes) {
    const std::string role = manhole.name == scenario.start.manhole ? "start"
                             : manhole.name == scenario.goal        ? "goal"
                                                                    : "";
    manholes += DrawManhole(view, shown, manhole, role);
  }
  return OpenSvg(width_px, view.height_px() + 20.0, "plan",
                 "The network from above with the true and the estimated path") +
         DrawUnbuilt(view, shown) + bodies + manholes + details + faults +
         DrawPaths(view, scenario, trace) + DrawFramePins(view, trace) +
         DrawScale(view, view.height_px() + 20.0) + "</svg>";
}

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

std::string LaserSvg(const LaserRing& ring, double threshold_m) {
  std::string svg =
      OpenSvg(340.0, 340.0, "laser", "One laser revolution, seen from behind the robot");
  for (const double middle_rad : {0.0, pi / 2.0, pi}) svg += DrawWindow(middle_rad, 0.205);
  for (const double range_m : {0.05, 0.10, 0.15})
    svg += Circle("grid", 170.0, 170.0, range_m * kLaserScale_px_m);
  svg += Circle("limit", 170.0, 170.0, threshold_m * kLaserScale_px_m);
  svg += Line("grid", 12.0, 170.0, 328.0, 170.0) + Line("grid", 170.0, 12.0, 170.0, 328.0);
  for (const double range_m : {0.05, 0.10, 0.15}) {
    const Eigen::Vector2d p = OnDial(-pi / 4.0, range_m);
    svg +=
        Label("tick", p.x() + 2.0, p.y() + 4.0, "start", fmt::format("{:.0f}", range_m * 1000.0));
  }
  const Eigen::Vector2d corner = OnDial(-0.75 * pi, threshold_m);
  svg += Label("limit-label", corner.x() - 5.0, corner.y() + 10.0, "end",
               fmt::format("{:.0f} mm", threshold_m * 1000.0));
  for (const robot::LaserSample& sample : ring.revolution.samples) {
    const Eigen::Vector2d p = OnDial(sample.angle_rad, sample.range_m);
    svg += Circle(sample.status == robot::RangeStatus::kValid ? "hit" : "no-return", p.x(), p.y(),
                  1.7);
  }
  return svg + Circle("dot", 170.0, 170.0, 3.0) + "</svg>";
}

std::string ClockSvg(double clock_h) {
  const double angle_rad = clock_h * pi / 6.0;
  return fmt::format(
      R"(<svg class="clock" viewBox="0 0 22 22" aria-hidden="true"><circle cx="11" cy="11" r="9.5"/><circle class="at" cx="{:.1f}" cy="{:.1f}" r="2.6"/></svg>)",
      11.0 + 9.5 * std::sin(angle_rad), 11.0 - 9.5 * std::cos(angle_rad));
}

}  // namespace kantaro::scenarios
