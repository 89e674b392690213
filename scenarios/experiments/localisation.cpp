#include "scenarios/experiments/localisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "perception/parameters.hpp"
#include "perception/thesis_landmarks.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/experiments/landmark_views.hpp"
#include "scenarios/experiments/localisation_plot.hpp"
#include "scenarios/experiments/localisation_requirements.hpp"
#include "scenarios/experiments/stereo_methods.hpp"
#include "scenarios/experiments/wilson.hpp"
#include "scenarios/landmark_calibration.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using perception::LandmarkAnswer;
using perception::LandmarkMethod;

constexpr double kUpTo_m = 1.0;
constexpr double kIn95Percent = 1.96;  ///< standard deviations to either side
constexpr std::array kSets{ViewSet::kReproduction, ViewSet::kStress};
constexpr std::array<std::pair<const char*, LandmarkMethod>, 2> kMethods{
    {{"thesis", LandmarkMethod::kThesis}, {"ours", LandmarkMethod::kOurs}}};
constexpr std::size_t kThesis = 0, kOurs = 1;
constexpr std::size_t kFieldLessons = 150;

/// What the thesis did, and found.
struct Trial {
  const char* name;
  const char* table;
  ViewCameras cameras;
  std::size_t manholes, joints, inlets;               ///< views of each
  double manhole_rate, joint_rate, inlet_rate, rate;  ///< within 5 cm
  [[nodiscard]] std::size_t views() const { return manholes + joints + inlets; }
};
constexpr Trial kMono{
    "mono-localisation", "Table 4.1", ViewCameras::kFront, 28, 28, 18, 1.0, 1.0, 1.0, 1.0};
/// The table's total of 92.33 % is the mean of its three rates; pooled it is 65 of 70.
constexpr Trial kStereo{"stereo-localisation",
                        "Table 5.4",
                        ViewCameras::kStereo,
                        32,
                        26,
                        12,
                        0.9687,
                        0.8846,
                        0.9166,
                        65.0 / 70.0};
constexpr std::size_t kRepeats = 10;  ///< of the thesis' count

/// One answer and what was so.
struct Outcome {
  std::size_t view{};
  std::string landmark, condition;
  bool clear{};  ///< no joint stands before it
  double distance_m{};
  LandmarkAnswer answer;
  double time_ms{};

  [[nodiscard]] bool found() const { return answer.status == LandmarkAnswer::Status::kFound; }
  [[nodiscard]] double error_m() const { return answer.distance_m - distance_m; }
  [[nodiscard]] bool Within(double most_m) const {
    return found() && std::abs(error_m()) <= most_m;
  }
};

/// Processor time of this thread.
double Cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

const char* WordOf(network::Material material) {
  switch (material) {
    case network::Material::kPvc:
      return "pvc";
    case network::Material::kClay:
      return "clay";
    case network::Material::kConcrete:
      return "concrete";
    case network::Material::kLined:
      return "lined";
  }
  throw std::invalid_argument("no such material");
}

std::string ConditionOf(const LandmarkView& view) {
  return fmt::format("{}, {}, {}", WordOf(view.material),
                     view.condition == network::WallCondition::kDry ? "dry" : "wet",
                     view.light < 1.0 ? "dimmed" : "bright");
}

Outcome Ask(const robot::Description& description, perception::LandmarkParameters parameters,
            ViewCameras cameras, LandmarkMethod method, const LandmarkView& view) {
  parameters.mono = parameters.stereo = method;
  const auto make = cameras == ViewCameras::kFront ? perception::MakeMonoDistance
                                                   : perception::MakeStereoDistance;
  const auto asked = make(description, parameters, view.plan.kind, view.sizes);
  Outcome outcome;
  outcome.view = view.number;
  outcome.landmark = ToString(perception::ClassOf(view.plan.kind));
  outcome.condition = ConditionOf(view);
  outcome.clear = view.clear;
  outcome.distance_m = view.plan.distance_m;
  double before_ms = 0.0;
  for (const LandmarkPicture& picture : view.pictures) {
    before_ms = Cpu_ms();
    asked->Add({picture.image, picture.right, picture.travel_m});
  }
  outcome.answer = asked->Answer();
  outcome.time_ms = Cpu_ms() - before_ms;
  return outcome;
}

Json RowOf(const char* set, const char* method, const std::string& landmark,
           const std::string& condition, const std::vector<const Outcome*>& outcomes) {
  std::size_t answered = 0, within_2cm = 0, within_5cm = 0, covered = 0;
  bool states = false;
  double sum_m = 0.0;
  std::vector<double> times_ms;
  for (const Outcome* outcome : outcomes) {
    times_ms.push_back(outcome->time_ms);
    within_2cm += outcome->Within(0.02) ? 1 : 0;
    within_5cm += outcome->Within(0.05) ? 1 : 0;
    if (!outcome->found()) continue;
    ++answered;
    sum_m += std::abs(outcome->error_m());
    const double deviation_m = outcome->answer.deviation_m;
    states = states || deviation_m > 0.0;
    covered += deviation_m > 0.0 && outcome->Within(kIn95Percent * deviation_m) ? 1 : 0;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  const auto interval = [&](std::size_t hits) {
    const Rate rate = WilsonRate(hits, outcomes.size());
    return Json{rate.low, rate.high};
  };
  std::nth_element(times_ms.begin(),
                   times_ms.begin() + static_cast<std::ptrdiff_t>(times_ms.size() / 2),
                   times_ms.end());
  Json row{{"set", set},
           {"method", method},
           {"landmark", landmark},
           {"condition", condition},
           {"views", outcomes.size()},
           {"answered", share(answered, outcomes.size())},
           {"within_2cm", share(within_2cm, outcomes.size())},
           {"within_2cm_interval", interval(within_2cm)},
           {"within_5cm", share(within_5cm, outcomes.size())},
           {"within_5cm_interval", interval(within_5cm)},
           {"mean_error_m", nullptr},
           {"in_stated_interval", nullptr},
           {"time_ms", times_ms[times_ms.size() / 2]}};
  if (answered > 0) row["mean_error_m"] = sum_m / static_cast<double>(answered);
  if (states) row["in_stated_interval"] = share(covered, outcomes.size());
  return row;
}

/// What parts of the thesis' stereo method say by themselves, and how many of the edge pixels lie
/// where the landmark is: why it does as it does.
struct StereoParts {
  Outcome fits, matching;
  std::optional<double> edges_on_landmark;  ///< share whose distance is within 5 cm
};

StereoParts AskParts(const robot::Description& description,
                     const perception::LandmarkParameters& parameters, const LandmarkView& view,
                     const Outcome& whole) {
  const LandmarkPicture& picture = view.pictures.back();
  auto sight = perception::SeeByStereo(
      picture.image, picture.right,
      description.stereo_left.focal_px * robot::StereoBaseline_m(description), parameters,
      view.plan.kind);
  StereoParts parts{whole, whole, {}};
  const auto answer = [](double distance_m) {
    return LandmarkAnswer{LandmarkAnswer::Status::kFound, distance_m};
  };
  parts.fits.answer = answer((sight.tau1_m + sight.tau2_m) / 2.0);
  parts.matching.answer = {};
  auto& all_m = sight.distances_m;
  if (all_m.empty()) return parts;
  const auto right = std::ranges::count_if(all_m, [&](double distance_m) {
    return std::abs(distance_m - view.plan.distance_m) <= 0.05;
  });
  parts.edges_on_landmark = static_cast<double>(right) / static_cast<double>(all_m.size());
  const auto middle = all_m.begin() + static_cast<std::ptrdiff_t>(all_m.size() / 2);
  std::nth_element(all_m.begin(), middle, all_m.end());
  parts.matching.answer = answer(*middle);
  return parts;
}

void AddPartRows(const char* set, const std::vector<StereoParts>& parts, Json& rows) {
  std::vector<const Outcome*> fits, matching;
  double sum = 0.0, views = 0.0;
  for (const StereoParts& part : parts) {
    fits.push_back(&part.fits);
    matching.push_back(&part.matching);
    sum += part.edges_on_landmark.value_or(0.0);
    views += part.edges_on_landmark ? 1.0 : 0.0;
  }
  rows.push_back(RowOf(set, "thesis", "all", "fits alone", fits));
  rows.push_back(RowOf(set, "thesis", "all", "matching alone", matching));
  if (views > 0.0) rows.back()["edges_on_landmark"] = sum / views;
}

/// Rows of one method and set; the pooled one comes first.
void AddRows(const Trial& trial, const char* set, const char* method,
             const std::vector<Outcome>& outcomes, Json& rows) {
  using Group = std::pair<std::string, std::string>;
  std::map<Group, std::vector<const Outcome*>> groups;
  for (const Outcome& outcome : outcomes) {
    std::vector<Group> of{{"all", "all"}};
    if (outcome.view < trial.views() && outcomes.size() > trial.views())
      of.emplace_back("all", "the thesis' count");
    if (outcome.distance_m <= kUpTo_m) of.emplace_back("all", "up to 1.0 m");
    if (outcome.clear) of.emplace_back("all", "no joint before it");
    of.emplace_back(outcome.landmark, "all");
    if (std::string(set) == "stress") of.emplace_back("all", outcome.condition);
    for (const Group& group : of) groups[group].push_back(&outcome);
  }
  for (const auto& [group, members] : groups)
    rows.push_back(RowOf(set, method, group.first, group.second, members));
}

Json ThesisRows(const Trial& trial) {
  const auto row = [&](const char* landmark, std::size_t views, double rate) {
    return Json{{"section", trial.table},
                {"landmark", landmark},
                {"condition", "all"},
                {"views", views},
                {"within_5cm", rate}};
  };
  return {row("manhole", trial.manholes, trial.manhole_rate),
          row("joint", trial.joints, trial.joint_rate),
          row("inlet", trial.inlets, trial.inlet_rate), row("all", trial.views(), trial.rate)};
}

void CheckMethods(const std::vector<std::string>& only) {
  for (const std::string& word : only) {
    if (std::none_of(kMethods.begin(), kMethods.end(),
                     [&](const auto& method) { return word == method.first; })) {
      throw InputError("--only", {}, "",
                       fmt::format("\"{}\" is no method; there are thesis and ours", word));
    }
  }
}

bool Wanted(const ExperimentOptions& options, const char* method) {
  return options.only.empty() ||
         std::find(options.only.begin(), options.only.end(), method) != options.only.end();
}

/// The thesis' proportions, again and again.
std::vector<perception::LandmarkKind> Kinds(const Trial& trial, std::size_t count) {
  const auto once = SpreadKinds(trial.manholes, trial.joints, trial.inlets);
  std::vector<perception::LandmarkKind> kinds(count);
  for (std::size_t i = 0; i < count; ++i) kinds[i] = once[i % once.size()];
  return kinds;
}

/// One set of views to measure.
struct Measurement {
  const Trial& trial;
  const ExperimentOptions& options;
  const robot::Description& description;
  const perception::LandmarkParameters& parameters;
  ViewSet set;
  std::size_t count, all;  ///< views, and of all sets
};

/// Each view is drawn once, and all methods judge it. Of the field, the thesis' alone.
void MeasureSet(const Measurement& m, std::size_t& done, Json& rows, Json& points) {
  const auto wanted = [&](std::size_t method) {
    return Wanted(m.options, kMethods[method].first) &&
           (m.set != ViewSet::kField || kMethods[method].second == LandmarkMethod::kThesis);
  };
  std::array<std::vector<Outcome>, kMethods.size()> outcomes;
  outcomes.fill(std::vector<Outcome>(m.count));
  const ViewRequest request{ViewPurpose::kTest,
                            m.set,
                            m.trial.cameras,
                            Kinds(m.trial, m.count),
                            m.options.seed,
                            m.options.jobs,
                            wanted(kOurs) ? perception::kPicturesOfApproach : 1};
  const bool apart = m.trial.cameras == ViewCameras::kStereo && wanted(kThesis);
  std::vector<StereoParts> parts(apart ? m.count : 0);
  std::mutex mutex;
  ForEachView(m.description, request, [&](LandmarkView&& view) {
    for (std::size_t method = 0; method < kMethods.size(); ++method) {
      if (!wanted(method)) continue;
      outcomes[method][view.number] =
          Ask(m.description, m.parameters, m.trial.cameras, kMethods[method].second, view);
    }
    if (apart)
      parts[view.number] =
          AskParts(m.description, m.parameters, view, outcomes[kThesis][view.number]);
    const std::lock_guard lock(mutex);
    m.options.progress(std::min(++done, m.all), m.all);
  });
  for (std::size_t method = 0; method < kMethods.size(); ++method) {
    if (!wanted(method)) continue;
    AddRows(m.trial, ToString(m.set), kMethods[method].first, outcomes[method], rows);
    for (const Outcome& outcome : outcomes[method]) {
      points.push_back({ToString(m.set), kMethods[method].first, outcome.landmark,
                        outcome.condition, outcome.distance_m,
                        outcome.found() ? Json(outcome.error_m()) : Json(nullptr),
                        outcome.answer.deviation_m});
    }
  }
  if (apart) AddPartRows(ToString(m.set), parts, rows);
}

Json Run(const Trial& trial, const ExperimentOptions& options) {
  CheckMethods(options.only);
  const OneThread one_thread;  // or what OpenCV's workers do would be missing in the times
  const robot::Description description = robot::ReadDescription(options.robot_folder);
  perception::LandmarkParameters parameters =
      perception::ReadParameters(options.robot_folder / "perception.yaml").landmarks;
  parameters.calibration =
      perception::ReadLandmarkCalibration(options.robot_folder / "landmarks.yaml");
  const std::size_t count = options.count == 0 ? kRepeats * trial.views() : options.count;
  Json rows = Json::array(), points = Json::array();
  std::size_t done = 0;
  const std::size_t all = kSets.size() * count;
  for (const ViewSet set : kSets)
    MeasureSet({trial, options, description, parameters, set, count, all}, done, rows, points);
  if (Wanted(options, "thesis")) {
    CalibrationOptions field;
    field.seed = options.seed;
    field.views = kFieldLessons;
    field.jobs = options.jobs;
    CalibrateThesis(description, parameters, ViewSet::kField, trial.cameras, field,
                    parameters.calibration);
    MeasureSet({trial, options, description, parameters, ViewSet::kField,
                std::min(count, trial.views()), all},
               done, rows, points);
  }
  const Json result{
      {"experiment", trial.name},
      {"seed", options.seed},
      {"passed", !Wanted(options, "ours") || MeetsRequirements(rows)},
      {"rows", rows},
      {"thesis", ThesisRows(trial)},
      {"point_keys",
       {"set", "method", "landmark", "condition", "distance_m", "error_m", "deviation_m"}},
      {"points", points}};
  if (!options.out.empty())
    WriteFileAtomically(options.out / (std::string(trial.name) + ".svg"), PlotErrors(result));
  return result;
}

std::string WithInterval(const Json& row, const char* key) {
  const Json& interval = row.at(std::string(key) + "_interval");
  return fmt::format("{} ({:.1f} to {:.1f})", PercentText(row, key),
                     100.0 * interval[0].get<double>(), 100.0 * interval[1].get<double>());
}

std::string Millimetres(const Json& row) {
  const Json& error = row.at("mean_error_m");
  if (error.is_null()) return "–";
  const std::string text = fmt::format("{:.1f} mm", 1000.0 * error.get<double>());
  return row.at("answered") == 1.0 ? text : text + " of " + PercentText(row, "answered");
}

std::string Table(const Json& result) {
  std::string text =
      fmt::format("{:<13} {:<7} {:<8} {:<18} {:>5} {:>8} {:>24} {:>24} {:>10} {:>10} {:>8}\n",
                  "set", "method", "landmark", "condition", "views", "answered", "in 2 cm",
                  "in 5 cm", "error", "in stated", "time");
  for (const Json& row : result.at("rows")) {
    text += fmt::format(
        "{:<13} {:<7} {:<8} {:<18} {:>5} {:>8} {:>24} {:>24} {:>10} {:>10} {:>5.1f} ms{}\n",
        row.at("set").get<std::string>(), row.at("method").get<std::string>(),
        row.at("landmark").get<std::string>(), row.at("condition").get<std::string>(),
        row.at("views").get<std::size_t>(), PercentText(row, "answered"),
        WithInterval(row, "within_2cm"), WithInterval(row, "within_5cm"), Millimetres(row),
        PercentText(row, "in_stated_interval"), row.at("time_ms").get<double>(),
        FailsRequirement(row) ? "  FAIL" : "");
  }
  return text + fmt::format("{} seed {}: {}\n", result.at("experiment").get<std::string>(),
                            result.at("seed").get<std::uint64_t>(),
                            result.at("passed") ? "passed" : "FAILED");
}

/// The thesis' figure beside a row; it has none but for the reproduction.
std::string Beside(const Json& result, const Json& row) {
  if (row.at("set") != "reproduction" || row.at("condition") != "all") return "";
  for (const Json& claim : result.at("thesis")) {
    if (claim.at("landmark") == row.at("landmark")) {
      return fmt::format("{:.1f} % of {}", 100.0 * claim.at("within_5cm").get<double>(),
                         claim.at("views").get<std::size_t>());
    }
  }
  return "";
}

std::string Chapter(const Json& result) {
  const bool mono = result.at("experiment") == kMono.name;
  std::string text = fmt::format(
      "## {}: {}\n\nSeed {}. Rates count no answer as wrong; in brackets their 95 % Wilson "
      "interval. The mean error is that of answers: where there are fewer than views, the share is "
      "told. `in stated` is the share of views whose error lies inside the 95 % interval that the "
      "method states. Time is processor time from the last picture{} to the answer.\n\n"
      "| set | method | landmark | condition | views | in 2 cm | in 5 cm | thesis, in 5 cm | mean "
      "error | in stated | time |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      mono ? "By a single camera" : "By the stereo pair", mono ? kMono.table : kStereo.table,
      result.at("seed").get<std::uint64_t>(), mono ? "" : " pair");
  for (const Json& row : result.at("rows")) {
    text +=
        fmt::format("| {} | `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {:.0f} ms |\n",
                    row.at("set").get<std::string>(), row.at("method").get<std::string>(),
                    row.at("landmark").get<std::string>(), row.at("condition").get<std::string>(),
                    row.at("views").get<std::size_t>(), WithInterval(row, "within_2cm"),
                    WithInterval(row, "within_5cm"), Beside(result, row), Millimetres(row),
                    PercentText(row, "in_stated_interval"), row.at("time_ms").get<double>());
  }
  return text + RequirementsText(result.at("rows"));
}

Json RunMono(const ExperimentOptions& options) { return Run(kMono, options); }
Json RunStereo(const ExperimentOptions& options) { return Run(kStereo, options); }

}  // namespace

Experiment MonoLocalisationExperiment() {
  return {kMono.name, "Table 4.1: how far landmarks are, by a single camera",
          RunMono,    Table,
          Chapter,    true};
}

Experiment StereoLocalisationExperiment() {
  return {kStereo.name, "Table 5.4: how far landmarks are, by the stereo pair",
          RunStereo,    Table,
          Chapter,      true};
}

}  // namespace kantaro::scenarios
