#include "scenarios/experiments/stereo_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/random.hpp"
#include "perception/parameters.hpp"
#include "scenarios/experiments/bar_plot.hpp"
#include "scenarios/experiments/stereo_methods.hpp"
#include "scenarios/experiments/stereo_views.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kTrials = 10;  // section 5.3.2
constexpr int kDisparities = 64;
const std::vector<std::string> kYardsticks{"ssd-plain", "ssd", "stereobm", "stereosgbm"};

/// What must hold of times: `method` takes at most `most` of `of`.
struct Limit {
  std::string method, of;
  double most;
};
const std::vector<Limit> kLimits{
    {"lc", "ssd-plain", 1.0 / 5},           {"fast-nearest", "ssd-plain", 1.0 / 20},
    {"fast-linear", "ssd-plain", 1.0 / 20}, {"fast-cubic", "ssd-plain", 1.0 / 20},
    {"fast-nearest", "stereobm", 1.0 / 4},  {"fast-linear", "stereobm", 1.0 / 4},
    {"fast-cubic", "stereobm", 1.0 / 4}};

double ProcessorTime_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

Json Thesis() {
  return {{{"section", "5.3.2, fig 5.12"},
           {"claim", "LC takes about 1/5 of the time of gradient, SSD and SSD with constraints"},
           {"figure", 1.0 / 5}},
          {{"section", "5.4.2, fig 5.22"},
           {"claim", "fast stereo takes about 1/20 of the time of SSD and cross-correlation"},
           {"figure", 1.0 / 20}},
          {{"section", "Table 5.2"},
           {"claim", "nearest 6.1 s, linear 6.4 s, cubic 8.9 s (Pentium 4, 3 GHz)"},
           {"figure", nullptr}}};
}

/// The pairs to match: mouths at 0.55 to 1.5 m in a pipe of 300 mm.
std::vector<StereoView> Views(const ExperimentOptions& options, std::size_t count) {
  const robot::Description description = robot::ReadDescription(options.robot_folder);
  RandomStream random(options.seed, "stereo-speed");
  StereoStage stage(description, 0.300, options.seed);
  std::vector<StereoView> views;
  for (std::size_t i = 0; i < count; ++i) {
    const double distance_m = random.Uniform(0.55, 1.5);
    views.push_back(stage.See(distance_m, 1.0, options.seed, fmt::format("stereo-speed.{}", i)));
  }
  return views;
}

Json ToJson(const std::string& method, const std::map<std::string, double>& medians_ms,
            std::size_t views, double pixels) {
  const double time_ms = medians_ms.at(method);
  Json row{{"set", "reproduction"},
           {"method", method},
           {"landmark", "all"},
           {"condition", "all"},
           {"views", views},
           {"time_ms", time_ms},
           {"ns_per_pixel", 1e6 * time_ms / pixels}};
  for (const std::string& yardstick : kYardsticks)
    row["of_" + yardstick] = time_ms / medians_ms.at(yardstick);
  return row;
}

bool Keeps(const Json& row) {
  return std::all_of(kLimits.begin(), kLimits.end(), [&](const Limit& limit) {
    return row.at("method") != limit.method || row.at("of_" + limit.of).get<double>() <= limit.most;
  });
}

/// Fig 5.22. Each doubling of the time is a bar longer by the same.
std::string Plot(const Json& rows) {
  constexpr double kShortest_ms = 0.5, kLongest_ms = 1000.0;
  std::vector<Bar> bars;
  for (const Json& row : rows) {
    const double time_ms = row.at("time_ms");
    bars.push_back({row.at("method"),
                    fmt::format("{:.1f} ms, 1/{:.0f} of ssd-plain", time_ms,
                                1.0 / row.at("of_ssd-plain").get<double>()),
                    std::log(time_ms / kShortest_ms) / std::log(kLongest_ms / kShortest_ms),
                    row.at("method") == "fast-cubic"});
  }
  return PlotBars("Time of stereo matching, logarithmic", bars, {}, "");
}

Json Run(const ExperimentOptions& options) {
  const std::size_t trials = options.count == 0 ? kTrials : options.count;
  perception::stereo::Parameters parameters =
      perception::ReadParameters(options.robot_folder / "perception.yaml").stereo;
  parameters.min_disparity_px = 0;
  parameters.disparities = kDisparities;
  std::vector<std::string> only = options.only;
  if (!only.empty()) only.insert(only.end(), kYardsticks.begin(), kYardsticks.end());
  const auto methods = ChosenMethods(StereoMethods(parameters), only);
  const std::vector<StereoView> views = Views(options, trials);

  const OneThread one_thread;
  std::map<std::string, std::vector<double>> times_ms;
  std::size_t done = 0;
  for (const StereoView& view : views) {
    for (const StereoMethod& method : methods) {
      const double start_ms = ProcessorTime_ms();
      const cv::Mat disparity = method.match(view.flat.left, view.flat.right);
      times_ms[method.name].push_back(ProcessorTime_ms() - start_ms);
      options.progress(++done, views.size() * methods.size());
    }
  }
  std::map<std::string, double> medians_ms;
  for (const auto& [name, times] : times_ms) medians_ms[name] = Median(times);

  Json rows = Json::array();
  bool passed = true;
  for (const StereoMethod& method : methods) {
    rows.push_back(ToJson(method.name, medians_ms, trials,
                          static_cast<double>(views.front().flat.left.total())));
    passed = passed && Keeps(rows.back());
  }
  if (!options.out.empty()) WriteFileAtomically(options.out / "stereo-speed.svg", Plot(rows));
  return {{"experiment", "stereo-speed"},
          {"seed", options.seed},
          {"passed", passed},
          {"rows", rows},
          {"thesis", Thesis()}};
}

std::string Table(const Json& result) {
  std::string text =
      fmt::format("{:<13}  {:>10}  {:>12}  {:>12}  {:>8}  {:>11}  {:>13}\n", "method", "time",
                  "per pixel", "of ssd-plain", "of ssd", "of stereobm", "of stereosgbm");
  for (const Json& row : result.at("rows")) {
    text += fmt::format(
        "{:<13}  {:>7.2f} ms  {:>9.1f} ns  {:>12.4f}  {:>8.3f}  {:>11.3f}  {:>13.3f}{}\n",
        row.at("method").get<std::string>(), row.at("time_ms").get<double>(),
        row.at("ns_per_pixel").get<double>(), row.at("of_ssd-plain").get<double>(),
        row.at("of_ssd").get<double>(), row.at("of_stereobm").get<double>(),
        row.at("of_stereosgbm").get<double>(), Keeps(row) ? "" : "  FAIL");
  }
  return text + fmt::format("stereo-speed seed {}: {}\n", result.at("seed").get<std::uint64_t>(),
                            result.at("passed") ? "passed" : "FAILED");
}

std::string Chapter(const Json& result) {
  std::string text = fmt::format(
      "## Stereo: time\n\nProcessor time of one thread on 640 x 480 views, 64 disparities, "
      "smoothing "
      "included; medians of {} views. The thesis measures against SSD whose windows are summed "
      "anew (`ssd-plain`); a sliding window (`ssd`) gives the same result.\n\n"
      "| method | time | of `ssd-plain` | of `ssd` | of StereoBM | of StereoSGBM |\n"
      "|---|---|---|---|---|---|\n",
      result.at("rows").at(0).at("views").get<std::size_t>());
  for (const Json& row : result.at("rows")) {
    text += fmt::format("| `{}` | {:.1f} ms | 1/{:.1f} | {:.2f} | {:.2f} | {:.2f} |\n",
                        row.at("method").get<std::string>(), row.at("time_ms").get<double>(),
                        1.0 / row.at("of_ssd-plain").get<double>(), row.at("of_ssd").get<double>(),
                        row.at("of_stereobm").get<double>(), row.at("of_stereosgbm").get<double>());
  }
  text += "\n| thesis | its figure |\n|---|---|\n";
  for (const Json& claim : result.at("thesis")) {
    const Json& figure = claim.at("figure");
    text +=
        fmt::format("| {}: {} | {} |\n", claim.at("section").get<std::string>(),
                    claim.at("claim").get<std::string>(),
                    figure.is_null() ? "" : fmt::format("1/{:.0f}", 1.0 / figure.get<double>()));
  }
  return text;
}

}  // namespace

Experiment StereoSpeedExperiment() {
  return {"stereo-speed", "figs 5.12, 5.22, Table 5.2: what stereo matching costs", Run, Table,
          Chapter};
}

}  // namespace kantaro::scenarios
