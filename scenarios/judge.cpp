#include "scenarios/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "network/pipe_axis.hpp"
#include "network/topology.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The speed limit holds for the mean over this time.
constexpr double kSpeedWindow_s = 0.5;
/// Sinking faster than this is a drop: on the steepest grade the robot climbs, 10 %, it sinks by a
/// tenth of its speed, 0.015 m/s at the limit.
constexpr double kDropSpeed_m_s = 0.04;
/// A turn may begin while the base stands this far outside the shaft: with the front half of the
/// robot inside, its front wheels reach the bend of the channel. Earlier it would be turning in a
/// straight pipe, which the thesis forbids (5.6).
constexpr double kTurnReach_m = 0.25;
/// Near a mouth the robot leaves the axis of its pipe as it must.
constexpr double kMouthReach_m = 0.35;

Eigen::Vector2d PlanOf(const Eigen::Vector3d& p_W) { return p_W.head<2>(); }

double PlanDistance(const Eigen::Vector3d& a_W, const Eigen::Vector3d& b_W) {
  return (PlanOf(a_W) - PlanOf(b_W)).norm();
}

/// Distance in plan from the shaft's wall, negative inside.
double OutsideShaft(const network::Network& network, const network::Manhole& manhole,
                    const Eigen::Vector3d& p_W) {
  return PlanDistance(manhole.p_WM, p_W) - network.ShaftDiameter(manhole) / 2.0;
}

bool IsJunction(const network::Network& network, const network::Manhole& manhole) {
  const network::ManholeKind kind = network::KindOf(network, manhole);
  return kind != network::ManholeKind::kEnd && kind != network::ManholeKind::kStraight;
}

double DistanceToGoal(const Scenario& scenario, const TruthSample& end) {
  const network::Manhole& goal = scenario.network.ManholeNamed(scenario.goal);
  return std::max(0.0, OutsideShaft(scenario.network, goal, end.X_WB.translation()));
}

Check GoalReached(const Scenario& scenario, const MissionTrace& trace) {
  const TruthSample& end = trace.truth.back();
  Check check{"goal_reached",
              false,
              DistanceToGoal(scenario, end),
              scenario.limits.goal_tolerance_m,
              "m",
              "",
              {},
              ""};
  check.passed = check.value <= check.limit;
  check.at_s = end.time_s;
  check.place = ToWords(end.place);
  check.text = check.passed
                   ? fmt::format("The robot stands at its goal, manhole {}.", scenario.goal)
                   : fmt::format("The robot stands in {}, {:.2f} m from its goal, manhole {}.",
                                 check.place, check.value, scenario.goal);
  return check;
}

Check FinishedInTime(const Scenario& scenario, const MissionTrace& trace) {
  Check check{
      "finished_in_time", trace.finished, trace.end_s, scenario.time_limit_s, "s", "", {}, ""};
  check.text = trace.finished
                   ? fmt::format("The robot declared the mission done after {:.1f} s.", trace.end_s)
                   : fmt::format("The mission ended after {:.1f} s: {}", trace.end_s, trace.ending);
  return check;
}

/// Whether a place lies in a bend of its pipe, or near enough for the robot to steer into or out of
/// it.
bool IsInBend(const network::Network& network, const Place& place) {
  const auto pipe = network.FindPipe(place.pipe);
  if (!pipe || network.pipes[*pipe].bends.empty()) return false;
  const network::PipeAxis axis(network, network.pipes[*pipe]);
  return std::any_of(
      axis.pieces().begin(), axis.pieces().end(), [&](const network::AxisPiece& piece) {
        return piece.curvature != 0.0 && place.chainage_m > piece.start_m - kMouthReach_m &&
               place.chainage_m < piece.start_m + piece.length_m + kMouthReach_m;
      });
}

Check NoTurnWithoutJunction(const Scenario& scenario, const MissionTrace& trace) {
  Check check{"no_turn_without_junction", true, 0.0, kTurnReach_m, "m", "", {}, ""};
  std::vector<const network::Manhole*> junctions;
  for (const network::Manhole& manhole : scenario.network.manholes) {
    if (IsJunction(scenario.network, manhole)) junctions.push_back(&manhole);
  }
  for (std::size_t i = 0; i < trace.truth.size(); ++i) {
    if (!trace.estimate[i].turning || IsInBend(scenario.network, trace.truth[i].place)) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const network::Manhole* manhole : junctions) {
      nearest_m = std::min(
          nearest_m, OutsideShaft(scenario.network, *manhole, trace.truth[i].X_WB.translation()));
    }
    if (nearest_m <= check.value) continue;
    check.value = nearest_m;
    check.at_s = trace.truth[i].time_s;
    check.place = ToWords(trace.truth[i].place);
  }
  check.passed = check.value <= check.limit;
  check.text = check.passed ? "Every turn was made at a junction."
                            : fmt::format("The robot turned in {}, where there is no junction.",
                                          check.place);
  return check;
}

/// Angle between the robot's heading and the axis it follows, either way [rad]; absent where no
/// axis binds it.
std::optional<double> HeadingDeviation(const network::Network& network,
                                       const std::vector<network::PipeAxis>& axes,
                                       const TruthSample& truth) {
  const auto pipe = network.FindPipe(truth.place.pipe);
  if (!pipe) return {};
  const network::PipeAxis& axis = axes[*pipe];
  const double chainage_m = truth.place.chainage_m;
  if (chainage_m < kMouthReach_m || chainage_m > axis.length_m() - kMouthReach_m) return {};
  const Eigen::Vector2d along = PlanOf(axis.PoseAt(chainage_m).linear().col(0)).normalized();
  const Eigen::Vector2d ahead = PlanOf(truth.X_WB.linear().col(0)).normalized();
  return std::acos(std::clamp(std::abs(along.dot(ahead)), 0.0, 1.0));
}

Check HeadingAlongPipe(const Scenario& scenario, const MissionTrace& trace) {
  Check check{
      "heading_along_pipe", true, 0.0, scenario.limits.heading_rad / kDegree, "deg", "", {}, ""};
  std::vector<network::PipeAxis> axes;
  for (const network::Pipe& pipe : scenario.network.pipes)
    axes.emplace_back(scenario.network, pipe);
  for (const TruthSample& truth : trace.truth) {
    const double deviation_deg =
        HeadingDeviation(scenario.network, axes, truth).value_or(0.0) / kDegree;
    if (deviation_deg <= check.value) continue;
    check.value = deviation_deg;
    check.at_s = truth.time_s;
    check.place = ToWords(truth.place);
  }
  check.passed = check.value <= check.limit;
  check.text = fmt::format("Between manholes the heading kept within {:.1f}° of the pipe's axis.",
                           check.value);
  if (!check.passed) {
    check.text =
        fmt::format("In {} the heading left the pipe's axis by {:.1f}°.", check.place, check.value);
  }
  return check;
}

Check SpeedLimit(const Scenario& scenario, const MissionTrace& trace) {
  Check check{"speed_limit", true, 0.0, scenario.limits.speed_m_s, "m/s", "", {}, ""};
  const std::vector<TruthSample>& truth = trace.truth;
  double last_drop_s = -std::numeric_limits<double>::infinity();
  double distance_m = 0.0;
  std::size_t first = 0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const double step_s = truth[i].time_s - truth[i - 1].time_s;
    const double sunk_m = truth[i - 1].X_WB.translation().z() - truth[i].X_WB.translation().z();
    if (sunk_m > kDropSpeed_m_s * step_s) last_drop_s = truth[i].time_s;
    distance_m += truth[i].speed_m_s * step_s;
    // The shortest run of samples that covers the window.
    while (truth[i].time_s - truth[first + 1].time_s > kSpeedWindow_s - 1e-9) {
      ++first;
      distance_m -= truth[first].speed_m_s * (truth[first].time_s - truth[first - 1].time_s);
    }
    const double window_s = truth[i].time_s - truth[first].time_s;
    const bool full = window_s > kSpeedWindow_s - 1e-9;
    if (!full || truth[first].time_s <= last_drop_s) continue;
    const double mean_m_s = std::abs(distance_m) / window_s;
    if (mean_m_s <= check.value) continue;
    check.value = mean_m_s;
    check.at_s = truth[i].time_s;
    check.place = ToWords(truth[i].place);
  }
  check.passed = check.value <= check.limit;
  check.text =
      fmt::format("The highest mean speed over {:.1f} s was {:.3f} m/s, in {}.", kSpeedWindow_s,
                  check.value, check.place.empty() ? "no place: it never moved" : check.place);
  return check;
}

Check NoUpperBoxCollision(const MissionTrace& trace) {
  Check check{"no_upper_box_collision",         true, 0.0, 0.0, "s",
              "The upper box touched nothing.", {},   ""};
  for (std::size_t i = 1; i < trace.truth.size(); ++i) {
    const TruthSample& truth = trace.truth[i];
    if (!truth.upper_box_contact) continue;
    if (!check.at_s) {
      check.at_s = truth.time_s;
      check.place = ToWords(truth.place);
    }
    check.value += truth.time_s - trace.truth[i - 1].time_s;
  }
  check.passed = check.value <= check.limit;
  if (!check.passed) {
    check.text = fmt::format("The upper box touched the wall for {:.2f} s, first in {}.",
                             check.value, check.place);
  }
  return check;
}

Check LargestPositionError(const Scenario& scenario, const MissionTrace& trace) {
  Check check{"position_error", true, 0.0, scenario.limits.position_error_m, "m", "", {}, ""};
  for (std::size_t i = 0; i < trace.truth.size(); ++i) {
    if (trace.estimate[i].pipe.empty() && i + 1 < trace.truth.size())
      continue;  // before the first estimate
    const double error_m = PositionError(scenario.network, trace.truth[i], trace.estimate[i]);
    if (error_m <= check.value) continue;
    check.value = error_m;
    check.at_s = trace.truth[i].time_s;
    check.place = ToWords(trace.truth[i].place);
  }
  check.passed = check.value <= check.limit;
  check.text = check.place.empty() ? "The estimate was right throughout."
                                   : fmt::format("The estimate was off by at most {:.2f} m, in {}.",
                                                 check.value, check.place);
  return check;
}

Check FinalPositionError(const Scenario& scenario, const MissionTrace& trace) {
  Check check{
      "final_position_error", true, 0.0, scenario.limits.final_position_error_m, "m", "", {}, ""};
  check.value = PositionError(scenario.network, trace.truth.back(), trace.estimate.back());
  check.passed = check.value <= check.limit;
  check.at_s = trace.truth.back().time_s;
  check.place = ToWords(trace.truth.back().place);
  check.text = fmt::format("At the end the robot stands in {} and takes it for {}.", check.place,
                           ToWords(PlaceOf(scenario.network, trace.estimate.back())));
  return check;
}

/// The faults that the robot drove past.
std::vector<PlantedFault> PlantedOnTheWay(const Scenario& scenario, const MissionTrace& trace) {
  std::map<std::string, std::pair<double, double>> driven;
  for (const TruthSample& truth : trace.truth) {
    if (truth.place.pipe.empty()) continue;
    const double here_m = truth.place.chainage_m;
    const auto [range, first_time] = driven.try_emplace(truth.place.pipe, here_m, here_m);
    range->second = {std::min(range->second.first, here_m), std::max(range->second.second, here_m)};
  }
  std::vector<PlantedFault> planted;
  for (const network::Pipe& pipe : scenario.network.pipes) {
    const auto range = driven.find(pipe.name);
    if (range == driven.end()) continue;
    for (const network::Fault& fault : pipe.faults) {
      if (fault.chainage_m < range->second.first || fault.chainage_m > range->second.second)
        continue;
      planted.push_back({pipe.name, fault.name, fault.chainage_m, fault.clock_h, false});
    }
  }
  return planted;
}

bool LiesAt(const ReportedFault& report, const PlantedFault& fault) {
  return report.first.pipe == fault.pipe &&
         std::abs(report.chainage_m - fault.chainage_m) <= kFaultReach_m &&
         ClockDistance(report.clock_h, fault.clock_h) <= kFaultReach_h;
}

void CountFaults(const Scenario& scenario, const MissionTrace& trace, Verdict& verdict) {
  if (trace.truth.empty()) return;
  verdict.planted = PlantedOnTheWay(scenario, trace);
  verdict.true_alarm.assign(trace.faults.size(), false);
  for (PlantedFault& fault : verdict.planted) {
    for (std::size_t i = 0; i < trace.faults.size(); ++i) {
      if (!LiesAt(trace.faults[i], fault)) continue;
      fault.found = true;
      verdict.true_alarm[i] = true;
    }
  }
}

Check FaultsFound(const Verdict& verdict) {
  const auto found = std::count_if(verdict.planted.begin(), verdict.planted.end(),
                                   [](const auto& f) { return f.found; });
  const auto false_alarms = std::count(verdict.true_alarm.begin(), verdict.true_alarm.end(), false);
  return {"faults_found",
          found >= 1,
          static_cast<double>(found),
          1.0,
          "",
          fmt::format("{} of {} faults on the way were found, with {} false {}.", found,
                      verdict.planted.size(), false_alarms, false_alarms == 1 ? "alarm" : "alarms"),
          {},
          ""};
}

double DrivenDistance(const MissionTrace& trace) {
  double distance_m = 0.0;
  for (std::size_t i = 1; i < trace.truth.size(); ++i) {
    distance_m +=
        std::abs(trace.truth[i].speed_m_s) * (trace.truth[i].time_s - trace.truth[i - 1].time_s);
  }
  return distance_m;
}

/// Wheels that skid, and hills, are not seen: this is what the robot was told to do.
Check CommandedSpeed(const Scenario& scenario, const MissionTrace& trace) {
  Check check{"speed_limit", true, 0.0, scenario.limits.speed_m_s, "m/s", "", {}, ""};
  for (const EstimateSample& sample : trace.estimate) {
    if (std::abs(sample.commanded_m_s) <= check.value) continue;
    check.value = std::abs(sample.commanded_m_s);
    check.at_s = sample.time_s;
  }
  check.passed = check.value <= check.limit;
  check.text = fmt::format("The highest speed commanded was {:.3f} m/s; the true one is not known.",
                           check.value);
  return check;
}

Check NotJudged(const Check& check) {
  return {check.name, true, 0.0,  check.limit, check.unit, "Not judged: no ground truth.",
          {},         "",   false};
}

std::vector<Check> ChecksWithoutTruth(const Scenario& scenario, const MissionTrace& trace) {
  std::vector<Check> checks{FinishedInTime(scenario, trace), CommandedSpeed(scenario, trace)};
  const Limits& limits = scenario.limits;
  for (const Check& check : std::initializer_list<Check>{
           {"goal_reached", true, 0.0, limits.goal_tolerance_m, "m", "", {}, ""},
           {"no_turn_without_junction", true, 0.0, kTurnReach_m, "m", "", {}, ""},
           {"heading_along_pipe", true, 0.0, limits.heading_rad / kDegree, "deg", "", {}, ""},
           {"no_upper_box_collision", true, 0.0, 0.0, "s", "", {}, ""},
           {"position_error", true, 0.0, limits.position_error_m, "m", "", {}, ""},
           {"final_position_error", true, 0.0, limits.final_position_error_m, "m", "", {}, ""}}) {
    checks.push_back(NotJudged(check));
  }
  return checks;
}

/// What only ground truth tells.
void AddTrueMetrics(const Verdict& verdict, const MissionTrace& trace,
                    std::map<std::string, double>& metrics) {
  const auto found = std::count_if(verdict.planted.begin(), verdict.planted.end(),
                                   [](const auto& f) { return f.found; });
  metrics["distance_m"] = DrivenDistance(trace);
  metrics["faults_planted"] = static_cast<double>(verdict.planted.size());
  metrics["fault_hits"] = static_cast<double>(found);
  metrics["fault_misses"] = static_cast<double>(static_cast<long>(verdict.planted.size()) - found);
  metrics["fault_false_alarms"] =
      static_cast<double>(std::count(verdict.true_alarm.begin(), verdict.true_alarm.end(), false));
  for (const Check& check : verdict.checks) {
    if (check.name == "goal_reached") metrics["goal_distance_m"] = check.value;
    if (check.name == "speed_limit") metrics["highest_speed_m_s"] = check.value;
    if (check.name == "position_error") metrics["position_error_max_m"] = check.value;
    if (check.name == "final_position_error") metrics["position_error_end_m"] = check.value;
  }
}

std::map<std::string, double> Metrics(const Verdict& verdict, const MissionTrace& trace) {
  std::uint64_t lost = 0;
  for (const auto& [sensor, readings] : trace.lost) lost += readings;
  std::map<std::string, double> metrics{
      {"duration_s", trace.end_s},
      {"landmarks_seen", static_cast<double>(trace.frames.size())},
      {"readings", static_cast<double>(trace.readings)},
      {"readings_lost", static_cast<double>(lost)},
      {"commands", static_cast<double>(trace.commands)},
      {"commands_limited", static_cast<double>(trace.limited)},
      {"commands_refused", static_cast<double>(trace.refused)}};
  if (!trace.truth.empty()) AddTrueMetrics(verdict, trace, metrics);
  return metrics;
}

}  // namespace

std::string ToWords(const Place& place) {
  if (!place.pipe.empty()) return fmt::format("pipe {} at {:.2f} m", place.pipe, place.chainage_m);
  return place.manhole.empty() ? "no known place" : "manhole " + place.manhole;
}

Place PlaceOf(const network::Network& network, const EstimateSample& estimate) {
  const auto index = network.FindPipe(estimate.pipe);
  if (!index) return {};
  const network::Pipe& pipe = network.pipes[*index];
  if (estimate.chainage_m < 0.0) return {"", pipe.upstream, 0.0};
  if (estimate.chainage_m > network::PipeAxis(network, pipe).length_m())
    return {"", pipe.downstream, 0.0};
  return {estimate.pipe, "", estimate.chainage_m};
}

double PositionError(const network::Network& network, const TruthSample& truth,
                     const EstimateSample& estimate) {
  const auto pipe = network.FindPipe(estimate.pipe);
  if (!pipe) return std::numeric_limits<double>::infinity();
  if (truth.place.pipe == estimate.pipe)
    return std::abs(truth.place.chainage_m - estimate.chainage_m);
  if (estimate.p_WChannel)
    return (*estimate.p_WChannel - truth.X_WB.translation().head<2>()).norm();
  const network::PipeAxis axis(network, network.pipes[*pipe]);
  return PlanDistance(axis.PoseAt(estimate.chainage_m).translation(), truth.X_WB.translation());
}

Verdict Judge(const Scenario& scenario, const MissionTrace& trace) {
  if (trace.estimate.empty() ||
      (!trace.truth.empty() && trace.truth.size() != trace.estimate.size())) {
    throw std::invalid_argument(
        "Judge: truth and estimate are to be taken at the same instants, at least one");
  }
  Verdict verdict;
  CountFaults(scenario, trace, verdict);
  if (trace.truth.empty()) {
    verdict.checks = ChecksWithoutTruth(scenario, trace);
  } else {
    verdict.checks = {GoalReached(scenario, trace),
                      FinishedInTime(scenario, trace),
                      NoTurnWithoutJunction(scenario, trace),
                      HeadingAlongPipe(scenario, trace),
                      SpeedLimit(scenario, trace),
                      NoUpperBoxCollision(trace),
                      LargestPositionError(scenario, trace),
                      FinalPositionError(scenario, trace)};
  }
  if (!verdict.planted.empty()) verdict.checks.push_back(FaultsFound(verdict));
  verdict.passed = std::all_of(verdict.checks.begin(), verdict.checks.end(),
                               [](const Check& check) { return check.passed; });
  verdict.metrics = Metrics(verdict, trace);
  return verdict;
}

}  // namespace kantaro::scenarios
