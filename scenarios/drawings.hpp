#pragma once

#include <string>

#include "scenarios/mission_trace.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// Drawings of the report as SVG elements. Colours come from the page's style sheet by class, so
/// that light, dark and paper each get their own. `width_px` is the width at which the text has its
/// natural size.

/// The network from above, north (+y) up, with the planned route, the true path and the estimated
/// one.
[[nodiscard]] std::string PlanSvg(const Scenario& scenario, const MissionTrace& trace,
                                  double width_px);

/// Distance along the route, speed and position error over time, with the landmark frames marked by
/// their number and the executive's phases as a ribbon.
[[nodiscard]] std::string TimeSvg(const Scenario& scenario, const MissionTrace& trace,
                                  double width_px);

/// One laser revolution seen from behind the robot: right is right, up is up.
/// @param threshold_m  a window whose range exceeds it is open (thesis: 175 mm).
[[nodiscard]] std::string LaserSvg(const LaserRing& ring, double threshold_m);

/// A fault's clock position as a small dial.
[[nodiscard]] std::string ClockSvg(double clock_h);

/// Distance along the planned route [m] of a place; absent if the route does not lead there.
/// Inside a manhole the distance counts from the wall where the leg ended, straight to the robot.
class RouteRuler {
 public:
  explicit RouteRuler(const Scenario& scenario);
  /// Places are to be given in the order of time: where a route passes a pipe twice, the nearer leg
  /// to the last is meant.
  [[nodiscard]] std::optional<double> Measure(const Place& place, const Eigen::Vector3d& p_WB);
  [[nodiscard]] double length_m() const;

 private:
  struct Leg {
    std::string pipe, end_manhole;
    bool downstream{};
    double start_m{}, length_m{}, shaft_m{};
    Eigen::Vector3d p_WEnd{Eigen::Vector3d::Zero()};
  };
  std::vector<Leg> legs_;
  std::size_t current_{};
};

}  // namespace kantaro::scenarios
