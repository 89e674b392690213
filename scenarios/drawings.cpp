#include "scenarios/drawings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "network/pipe_axis.hpp"
#include "network/topology.hpp"
#include "scenarios/html.hpp"
#include "scenarios/svg.hpp"

namespace kantaro::scenarios {
namespace {

using std::numbers::pi;

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
