#include <fmt/format.h>

#include <algorithm>

#include "scenarios/html.hpp"
#include "scenarios/report_style.hpp"
#include "scenarios/suite.hpp"

namespace kantaro::scenarios {
namespace {

using Outcome = CaseResult::Outcome;

constexpr char kStyle[] = R"css(
.missions td{vertical-align:top}.missions a{color:var(--truth)}.missions .why{max-width:52ch;overflow-wrap:anywhere}
@media screen and (max-width:640px){.missions thead{display:none}
.missions tr{display:grid;grid-template-columns:1fr 1fr;gap:0 14px;padding:11px 0;border-bottom:1px solid var(--rule)}
.missions td{border:0;padding:0;text-align:left;overflow-wrap:anywhere}.missions .why{grid-column:1/-1}.missions .why:empty{display:none}
.missions .number{font-size:.85rem;color:var(--soft);white-space:normal}
.missions .number[data-label]::before{content:attr(data-label) " "}}
)css";

std::string Mark(Outcome outcome) {
  switch (outcome) {
    case Outcome::kPassed:
      return R"(<span class="tag ok">passed</span>)";
    case Outcome::kFailed:
      return R"(<span class="tag no">failed</span>)";
    case Outcome::kCrashed:
      return R"(<span class="tag no">crashed</span>)";
  }
  return "";
}

/// A cell that a narrow screen shows with its label.
std::string Number(const char* label, const std::string& value) {
  return fmt::format(R"(<td class="number" data-label="{}">{}</td>)", label, value);
}

std::string Metric(const CaseResult& result, const char* name, double times, const char* unit) {
  const auto metric = result.metrics.find(name);
  return metric == result.metrics.end() ? "–"
                                        : fmt::format("{:.0f} {}", times * metric->second, unit);
}

std::string Row(const CaseResult& result, const std::filesystem::path& out) {
  const SuiteCase& mission = result.mission;
  const std::string name = fmt::format("{} · seed {}", Escape(mission.scenario), mission.seed);
  // One that crashed left no report.
  const std::string report =
      (mission.run_folder / "report.html").lexically_relative(out).generic_string();
  const std::string link = result.outcome == Outcome::kCrashed
                               ? name
                               : fmt::format(R"(<a href="{}">{}</a>)", Escape(report), name);
  return fmt::format(
      "<tr><td>{}</td><td>{}</td>{}{}{}<td class=\"why\">{}</td></tr>", link, Mark(result.outcome),
      Number("worst error", Metric(result, "position_error_max_m", 100.0, "cm")),
      Number("simulated", fmt::format("{:.0f} s", result.sim_s)),
      Number("real time",
             result.wall_s > 0.0 ? fmt::format("{:.1f} ×", result.sim_s / result.wall_s) : "–"),
      Escape(result.message));
}

std::string Changes(const Comparison* comparison) {
  if (comparison == nullptr) return "";
  std::string items;
  for (const Comparison::Change& change : comparison->worse) {
    items += fmt::format("<li>{} seed {}: {}</li>", Escape(change.scenario), change.seed,
                         Escape(change.text));
  }
  return fmt::format(
      R"(<section><h2>Against the baseline</h2><p class="note">{} worse, {} better, {} unchanged, {} new, {} gone.</p><ul>{}</ul></section>)",
      comparison->worse.size(), comparison->better.size(), comparison->unchanged, comparison->added,
      comparison->removed, items);
}

}  // namespace

std::string SuiteHtml(const std::vector<CaseResult>& results, const Comparison* comparison,
                      const std::filesystem::path& out) {
  std::string failed, passed;
  for (const CaseResult& result : results)
    (result.outcome == Outcome::kPassed ? passed : failed) += Row(result, out);
  const auto good = std::count_if(results.begin(), results.end(), [](const CaseResult& result) {
    return result.outcome == Outcome::kPassed;
  });
  return fmt::format(
      R"(<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1"><title>{0} of {1} missions passed</title><style>{2}{3}</style></head><body><main><p class="eyebrow">Suite</p><h1>{0} of {1} missions passed</h1>{4}<section class="table-section"><table class="missions"><thead><tr><th>Mission</th><th>Outcome</th><th class="number">Worst error</th><th class="number">Simulated</th><th class="number">Against real time</th><th>Why not</th></tr></thead><tbody>{5}{6}</tbody></table></section></main></body></html>
)",
      good, results.size(), kReportStyle, kStyle, Changes(comparison), failed, passed);
}

}  // namespace kantaro::scenarios
