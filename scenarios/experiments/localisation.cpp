#include "scenarios/experiments/localisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/input_error.hpp"
#include "perception/parameters.hpp"
#include "scenarios/experiments/landmark_views.hpp"
#include "scenarios/experiments/wilson.hpp"

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
  outcome.distance_m = view.plan.distance_m;
  for (const LandmarkPicture& picture : view.pictures) {
    const double before_ms = Cpu_ms();
    outcome.answer = asked->Update({picture.image, picture.right, picture.travel_m});
    outcome.time_ms = Cpu_ms() - before_ms;
  }
  return outcome;
}

Json RowOf(const char* set, const char* method, const std::string& landmark,
           const std::string& condition, const std::vector<const Outcome*>& outcomes) {
  std::size_t answered = 0, within_2cm = 0, within_5cm = 0, covered = 0, stated = 0;
  double sum_m = 0.0;
  std::vector<double> times_ms;
  for (const Outcome* outcome : outcomes) {
    times_ms.push_back(outcome->time_ms);
    within_2cm += outcome->Within(0.02) ? 1 : 0;
    within_5cm += outcome->Within(0.05) ? 1 : 0;
    if (!outcome->found()) continue;
    ++answered;
    sum_m += std::abs(outcome->error_m());
    if (outcome->answer.deviation_m <= 0.0) continue;
    ++stated;
    covered += outcome->Within(kIn95Percent * outcome->answer.deviation_m) ? 1 : 0;
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
  if (stated > 0) row["in_stated_interval"] = share(covered, stated);
  return row;
}

/// Rows of one method and set; the pooled one comes first.
void AddRows(const Trial& trial, const char* set, const char* method,
             const std::vector<Outcome>& outcomes, Json& rows) {
  using Group = std::pair<std::string, std::string>;
  std::vector<Group> order;
  std::map<Group, std::vector<const Outcome*>> groups;
  for (const Outcome& outcome : outcomes) {
    std::vector<Group> of{{"all", "all"}};
    if (outcome.view < trial.views() && outcomes.size() > trial.views())
      of.emplace_back("all", "the thesis' count");
    if (outcome.distance_m <= kUpTo_m) of.emplace_back("all", "up to 1.0 m");
    of.emplace_back(outcome.landmark, "all");
    if (std::string(set) == "stress") of.emplace_back("all", outcome.condition);
    for (const Group& group : of) groups[group].push_back(&outcome);
  }
  for (const auto& [group, members] : groups)
    rows.push_back(RowOf(set, method, group.first, group.second, members));
}

struct Requirement {
  const char* set;
  const char* condition;
  const char* key;
  double least, most;
};
/// Of `ours`, all landmarks together.
constexpr std::array<Requirement, 6> kRequired{{
    {"reproduction", "all", "within_5cm", 0.99, 1.0},
    {"stress", "all", "within_5cm", 0.97, 1.0},
    {"reproduction", "up to 1.0 m", "within_2cm", 0.95, 1.0},
    {"stress", "up to 1.0 m", "within_2cm", 0.95, 1.0},
    {"reproduction", "all", "in_stated_interval", 0.90, 0.98},
    {"stress", "all", "in_stated_interval", 0.90, 0.98},
}};

bool Fails(const Json& row) {
  return std::any_of(kRequired.begin(), kRequired.end(), [&](const Requirement& required) {
    if (row.at("method") != "ours" || row.at("landmark") != "all" ||
        row.at("set") != required.set || row.at("condition") != required.condition)
      return false;
    const Json& value = row.at(required.key);
    return !value.is_number() || value.get<double>() < required.least ||
           value.get<double>() > required.most;
  });
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

Json Run(const Trial& trial, const ExperimentOptions& options) {
  CheckMethods(options.only);
  const robot::Description description = robot::ReadDescription(options.robot_folder);
  perception::LandmarkParameters parameters =
      perception::ReadParameters(options.robot_folder / "perception.yaml").landmarks;
  parameters.calibration =
      perception::ReadLandmarkCalibration(options.robot_folder / "landmarks.yaml");
  const std::size_t count = options.count == 0 ? kRepeats * trial.views() : options.count;
  Json rows = Json::array(), points = Json::array();
  std::mutex mutex;
  std::size_t done = 0;
  for (const ViewSet set : kSets) {
    std::array<std::vector<Outcome>, kMethods.size()> outcomes;
    outcomes.fill(std::vector<Outcome>(count));
    const ViewRequest request{ViewPurpose::kTest,
                              set,
                              trial.cameras,
                              Kinds(trial, count),
                              options.seed,
                              options.jobs,
                              Wanted(options, "ours") ? kPicturesOfApproach : 1};
    ForEachView(description, request, [&](LandmarkView&& view) {
      for (std::size_t m = 0; m < kMethods.size(); ++m) {
        if (!Wanted(options, kMethods[m].first)) continue;
        outcomes[m][view.number] =
            Ask(description, parameters, trial.cameras, kMethods[m].second, view);
      }
      const std::lock_guard lock(mutex);
      options.progress(++done, kSets.size() * count);
    });
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      if (outcomes[m].front().landmark.empty()) continue;
      AddRows(trial, ToString(set), kMethods[m].first, outcomes[m], rows);
      for (const Outcome& outcome : outcomes[m]) {
        points.push_back({ToString(set), kMethods[m].first, outcome.landmark, outcome.condition,
                          outcome.distance_m,
                          outcome.found() ? Json(outcome.error_m()) : Json(nullptr),
                          outcome.answer.deviation_m});
      }
    }
  }
  return {{"experiment", trial.name},
          {"seed", options.seed},
          {"passed", std::none_of(rows.begin(), rows.end(), Fails)},
          {"rows", rows},
          {"thesis", ThesisRows(trial)},
          {"point_keys",
           {"set", "method", "landmark", "condition", "distance_m", "error_m", "deviation_m"}},
          {"points", points}};
}

std::string Percent(const Json& row, const char* key) {
  return row.at(key).is_null() ? "–" : fmt::format("{:.1f} %", 100.0 * row.at(key).get<double>());
}

std::string WithInterval(const Json& row, const char* key) {
  const Json& interval = row.at(std::string(key) + "_interval");
  return fmt::format("{} ({:.1f} to {:.1f})", Percent(row, key), 100.0 * interval[0].get<double>(),
                     100.0 * interval[1].get<double>());
}

std::string Millimetres(const Json& row) {
  const Json& error = row.at("mean_error_m");
  return error.is_null() ? "–" : fmt::format("{:.1f} mm", 1000.0 * error.get<double>());
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
        row.at("views").get<std::size_t>(), Percent(row, "answered"),
        WithInterval(row, "within_2cm"), WithInterval(row, "within_5cm"), Millimetres(row),
        Percent(row, "in_stated_interval"), row.at("time_ms").get<double>(),
        Fails(row) ? "  FAIL" : "");
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
      "interval. `in stated` is the share of errors inside the 95 % interval that the method "
      "states. Time is processor time for one picture{}.\n\n"
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
                    Percent(row, "in_stated_interval"), row.at("time_ms").get<double>());
  }
  text += "\nRequired of `ours`, all landmarks together:\n\n";
  for (const Requirement& required : kRequired) {
    for (const Json& row : result.at("rows")) {
      if (row.at("method") != "ours" || row.at("landmark") != "all" ||
          row.at("set") != required.set || row.at("condition") != required.condition)
        continue;
      const bool met = row.at(required.key).is_number() &&
                       row.at(required.key).get<double>() >= required.least &&
                       row.at(required.key).get<double>() <= required.most;
      text += fmt::format("- {}, {}: `{}` {:.0f} to {:.0f} %: {}, {}\n", required.set,
                          required.condition, required.key, 100.0 * required.least,
                          100.0 * required.most, Percent(row, required.key),
                          met ? "met" : "**not met**");
    }
  }
  return text;
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
