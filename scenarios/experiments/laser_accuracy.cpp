#include "scenarios/experiments/laser_accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/input_error.hpp"
#include "base/random.hpp"
#include "robot/mirror_angle.hpp"
#include "sim/range_sensors.hpp"
#include "sim/surface_mesh.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Isometry3d;
using Json = nlohmann::ordered_json;

constexpr std::size_t kRevolutions = 100;
// Table 5.1
constexpr double kAccuracy_mm = 1.0;
constexpr int kNearest_mm = 70, kFarthest_mm = 190;
/// The target's own: its facets, and the depth of a beam's disc on a round wall, 1 µm each.
constexpr double kTarget_mm = 0.002;
constexpr double kFewestSamples_Hz = 10000.0;
constexpr int kStep_mm = 10;

sim::RayCaster PipeAround(double radius_m) {
  sim::VoidPrimitive pipe;
  pipe.length_m = 0.1;
  pipe.radius_m = radius_m;
  sim::TessellationOptions fine;
  fine.tolerance_m = 1e-6;  // the scanner is measured, not the facets of its target
  return sim::RayCaster(sim::Tessellate(std::vector{pipe}, fine));
}

std::vector<robot::LaserRevolution> Scan(const robot::Laser& laser, double radius_m,
                                         double duration_s, std::uint64_t seed) {
  const sim::RayCaster rays = PipeAround(radius_m);
  sim::LaserScanner scanner(laser, rays,
                            RandomStream(seed, fmt::format("laser_accuracy.{:.0f}.{:.0f}",
                                                           1e6 * radius_m, laser.speed_rpm)));
  const Isometry3d X_WL(Eigen::Translation3d(0.05, 0.0, 0.0));
  std::vector<robot::LaserRevolution> revolutions;
  for (auto& completed : scanner.Scan(0.0, duration_s, X_WL, X_WL))
    revolutions.push_back(std::move(completed.revolution));
  return revolutions;
}

Json AccuracyRow(const robot::Laser& laser, int distance_mm, std::size_t revolutions,
                 std::uint64_t seed) {
  const LaserErrors errors = MeasureLaser(laser, distance_mm / 1000.0, revolutions, seed);
  const bool measurable = distance_mm >= kNearest_mm && distance_mm <= kFarthest_mm;
  const bool status_right = measurable                  ? true
                            : distance_mm < kNearest_mm ? errors.too_near == errors.beams
                                                        : errors.too_far == errors.beams;
  return {{"distance_mm", distance_mm},
          {"beams", errors.beams},
          {"too_near", errors.too_near},
          {"too_far", errors.too_far},
          {"mean_error_mm", 1000.0 * errors.mean_m},
          {"deviation_mm", 1000.0 * errors.deviation_m},
          {"largest_error_mm", 1000.0 * errors.largest_m},
          {"passed", status_right && 1000.0 * errors.largest_m <= kAccuracy_mm + kTarget_mm}};
}

/// How far the told angle lies behind the beam, and how many beams there are, at one speed.
Json SpeedRow(robot::Laser laser, double speed_rpm, std::uint64_t seed) {
  laser.speed_rpm = speed_rpm;
  constexpr double kDuration_s = 2.0;
  const auto revolutions = Scan(laser, 0.150, kDuration_s, seed);
  std::size_t beams = 0;
  for (const robot::LaserRevolution& revolution : revolutions) beams += revolution.samples.size();
  const double expected = std::floor(kDuration_s * speed_rpm / 60.0 + 1e-9);
  const double turns_s = static_cast<double>(revolutions.size()) * 60.0;
  const double rate_Hz =
      revolutions.empty() ? 0.0 : static_cast<double>(beams) * speed_rpm / turns_s;
  return {
      {"speed_rpm", speed_rpm},
      {"revolutions", revolutions.size()},
      {"seconds", kDuration_s},
      {"samples_Hz", rate_Hz},
      {"samples_per_revolution",
       revolutions.empty() ? 0.0
                           : static_cast<double>(beams) / static_cast<double>(revolutions.size())},
      {"angle_step_deg", 360.0 / laser.mirror_counts},
      {"passed", static_cast<double>(revolutions.size()) == expected &&
                     (speed_rpm == 0.0 || rate_Hz >= kFewestSamples_Hz)}};
}

Json Run(const ExperimentOptions& options) {
  if (!options.only.empty()) {
    throw InputError("--only", {}, "", "the laser's accuracy has no cases to choose from");
  }
  const robot::Laser laser = robot::ReadDescription(options.robot_folder).laser;
  const std::size_t revolutions = options.count == 0 ? kRevolutions : options.count;
  constexpr std::size_t kRows = (200 - 60) / kStep_mm + 1;
  std::vector<Json> accuracy(kRows);
  std::size_t done = 0;
  for (std::size_t i = 0; i < kRows; ++i) {
    accuracy[i] =
        AccuracyRow(laser, 60 + kStep_mm * static_cast<int>(i), revolutions, options.seed);
    options.progress(++done, kRows);
  }
  std::vector<Json> speeds;
  for (const double rpm : {0.0, 60.0, 600.0, 1200.0, 1700.0, 1800.0})
    speeds.push_back(SpeedRow(laser, rpm, options.seed));
  const auto passed = [](const Json& row) { return row.at("passed").get<bool>(); };
  return {{"experiment", "laser-accuracy"},
          {"seed", options.seed},
          {"passed", std::all_of(accuracy.begin(), accuracy.end(), passed) &&
                         std::all_of(speeds.begin(), speeds.end(), passed)},
          {"revolutions", revolutions},
          {"rows", accuracy},
          {"speeds", speeds},
          {"thesis",
           {{{"section", "Table 5.1"}, {"claim", "accuracy"}, {"figure", "±1 mm"}},
            {{"section", "Table 5.1"}, {"claim", "distance range"}, {"figure", "70 to 190 mm"}},
            {{"section", "Table 5.1"}, {"claim", "scanning speed"}, {"figure", "0 to 1800 rpm"}},
            {{"section", "Table 5.1"}, {"claim", "sampling speed"}, {"figure", "more than 10 kHz"}},
            {{"section", "fig 5.2"}, {"claim", "errors in distance"}, {"figure", nullptr}}}}};
}

std::string Mark(const Json& row) { return row.at("passed").get<bool>() ? "" : "  FAIL"; }

std::string Table(const Json& result) {
  std::string text = fmt::format("{:>8}  {:>8}  {:>9}  {:>9}  {:>9}  {:>8}  {:>8}\n", "distance",
                                 "beams", "mean", "deviation", "largest", "too near", "too far");
  for (const Json& row : result.at("rows")) {
    text +=
        fmt::format("{:>5} mm  {:>8}  {:>6.3f} mm  {:>6.3f} mm  {:>6.3f} mm  {:>8}  {:>8}{}\n",
                    row.at("distance_mm").get<int>(), row.at("beams").get<std::size_t>(),
                    row.at("mean_error_mm").get<double>(), row.at("deviation_mm").get<double>(),
                    row.at("largest_error_mm").get<double>(), row.at("too_near").get<std::size_t>(),
                    row.at("too_far").get<std::size_t>(), Mark(row));
  }
  for (const Json& row : result.at("speeds")) {
    text += fmt::format("{:>5.0f} rpm  {:>4} revolutions in {:.0f} s, {:.1f} samples in each{}\n",
                        row.at("speed_rpm").get<double>(), row.at("revolutions").get<int>(),
                        row.at("seconds").get<double>(),
                        row.at("samples_per_revolution").get<double>(), Mark(row));
  }
  return text + fmt::format("laser-accuracy seed {}: {}\n", result.at("seed").get<std::uint64_t>(),
                            result.at("passed").get<bool>() ? "passed" : "FAILED");
}

std::string Chapter(const Json& result) {
  std::string text = fmt::format(
      "## Laser accuracy\n\nThe scanner (Table 5.1) turns on the axis of round pipes, {} "
      "revolutions in each: every beam travels one radius. The thesis states ±1 mm from 70 to 190 "
      "mm; its fig 5.2 shows errors in distance measurement, of which the text gives no number. "
      "Errors are of the beams that were measured; at the ends of the range the error decides "
      "which are. Seed {}.\n\n"
      "| distance, mm | mean error, mm | standard deviation | largest | too near | too far | "
      "thesis "
      "|\n|---|---|---|---|---|---|---|\n",
      result.at("revolutions").get<std::size_t>(), result.at("seed").get<std::uint64_t>());
  for (const Json& row : result.at("rows")) {
    const int distance_mm = row.at("distance_mm").get<int>();
    const double beams = std::max(1.0, row.at("beams").get<double>());
    const bool none = row.at("too_near").get<double>() + row.at("too_far").get<double>() == beams;
    const auto error = [&](const char* key, const char* format) {
      return none ? std::string("–") : fmt::format(fmt::runtime(format), row.at(key).get<double>());
    };
    text += fmt::format("| {} | {} | {} | {} | {:.0f} % | {:.0f} % | {} |{}\n", distance_mm,
                        error("mean_error_mm", "{:+.3f}"), error("deviation_mm", "{:.3f}"),
                        error("largest_error_mm", "{:.3f}"),
                        100.0 * row.at("too_near").get<double>() / beams,
                        100.0 * row.at("too_far").get<double>() / beams,
                        distance_mm < kNearest_mm    ? "too near"
                        : distance_mm > kFarthest_mm ? "too far"
                                                     : "±1 mm",
                        Mark(row));
  }
  text +=
      "\n| speed, rpm | revolutions in 2 s | samples in each | samples/s | thesis |\n"
      "|---|---|---|---|---|\n";
  for (const Json& row : result.at("speeds")) {
    text += fmt::format("| {:.0f} | {} | {:.1f} | {:.0f} | 0 to 1800 rpm, more than 10 kHz |{}\n",
                        row.at("speed_rpm").get<double>(), row.at("revolutions").get<int>(),
                        row.at("samples_per_revolution").get<double>(),
                        row.at("samples_Hz").get<double>(), Mark(row));
  }
  return text;
}

}  // namespace

LaserErrors MeasureLaser(const robot::Laser& laser, double distance_m, std::size_t revolutions,
                         std::uint64_t seed) {
  const double duration_s = static_cast<double>(revolutions) * 60.0 / laser.speed_rpm;
  LaserErrors errors;
  double sum_m = 0.0, squares_m2 = 0.0;
  std::size_t valid = 0;
  for (const auto& revolution : Scan(laser, distance_m, duration_s, seed)) {
    for (const robot::LaserSample& sample : revolution.samples) {
      ++errors.beams;
      errors.too_near += sample.status == robot::RangeStatus::kTooNear ? 1 : 0;
      errors.too_far += sample.status == robot::RangeStatus::kTooFar ? 1 : 0;
      if (sample.status != robot::RangeStatus::kValid) continue;
      const double error_m = sample.range_m - distance_m;
      ++valid;
      sum_m += error_m;
      squares_m2 += error_m * error_m;
      errors.largest_m = std::max(errors.largest_m, std::abs(error_m));
    }
  }
  if (valid == 0) return errors;
  const double n = static_cast<double>(valid);
  errors.mean_m = sum_m / n;
  errors.deviation_m = std::sqrt(std::max(0.0, squares_m2 / n - errors.mean_m * errors.mean_m));
  return errors;
}

Experiment LaserAccuracyExperiment() {
  return {"laser-accuracy", "thesis fig 5.2, Table 5.1: the laser scanner's errors over its range",
          Run, Table, Chapter};
}

}  // namespace kantaro::scenarios
