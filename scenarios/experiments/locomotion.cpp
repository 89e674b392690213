#include "scenarios/experiments/locomotion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/input_error.hpp"
#include "base/random.hpp"
#include "sim/physics.hpp"
#include "sim/sewer.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr std::size_t kStarts = 10;
constexpr double kShareToPass = 0.9;
constexpr double kOnItsSide = 0.5;  ///< cosine of 60°

struct Condition {
  std::string name;
  double friction;
};
const std::vector<Condition> kConditions{{"dry", 0.7}, {"wet", 0.3}};

/// Where the robot is, in words and for the judgement.
struct Place {
  std::string pipe;  ///< empty in a manhole
  double chainage_m{};
  std::string words;
};

Place PlaceOf(const sim::Sewer& sewer, const Vector3d& p_WB) {
  for (std::size_t i = 0; i < sewer.axes.size(); ++i) {
    const network::Pipe& pipe = sewer.network.pipes[i];
    const network::PipePosition at = sewer.axes[i].Locate(p_WB);
    if (at.chainage_m < 0.0 || at.chainage_m > sewer.axes[i].length_m()) continue;
    if (at.offset_m > pipe.DiameterAt(at.chainage_m) / 2.0) continue;
    return {pipe.name, at.chainage_m,
            fmt::format("at {:.2f} m of \"{}\"", at.chainage_m, pipe.name)};
  }
  const auto nearest =
      std::min_element(sewer.network.manholes.begin(), sewer.network.manholes.end(),
                       [&](const network::Manhole& a, const network::Manhole& b) {
                         return (a.p_WM - p_WB).head<2>().norm() < (b.p_WM - p_WB).head<2>().norm();
                       });
  return {"", 0.0, fmt::format("in manhole \"{}\"", nearest->name)};
}

/// A drive in progress.
class Drive {
 public:
  Drive(const robot::Description& description, const Course& course, const Profile& profile,
        double tyre_friction, const LocomotionStart& start)
      : description_(description),
        course_(course),
        profile_(profile),
        start_(start),
        sewer_(sim::BuildSewer(course.network)),
        field_(sewer_.voids, sewer_.solids),
        tyre_m_(description.tyres.at(description.wheels.front()).radius_m),
        physics_(field_, description, Options(description, tyre_friction)) {
    sim::StartPose pose = course.start;
    const double radius_m = course.network.PipeNamed(pose.pipe).diameter_m / 2.0;
    pose.chainage_m += start.chainage_m;
    pose.roll_rad += start.lateral_m / radius_m;
    pose.yaw_rad += start.yaw_rad;
    physics_.Place(sewer_, pose);
  }

  LocomotionOutcome Run() {
    double until_s = 0.0;
    for (const ProfileStep& step : profile_) {
      until_s += step.duration_s;
      physics_.Drive(step.left_m_s * (1.0 + start_.mismatch) / tyre_m_,
                     step.right_m_s * (1.0 - start_.mismatch) / tyre_m_);
      while (physics_.time_s() < until_s) {
        physics_.Step();
        touches_ = physics_.Touches(description_.upper_box);
        touched_ = touched_ || touches_;
        if (++steps_ % kLookEvery != 0) continue;
        if (const std::optional<std::string> end = Look()) return {end->empty(), *end, touched_};
      }
    }
    return {false,
            "stuck " + PlaceOf(sewer_, physics_.PoseOfBase().translation()).words +
                (touches_ ? ", the upper box against the wall" : ""),
            touched_};
  }

 private:
  static constexpr int kLookEvery = 25;  ///< steps: 5 mm of travel

  sim::PhysicsOptions Options(const robot::Description& description, double friction) const {
    sim::PhysicsOptions options;
    options.wheel_friction = friction * start_.friction_factor;
    double widest_m = 0.0;
    for (const network::Pipe& pipe : course_.network.pipes)
      widest_m = std::max(widest_m, pipe.diameter_m);
    options.mast_height_m = description.MastHeight(widest_m);
    return options;
  }

  /// Why the drive is over, empty at its goal.
  std::optional<std::string> Look() const {
    const Isometry3d X_WB = physics_.PoseOfBase();
    const Place place = PlaceOf(sewer_, X_WB.translation());
    if (X_WB.linear()(2, 2) < kOnItsSide) return FellOver(X_WB.linear()) + " " + place.words;
    if (place.pipe == course_.goal_pipe && place.chainage_m > course_.goal_chainage_m) {
      const bool ahead =
          X_WB.linear().col(0).dot(sewer_.axes[sewer_.network.FindPipe(place.pipe).value()]
                                       .PoseAt(place.chainage_m)
                                       .linear()
                                       .col(0)) > 0.0;
      return ahead ? "" : "turned round " + place.words;
    }
    const bool astray =
        !place.pipe.empty() && place.pipe != course_.goal_pipe && place.pipe != course_.start.pipe;
    if (astray && place.chainage_m > kAstray_m) return "went astray into \"" + place.pipe + "\"";
    return {};
  }

  /// Over its side or over its front or rear: whichever of its axes lies further from the level.
  static std::string FellOver(const Eigen::Matrix3d& R_WB) {
    if (std::abs(R_WB(2, 1)) >= std::abs(R_WB(2, 0))) return "rolled over";
    return R_WB(2, 0) < 0.0 ? "tipped over its front" : "tipped over its rear";
  }

  static constexpr double kAstray_m = 0.2;

  const robot::Description& description_;
  const Course& course_;
  const Profile& profile_;
  const LocomotionStart start_;
  const sim::Sewer sewer_;
  const sim::VoidField field_;
  const double tyre_m_;
  sim::Physics physics_;
  int steps_{};
  bool touches_{}, touched_{};  ///< the upper box the wall: now, and ever
};

// ---------------------------------------------------------------- rows

struct Row {
  const LocomotionCase* drive;
  double diameter_m;
  const Condition* condition;
  bool required;

  [[nodiscard]] std::string Name() const {
    return fmt::format("{} {:.0f} {}", drive->name, 1000.0 * diameter_m, condition->name);
  }
};

/// @throws InputError if `only` names what is no case
std::vector<Row> ListRows(const std::vector<std::string>& only) {
  const std::vector<LocomotionCase>& cases = LocomotionCases();
  for (const std::string& name : only) {
    if (std::any_of(cases.begin(), cases.end(), [&](const auto& c) { return c.name == name; }))
      continue;
    std::string known;
    for (const LocomotionCase& drive : cases) known += (known.empty() ? "" : ", ") + drive.name;
    throw InputError("--only", {}, "", fmt::format("\"{}\" is no case; known are {}", name, known));
  }
  std::vector<Row> rows;
  for (const LocomotionCase& drive : cases) {
    if (!only.empty() && std::find(only.begin(), only.end(), drive.name) == only.end()) continue;
    for (const double diameter_m : drive.diameters_m) {
      for (const Condition& condition : kConditions)
        rows.push_back({&drive, diameter_m, &condition, drive.required && diameter_m < 0.325});
    }
  }
  return rows;
}

/// Each reason once, the commonest first: "stuck in manhole "M" (3)".
std::string Sum(const std::vector<LocomotionOutcome>& outcomes) {
  std::map<std::string, int> counts;
  for (const LocomotionOutcome& outcome : outcomes) {
    if (!outcome.passed) ++counts[outcome.reason];
  }
  std::vector<std::pair<std::string, int>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [reason, count] : sorted)
    text += fmt::format("{}{} ({})", text.empty() ? "" : "; ", reason, count);
  return text;
}

Json ToJson(const Row& row, const std::vector<LocomotionOutcome>& outcomes) {
  const auto passed = std::count_if(outcomes.begin(), outcomes.end(),
                                    [](const LocomotionOutcome& o) { return o.passed; });
  const auto touched = std::count_if(outcomes.begin(), outcomes.end(),
                                     [](const LocomotionOutcome& o) { return o.touched; });
  return {{"case", row.drive->name},          {"diameter_mm", std::lround(1000.0 * row.diameter_m)},
          {"condition", row.condition->name}, {"passed", passed},
          {"runs", outcomes.size()},          {"reason", Sum(outcomes)},
          {"required", row.required},         {"upper_box_touched", touched}};
}

bool Passes(const Json& row) {
  return row.at("passed").get<double>() >= kShareToPass * row.at("runs").get<double>();
}

/// What chapter 2.7 says the mechanism does "without sensors and intelligent control", and the
/// cases that try it.
Json Claims() {
  const auto claim = [](const char* words, std::vector<std::string> cases) {
    return Json{{"section", "2.7"}, {"claim", words}, {"figure", nullptr}, {"cases", cases}};
  };
  return {
      claim("to move through any bends of the pipes",
            {"bend_45", "bend_90", "tee_left", "tee_right", "tee_straight", "cross"}),
      claim("to move through different sized pipes", {"straight", "step_250_300", "step_300_250"}),
      claim("to step down", {"drop_50", "drop_100", "offset_down_10"}),
      claim("to pass obstacles",
            {"lump_10", "lump_20", "ring_10", "offset_up_10", "offset_lateral_10", "gap_20"})};
}

Json Run(const ExperimentOptions& options) {
  const robot::Description description = robot::ReadDescription(options.robot_folder);
  const std::vector<Row> rows = ListRows(options.only);
  const std::size_t runs = options.count == 0 ? kStarts : options.count;
  std::vector<std::vector<LocomotionOutcome>> outcomes(rows.size(),
                                                       std::vector<LocomotionOutcome>(runs));
  std::mutex mutex;
  std::size_t done = 0;
  ForEachInParallel(rows.size() * runs, options.jobs, [&](std::size_t job) {
    const Row& row = rows[job / runs];
    const std::size_t run = job % runs;
    outcomes[job / runs][run] =
        DriveCourse(description, row.drive->course(row.diameter_m), row.drive->profile,
                    row.condition->friction, DrawStart(options.seed, row.Name(), run));
    const std::lock_guard lock(mutex);
    options.progress(++done, rows.size() * runs);
  });

  Json list = Json::array();
  bool passed = true;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    list.push_back(ToJson(rows[i], outcomes[i]));
    passed = passed && (!rows[i].required || Passes(list.back()));
  }
  return {{"experiment", "locomotion"},
          {"seed", options.seed},
          {"passed", passed},
          {"rows", list},
          {"thesis", Claims()}};
}

// ---------------------------------------------------------------- for people

/// "10/10", and a mark behind what fails.
std::string Score(const Json& row) {
  return fmt::format("{}/{}{}", row.at("passed").get<int>(), row.at("runs").get<int>(),
                     Passes(row)                      ? ""
                     : row.at("required").get<bool>() ? " FAIL"
                                                      : " (reported)");
}

std::string Table(const Json& result) {
  std::string text = fmt::format("{:<18}  {:>8}  {:<9}  {:<16}  {}\n", "case", "diameter",
                                 "condition", "passed", "reason");
  for (const Json& row : result.at("rows")) {
    text += fmt::format("{:<18}  {:>5} mm  {:<9}  {:<16}  {}\n", row.at("case").get<std::string>(),
                        row.at("diameter_mm").get<int>(), row.at("condition").get<std::string>(),
                        Score(row), row.at("reason").get<std::string>());
  }
  return text + fmt::format("locomotion seed {}: {}\n", result.at("seed").get<std::uint64_t>(),
                            result.at("passed") ? "passed" : "FAILED");
}

/// One line for each case, one column for each diameter and condition.
std::string Matrix(const Json& result) {
  std::string text = "| case | |";
  std::string rule = "|---|---|";
  std::vector<std::string> columns;
  std::map<std::string, std::map<std::string, std::string>> scores;
  for (const Json& row : result.at("rows")) {
    const std::string column = fmt::format("{} {}", row.at("diameter_mm").get<int>(),
                                           row.at("condition").get<std::string>());
    scores[row.at("case").get<std::string>()][column] = Score(row);
    if (std::find(columns.begin(), columns.end(), column) != columns.end()) continue;
    columns.push_back(column);
    text += " " + column + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const LocomotionCase& drive : LocomotionCases()) {
    if (!scores.contains(drive.name)) continue;
    text += fmt::format("| `{}` | {} |", drive.name, drive.what);
    for (const std::string& column : columns) text += " " + scores[drive.name][column] + " |";
    text += "\n";
  }
  return text;
}

/// Why runs did not arrive, row by row.
std::string Failures(const Json& result) {
  std::string text;
  for (const Json& row : result.at("rows")) {
    const std::string reason = row.at("reason").get<std::string>();
    if (reason.empty()) continue;
    text += fmt::format("- `{}` {} mm {}: {}\n", row.at("case").get<std::string>(),
                        row.at("diameter_mm").get<int>(), row.at("condition").get<std::string>(),
                        reason);
  }
  return text.empty() ? "" : "\nRuns that did not arrive:\n\n" + text;
}

/// A mission would be told of these as collisions: open loop the robot drives on.
std::string Collisions(const Json& result) {
  std::string text;
  for (const Json& row : result.at("rows")) {
    const int touched = row.value("upper_box_touched", 0);
    if (touched == 0) continue;
    text += fmt::format("{}`{}` {} mm {} ({})", text.empty() ? "" : ", ",
                        row.at("case").get<std::string>(), row.at("diameter_mm").get<int>(),
                        row.at("condition").get<std::string>(), touched);
  }
  return "\nRuns in which the upper box touched the wall on the way: " +
         (text.empty() ? "none" : text) + ".\n";
}

/// The thesis' words beside the rows that try them.
std::string Comparison(const Json& result) {
  std::string text = "\n| thesis | its figure | here: required rows passed |\n|---|---|---|\n";
  for (const Json& claim : result.at("thesis")) {
    std::size_t passed = 0, all = 0;
    for (const Json& row : result.at("rows")) {
      const Json& cases = claim.at("cases");
      const bool meant = std::find(cases.begin(), cases.end(), row.at("case")) != cases.end();
      if (!meant || !row.at("required").get<bool>()) continue;
      ++all;
      passed += Passes(row) ? 1 : 0;
    }
    text +=
        fmt::format("| {}: \"{}\" | none | {} of {} |\n", claim.at("section").get<std::string>(),
                    claim.at("claim").get<std::string>(), passed, all);
  }
  return text;
}

std::string Chapter(const Json& result) {
  return fmt::format(
             "## Locomotion\n\nOpen loop: wheel speeds are a function of time, one for each case, "
             "the same in every diameter and condition (15 cm/s straight ahead in a pipe, 20 cm/s "
             "against a ring, 10 cm/s through bends and manholes). Random starts: ±5 mm along and "
             "across, ±3°, friction ±10 %, left against right ±1.5 %. Dry is a friction of 0.7, "
             "wet 0.3. A row passes with at least 9 of 10; 350 mm and the ring of 20 mm are "
             "reported, not required ([why](robot.md#a-ring-of-20-mm)). Seed {}.\n\n",
             result.at("seed").get<std::uint64_t>()) +
         Matrix(result) + Failures(result) + Collisions(result) + Comparison(result);
}

}  // namespace

LocomotionStart DrawStart(std::uint64_t seed, const std::string& row, std::size_t run) {
  RandomStream stream(seed, fmt::format("locomotion.{}.{}", row, run));
  constexpr double kYaw_rad = 3.0 * std::numbers::pi / 180.0;
  LocomotionStart start;
  start.chainage_m = stream.Uniform(-0.005, 0.005);
  start.lateral_m = stream.Uniform(-0.005, 0.005);
  start.yaw_rad = stream.Uniform(-kYaw_rad, kYaw_rad);
  start.friction_factor = stream.Uniform(0.9, 1.1);
  start.mismatch = stream.Uniform(-0.015, 0.015);
  return start;
}

LocomotionOutcome DriveCourse(const robot::Description& description, const Course& course,
                              const Profile& profile, double tyre_friction,
                              const LocomotionStart& start) {
  try {
    return Drive(description, course, profile, tyre_friction, start).Run();
  } catch (const std::runtime_error& error) {
    return {false, error.what()};
  }
}

Experiment LocomotionExperiment() {
  return {"locomotion", "thesis 2.7: through bends, junctions, steps and obstacles without control",
          Run, Table, Chapter};
}

}  // namespace kantaro::scenarios
