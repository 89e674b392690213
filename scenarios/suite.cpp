#include "scenarios/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/input_error.hpp"
#include "scenarios/child_process.hpp"
#include "scenarios/html.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using Outcome = CaseResult::Outcome;

constexpr std::array<std::pair<Outcome, const char*>, 3> kOutcomes{
    {{Outcome::kPassed, "passed"}, {Outcome::kFailed, "failed"}, {Outcome::kCrashed, "crashed"}}};

std::string ToString(Outcome outcome) {
  return std::find_if(kOutcomes.begin(), kOutcomes.end(),
                      [&](const auto& o) { return o.first == outcome; })
      ->second;
}

std::vector<std::filesystem::path> ScenarioFiles(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() == ".yaml" && entry.is_regular_file())
      files.push_back(entry.path());
  }
  if (files.empty()) throw InputError(path, {}, "", "the folder holds no scenario (*.yaml)");
  std::sort(files.begin(), files.end());
  return files;
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

CaseResult Crashed(CaseResult result, const ChildResult& child) {
  const std::string told = FirstLine(child.err);
  const std::string how =
      child.signal != 0
          ? fmt::format("ended by signal {} ({})", child.signal, strsignal(child.signal))
          : fmt::format("ended with exit code {}", child.exit_code);
  result.message = told.empty() ? how : how + ": " + told;
  return result;
}

/// Reads the result.json that a mission printed.
CaseResult ToCaseResult(const SuiteCase& mission, const ChildResult& child) {
  CaseResult result;
  result.mission = mission;
  if (child.signal != 0 || child.exit_code > 1) return Crashed(std::move(result), child);
  try {
    const Json json = Json::parse(child.out);
    for (const Json& check : json.at("verdict").at("checks")) {
      if (check.at("passed").get<bool>()) continue;
      result.failed_checks.push_back(check.at("name").get<std::string>());
      if (!result.message.empty()) result.message += ' ';
      result.message += check.at("text").get<std::string>();
    }
    for (const auto& [name, value] : json.at("metrics").items()) {
      if (value.is_number()) result.metrics[name] = value.get<double>();
    }
    result.sim_s = json.at("timing").at("sim_s").get<double>();
    result.wall_s = json.at("timing").at("wall_s").get<double>();
    result.trace_sha256 = json.at("trace_sha256").get<std::string>();
    result.outcome =
        json.at("verdict").at("passed").get<bool>() ? Outcome::kPassed : Outcome::kFailed;
  } catch (const Json::exception&) {
    return Crashed(std::move(result), child);
  }
  return result;
}

// ---------------------------------------------------------------- the baseline

/// A metric of which less is better, and the change that is mere noise.
struct Watched {
  const char* name;
  const char* spoken;
  double noise;
};
constexpr std::array<Watched, 5> kWatched{
    {{"position_error_max_m", "largest position error (m)", 0.02},
     {"position_error_end_m", "final position error (m)", 0.02},
     {"duration_s", "duration (s)", 2.0},
     {"fault_misses", "missed faults", 0.5},
     {"fault_false_alarms", "false alarms", 0.5}}};

Json ParseBaseline(const std::string& text, const std::filesystem::path& name) {
  try {
    Json json = Json::parse(text);
    // Touch all that is used, so that a file of another kind is refused as a whole.
    for (const Json& mission : json.at("cases")) {
      static_cast<void>(mission.at("scenario").get<std::string>() +
                        mission.at("outcome").get<std::string>());
      static_cast<void>(mission.at("seed").get<std::uint64_t>());
      static_cast<void>(mission.at("metrics").get_ref<const Json::object_t&>());
    }
    return json;
  } catch (const Json::parse_error& error) {
    const auto line = std::count(
        text.begin(), text.begin() + static_cast<long>(std::min(error.byte, text.size())), '\n');
    throw InputError(name, static_cast<int>(line) + 1, "",
                     "not valid JSON; a suite.json is wanted as baseline");
  } catch (const Json::exception&) {
    throw InputError(
        name, {}, "cases",
        "not a suite.json: a list of missions with scenario, seed, outcome and metrics is wanted");
  }
}

const Json* FindCase(const Json& baseline, const SuiteCase& mission) {
  for (const Json& before : baseline.at("cases")) {
    if (before.at("scenario") == mission.scenario && before.at("seed") == mission.seed)
      return &before;
  }
  return nullptr;
}

/// Changes of the watched metrics, "worse" those that grew.
std::pair<std::string, std::string> CompareMetrics(const Json& before, const CaseResult& now) {
  std::string worse, better;
  for (const Watched& watched : kWatched) {
    const auto old_value = before.at("metrics").find(watched.name);
    const auto new_value = now.metrics.find(watched.name);
    if (old_value == before.at("metrics").end() || !old_value->is_number() ||
        new_value == now.metrics.end())
      continue;
    const double from = old_value->get<double>(), to = new_value->second;
    if (std::abs(to - from) <= std::max(watched.noise, 0.1 * std::abs(from))) continue;
    std::string& list = to > from ? worse : better;
    list +=
        fmt::format("{}{} {:.4g} -> {:.4g}", list.empty() ? "" : ", ", watched.spoken, from, to);
  }
  return {worse, better};
}

void CompareCase(const Json& before, const CaseResult& now, Comparison& comparison) {
  const SuiteCase& mission = now.mission;
  const bool passed_before = before.at("outcome") == "passed";
  const bool passes_now = now.outcome == Outcome::kPassed;
  const auto [worse, better] = passed_before && passes_now ? CompareMetrics(before, now)
                                                           : std::pair<std::string, std::string>();
  if (passed_before && !passes_now) {
    comparison.worse.push_back({mission.scenario, mission.seed,
                                fmt::format("now {}: {}", ToString(now.outcome), now.message)});
  } else if (!passed_before && passes_now) {
    comparison.better.push_back({mission.scenario, mission.seed, "now passed"});
  } else if (!worse.empty()) {
    comparison.worse.push_back({mission.scenario, mission.seed, worse});
  } else if (!better.empty()) {
    comparison.better.push_back({mission.scenario, mission.seed, better});
  } else {
    ++comparison.unchanged;
  }
}

Json ToJson(const std::vector<Comparison::Change>& changes) {
  Json list = Json::array();
  for (const Comparison::Change& change : changes) {
    list.push_back({{"scenario", change.scenario}, {"seed", change.seed}, {"text", change.text}});
  }
  return list;
}

// ---------------------------------------------------------------- per scenario

struct Sum {
  std::string scenario;
  std::size_t missions{}, passed{};
  double sim_s{}, wall_s{}, worst_error_m{};
};

std::vector<Sum> SumByScenario(const std::vector<CaseResult>& results) {
  std::vector<Sum> sums;
  for (const CaseResult& result : results) {
    auto sum = std::find_if(sums.begin(), sums.end(),
                            [&](const Sum& s) { return s.scenario == result.mission.scenario; });
    if (sum == sums.end())
      sum = sums.insert(sums.end(), Sum{result.mission.scenario, 0, 0, 0.0, 0.0, 0.0});
    ++sum->missions;
    sum->passed += result.outcome == Outcome::kPassed ? 1 : 0;
    sum->sim_s += result.sim_s;
    sum->wall_s += result.wall_s;
    const auto error = result.metrics.find("position_error_max_m");
    if (error != result.metrics.end())
      sum->worst_error_m = std::max(sum->worst_error_m, error->second);
  }
  return sums;
}

}  // namespace

std::vector<SuiteCase> ListCases(const SuiteOptions& options) {
  std::vector<SuiteCase> cases;
  std::map<std::string, std::filesystem::path> names;
  for (const std::filesystem::path& path : options.paths) {
    for (const std::filesystem::path& file : ScenarioFiles(path)) {
      const std::string name = ReadScenario(file).name;
      if (const auto [known, is_new] = names.emplace(name, file); !is_new) {
        throw InputError(
            file, {}, "name",
            fmt::format("\"{}\" is also the name of {}", name, known->second.string()));
      }
      for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
        cases.push_back({name, file, seed, options.out / name / fmt::format("seed-{}", seed)});
      }
    }
  }
  return cases;
}

std::vector<CaseResult> RunCases(const std::vector<SuiteCase>& cases, const SuiteOptions& options,
                                 const TellCase& tell) {
  std::vector<ChildJob> jobs;
  for (const SuiteCase& mission : cases) {
    ChildJob job{{options.program.string(), "run", mission.file.string(), "--seed",
                  std::to_string(mission.seed), "--out", mission.run_folder.string(), "--json"}};
    job.arguments.insert(job.arguments.end(), options.extra.begin(), options.extra.end());
    jobs.push_back(std::move(job));
  }
  std::vector<CaseResult> results(cases.size());
  std::size_t done = 0;
  RunChildren(jobs, options.jobs, [&](std::size_t job, const ChildResult& child) {
    results[job] = ToCaseResult(cases[job], child);
    tell(results[job], ++done, cases.size());
  });
  return results;
}

Comparison CompareWithBaseline(const std::vector<CaseResult>& results, const std::string& baseline,
                               const std::filesystem::path& name) {
  const Json json = ParseBaseline(baseline, name);
  Comparison comparison;
  std::size_t shared = 0;
  for (const CaseResult& result : results) {
    if (const Json* before = FindCase(json, result.mission)) {
      ++shared;
      CompareCase(*before, result, comparison);
    } else {
      ++comparison.added;
    }
  }
  comparison.removed = json.at("cases").size() - shared;
  return comparison;
}

Json SuiteJson(const std::vector<CaseResult>& results, const Comparison* comparison,
               const std::filesystem::path& out) {
  Json scenarios = Json::array(), cases = Json::array();
  for (const Sum& sum : SumByScenario(results)) {
    scenarios.push_back(
        {{"scenario", sum.scenario}, {"missions", sum.missions}, {"passed", sum.passed}});
  }
  for (const CaseResult& result : results) {
    const SuiteCase& mission = result.mission;
    cases.push_back({{"scenario", mission.scenario},
                     {"file", mission.file.string()},
                     {"seed", mission.seed},
                     {"outcome", ToString(result.outcome)},
                     {"message", result.message},
                     {"failed_checks", result.failed_checks},
                     {"metrics", result.metrics},
                     {"timing", {{"sim_s", result.sim_s}, {"wall_s", result.wall_s}}},
                     {"trace_sha256", result.trace_sha256},
                     {"run_folder", mission.run_folder.lexically_relative(out).generic_string()}});
  }
  const auto passed = std::count_if(results.begin(), results.end(), [](const CaseResult& r) {
    return r.outcome == Outcome::kPassed;
  });
  Json json{{"passed", AllPassed(results)},
            {"missions", results.size()},
            {"passed_missions", passed},
            {"scenarios", scenarios},
            {"cases", cases}};
  if (comparison != nullptr) {
    json["comparison"] = {{"worse", ToJson(comparison->worse)},
                          {"better", ToJson(comparison->better)},
                          {"unchanged", comparison->unchanged},
                          {"added", comparison->added},
                          {"removed", comparison->removed}};
  }
  return json;
}

std::string JunitXml(const std::vector<CaseResult>& results) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (const Sum& sum : SumByScenario(results)) {
    std::string cases;
    std::size_t failures = 0, errors = 0;
    for (const CaseResult& result : results) {
      if (result.mission.scenario != sum.scenario) continue;
      cases += fmt::format(R"(    <testcase classname="{}" name="seed {}" time="{:.3f}")",
                           Escape(sum.scenario), result.mission.seed, result.wall_s);
      if (result.outcome == Outcome::kPassed) {
        cases += "/>\n";
        continue;
      }
      const bool crashed = result.outcome == Outcome::kCrashed;
      ++(crashed ? errors : failures);
      cases += fmt::format("><{0} message=\"{1}\"/></testcase>\n", crashed ? "error" : "failure",
                           Escape(result.message));
    }
    xml += fmt::format(
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n{}  "
        "</testsuite>\n",
        Escape(sum.scenario), sum.missions, failures, errors, sum.wall_s, cases);
  }
  return xml + "</testsuites>\n";
}

std::string SuiteTable(const std::vector<CaseResult>& results, const Comparison* comparison) {
  std::size_t widest = 8;
  for (const CaseResult& result : results)
    widest = std::max(widest, result.mission.scenario.size());
  std::string table = fmt::format("{:<{}}  {:>8}  {:>12}  {:>12}  {:>9}\n", "scenario", widest,
                                  "passed", "worst error", "simulated", "real time");
  for (const Sum& sum : SumByScenario(results)) {
    table += fmt::format("{:<{}}  {:>8}  {:>10.2f} m  {:>10.1f} s  {:>7.1f} x\n", sum.scenario,
                         widest, fmt::format("{}/{}", sum.passed, sum.missions), sum.worst_error_m,
                         sum.sim_s, sum.wall_s > 0.0 ? sum.sim_s / sum.wall_s : 0.0);
  }
  for (const CaseResult& result : results) {
    if (result.outcome == Outcome::kPassed) continue;
    table += fmt::format("{} seed {} {}: {}\n", result.mission.scenario, result.mission.seed,
                         ToString(result.outcome), result.message);
  }
  if (comparison != nullptr) {
    table +=
        fmt::format("against the baseline: {} worse, {} better, {} unchanged, {} new, {} gone\n",
                    comparison->worse.size(), comparison->better.size(), comparison->unchanged,
                    comparison->added, comparison->removed);
    for (const Comparison::Change& change : comparison->worse) {
      table += fmt::format("worse: {} seed {}: {}\n", change.scenario, change.seed, change.text);
    }
  }
  return table;
}

bool AllPassed(const std::vector<CaseResult>& results) {
  return std::all_of(results.begin(), results.end(),
                     [](const CaseResult& r) { return r.outcome == Outcome::kPassed; });
}

}  // namespace kantaro::scenarios
