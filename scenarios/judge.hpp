#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/mission_trace.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// One question put to a run, answered from ground truth, or without it where it can be.
struct Check {
  std::string name;  ///< snake_case, stable: baselines are compared by it
  bool passed{};
  double value{};
  double limit{};
  std::string unit;            ///< may be empty (a count)
  std::string text;            ///< one sentence
  std::optional<double> at_s;  ///< when it was worst or first went wrong
  std::string place;           ///< and where, in words; may be empty
  bool judged{true};           ///< false: it cannot be told without ground truth; not failed either
};

/// What became of one planted fault on the driven route.
struct PlantedFault {
  std::string pipe, name;
  double chainage_m{}, clock_h{};
  bool found{};
};

struct Verdict {
  bool passed{};  ///< all checks that were judged
  std::vector<Check> checks;
  std::map<std::string, double> metrics;  ///< by name, unit in the name
  std::vector<PlantedFault> planted;      ///< on the driven route, in the order of the network
  /// For each of trace.faults: it lies at a planted one. Empty without ground truth.
  std::vector<bool> true_alarm;
};

/// Judges a run from ground truth alone; the robot's own words count only for what they claim (its
/// position, the faults it reports, that it is done). Checks: goal_reached, finished_in_time,
/// no_turn_without_junction, heading_along_pipe, speed_limit, no_upper_box_collision,
/// position_error, final_position_error and, where a fault was planted on the way, faults_found.
/// Without ground truth the end is the robot's word, the speed the one commanded, and the rest is
/// not judged.
/// @pre the trace's truth, if any, and estimate were taken at the same instants.
/// @throws std::invalid_argument if they were not.
[[nodiscard]] Verdict Judge(const Scenario& scenario, const MissionTrace& trace);

/// Distance between where the robot was and where it thought it was [m]: along the pipe if both are
/// in the same one, otherwise in plan between the base and the estimated point of channel or axis.
/// Infinite without an estimate.
[[nodiscard]] double PositionError(const network::Network& network, const TruthSample& truth,
                                   const EstimateSample& estimate);

/// The place that an estimate stands for: beyond an end of its pipe the robot means the manhole
/// there.
[[nodiscard]] Place PlaceOf(const network::Network& network, const EstimateSample& estimate);

/// "pipe A at 3.20 m" or "manhole M1".
[[nodiscard]] std::string ToWords(const Place& place);

}  // namespace kantaro::scenarios
