#include "scenarios/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>

#include "scenarios/drawings.hpp"
#include "scenarios/html.hpp"
#include "scenarios/report_style.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kWide_px = 1030.0;
constexpr double kNarrow_px = 340.0;

/// A sentence's beginning.
std::string Capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// "no_turn_without_junction" as "No turn without junction".
std::string Spoken(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return Capital(std::move(name));
}

std::string Value(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "none";
  const int digits = unit.empty() ? 0 : unit == "deg" || unit == "s" ? 1 : unit == "m/s" ? 3 : 2;
  const std::string shown_unit = unit.empty() ? "" : unit == "deg" ? "°" : " " + unit;
  return fmt::format("{:.{}f}{}", value, digits, shown_unit);
}

/// 83.4 s as "1:23 min".
std::string Duration(double seconds) {
  if (seconds < 100.0) return fmt::format("{:.1f}<small>s</small>", seconds);
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}<small>min</small>", whole / 60, whole % 60);
}

std::string Picture(const std::string& jpeg, const std::string& description) {
  return fmt::format(R"(<img alt="{}" src="data:image/jpeg;base64,{}">)", Escape(description),
                     Base64(jpeg));
}

std::string Both(const std::string& wide, const std::string& narrow) {
  return R"(<div class="wide">)" + wide + R"(</div><div class="narrow">)" + narrow + "</div>";
}

/// Not a number where it was not measured.
double Metric(const Result& result, const std::string& name) {
  const auto metric = result.verdict.metrics.find(name);
  return metric == result.verdict.metrics.end() ? std::numeric_limits<double>::quiet_NaN()
                                                : metric->second;
}

std::string Header(const Scenario& scenario, const Result& result) {
  return fmt::format(
      R"(<p class="eyebrow">KANTARO Twin · mission report</p><h1>{}</h1><p class="lead">{}</p>)",
      Escape(Spoken(result.scenario)), Escape(scenario.description));
}

std::string VerdictBox(const Result& result, const MissionTrace& trace) {
  const Verdict& verdict = result.verdict;
  const auto failed = std::count_if(verdict.checks.begin(), verdict.checks.end(),
                                    [](const Check& c) { return !c.passed; });
  std::string list;
  for (const Check& check : verdict.checks) {
    if (!check.passed) list += "<li>" + Escape(check.text) + "</li>";
  }
  const auto judged = std::count_if(verdict.checks.begin(), verdict.checks.end(),
                                    [](const Check& c) { return c.judged; });
  const std::string sum =
      failed == 0
          ? fmt::format("All {} checks passed with seed {}.", judged, result.seed)
          : fmt::format("{} of {} checks failed with seed {}.", failed, judged, result.seed);
  return fmt::format(R"(<div class="verdict {}"><strong>{}</strong><p>{} {}</p>{}</div>)",
                     verdict.passed ? "passed" : "failed", verdict.passed ? "Passed" : "Failed",
                     sum, Escape(trace.ending), list.empty() ? "" : "<ul>" + list + "</ul>");
}

std::string Figures(const Result& result) {
  const auto figure = [](const std::string& title, const std::string& value) {
    return "<div><dt>" + title + "</dt><dd>" + value + "</dd></div>";
  };
  // A metric times a factor, with its digits and unit.
  const auto measured = [&](const std::string& name, double factor, int digits,
                            const std::string& unit) -> std::string {
    const double value = factor * Metric(result, name);
    if (std::isnan(value)) return "not known";
    if (std::isinf(value)) return "lost";
    return fmt::format("{:.{}f}<small>{}</small>", value, digits, unit);
  };
  const std::string planted = fmt::format("of {:.0f}", Metric(result, "faults_planted"));
  return R"(<dl class="figures">)" + figure("Driven", measured("distance_m", 1.0, 1, "m")) +
         figure("Time in the pipe", Duration(Metric(result, "duration_s"))) +
         figure("Highest speed", measured("highest_speed_m_s", 100.0, 1, "cm/s")) +
         figure("Position error, worst", measured("position_error_max_m", 100.0, 0, "cm")) +
         figure("Faults found", measured("fault_hits", 1.0, 0, planted)) +
         figure("Against real time",
                fmt::format("{:.1f}<small>× as fast</small>", result.timing.RealTimeFactor())) +
         "</dl>";
}

std::string Key(const std::string& swatch, const std::string& text) {
  return "<span><svg viewBox=\"0 0 26 12\" aria-hidden=\"true\">" + swatch + "</svg>" + text +
         "</span>";
}

std::string PathKey() {
  return Key(R"(<path class="truth" d="M1 6H25"/>)", "where it was") +
         Key(R"(<path class="estimate" d="M1 6H25"/>)", "where it thought it was");
}

std::string PlanSection(const Scenario& scenario, const MissionTrace& trace) {
  const bool faults = std::any_of(scenario.network.pipes.begin(), scenario.network.pipes.end(),
                                  [](const network::Pipe& pipe) { return !pipe.faults.empty(); });
  return R"(<section><h2>The way</h2><p class="note">The network from above, north up. Numbers mark the camera frames below.</p><div class="card"><div class="key">)" +
         PathKey() +
         (faults ? Key(R"(<path class="fault" d="M13 1l5 5l-5 5l-5 -5z"/>)", "planted fault")
                 : "") +
         "</div>" + Both(PlanSvg(scenario, trace, kWide_px), PlanSvg(scenario, trace, kNarrow_px)) +
         "</div></section>";
}

std::string TimeSection(const Scenario& scenario, const MissionTrace& trace) {
  return R"(<section><h2>Over time</h2><p class="note">The ribbon at the foot says what the robot was doing; upright lines are the numbered camera frames.</p><div class="card"><div class="key">)" +
         PathKey() + "</div>" +
         Both(TimeSvg(scenario, trace, kWide_px), TimeSvg(scenario, trace, kNarrow_px)) +
         "</div></section>";
}

std::string FrameSection(const MissionTrace& trace) {
  if (trace.frames.empty()) return "";
  std::string figures;
  for (std::size_t i = 0; i < trace.frames.size(); ++i) {
    const LandmarkFrame& frame = trace.frames[i];
    figures += fmt::format(
        "<figure>{}<figcaption><b>{}</b><span>{} <i>{:.1f}&nbsp;s</i></span></figcaption></figure>",
        Picture(frame.jpeg, frame.caption), i + 1, Escape(Capital(frame.caption)), frame.time_s);
  }
  return R"(<section class="strip-section"><h2>What it saw</h2><p class="note">The front camera when the robot noticed a landmark.</p><div class="strip">)" +
         figures + "</div></section>";
}

std::string LaserSection(const MissionTrace& trace, const ReportNotes& notes) {
  if (!trace.laser_ring) return "";
  const auto& samples = trace.laser_ring->revolution.samples;
  const auto returned = std::count_if(
      samples.begin(), samples.end(),
      [](const robot::LaserSample& sample) { return sample.status == robot::RangeStatus::kValid; });
  return R"(<section><h2>The laser's ring</h2><div class="card laser-row">)" +
         LaserSvg(*trace.laser_ring, notes.laser_threshold_m) +
         fmt::format(
             "<div><p><strong>{}</strong></p><p class=\"note\">One turn of the mirror after {:.1f} "
             "s, seen from behind "
             "the robot; rings at 50, 100 and 150 mm. {} of {} beams returned, the others lie pale "
             "at the far limit. The "
             "shaded windows, right, top and left, tell the kind of landmark: a window is open "
             "where the wall lies "
             "beyond {:.0f} mm.</p></div></div></section>",
             Escape(trace.laser_ring->caption), trace.laser_ring->time_s, returned, samples.size(),
             1000.0 * notes.laser_threshold_m);
}

std::string FaultRow(const std::string& picture, const std::string& where, double clock_h,
                     const std::string& sightings, const std::string& similarity,
                     const std::string& tag) {
  return fmt::format(
      R"(<tr><td class="thumb">{}</td><td>{}</td><td>{}{:.1f} h</td><td class="number" data-label="sightings">{}</td><td class="number" data-label="similarity">{}</td><td>{}</td></tr>)",
      picture, where, ClockSvg(clock_h), clock_h, sightings, similarity, tag);
}

std::string FaultSection(const MissionTrace& trace, const Verdict& verdict) {
  if (trace.faults.empty() && verdict.planted.empty()) return "";
  const std::string hit = R"(<span class="tag ok">planted fault</span>)";
  const std::string alarm = R"(<span class="tag no">false alarm</span>)";
  const std::string miss = R"(<span class="tag no">missed</span>)";
  std::string rows;
  for (std::size_t i = 0; i < trace.faults.size(); ++i) {
    const ReportedFault& fault = trace.faults[i];
    const std::string where = Escape(ToWords({fault.first.pipe, "", fault.chainage_m}));
    rows += FaultRow(
        fault.jpeg.empty() ? "" : Picture(fault.jpeg, "suspected fault in " + fault.first.pipe),
        where, fault.clock_h, std::to_string(fault.sightings),
        fmt::format("{:.2f}", fault.similarity),
        verdict.true_alarm.empty() ? "not known"
        : verdict.true_alarm[i]    ? hit
                                   : alarm);
  }
  for (const PlantedFault& fault : verdict.planted) {
    if (fault.found) continue;
    rows += FaultRow("",
                     fmt::format("{} in {}", Escape(fault.name),
                                 Escape(ToWords({fault.pipe, "", fault.chainage_m}))),
                     fault.clock_h, "–", "–", miss);
  }
  const auto found = std::count_if(verdict.planted.begin(), verdict.planted.end(),
                                   [](const auto& f) { return f.found; });
  const std::string sum =
      verdict.true_alarm.empty() && !trace.faults.empty()
          ? "Which of them are faults is not known."
          : fmt::format(
                "{} of {} planted faults on the way were found; {} of {} reports were false "
                "alarms.",
                found, verdict.planted.size(),
                std::count(verdict.true_alarm.begin(), verdict.true_alarm.end(), false),
                trace.faults.size());
  return fmt::format(
      R"(<section class="table-section"><h2>Fault candidates</h2><p class="note">{} Places are the robot's own estimate.</p><table class="faults"><thead><tr><th></th><th>Place</th><th>Clock position</th><th class="number">Sightings</th><th class="number">Similarity</th><th>In truth</th></tr></thead><tbody>{}</tbody></table></section>)",
      sum, rows);
}

std::string CheckSection(const Verdict& verdict) {
  std::string rows;
  for (const Check& check : verdict.checks) {
    const std::string limit = check.name == "faults_found"
                                  ? "at least " + Value(check.limit, check.unit)
                                  : Value(check.limit, check.unit);
    rows += fmt::format(
        R"(<tr><td class="mark-cell {}">{}</td><td><strong>{}</strong><br>{}</td><td class="number" data-label="measured">{}</td><td class="number" data-label="limit">{}</td></tr>)",
        !check.judged  ? ""
        : check.passed ? "ok"
                       : "no",
        !check.judged  ? "–"
        : check.passed ? "✓"
                       : "✗",
        Escape(Spoken(check.name)), Escape(check.text),
        check.judged ? Value(check.value, check.unit) : "–", limit);
  }
  return R"(<section class="table-section"><h2>Checks</h2><p class="note">Answered from ground truth, which the robot never sees, as far as it is known.</p><table class="checks"><thead><tr><th></th><th>Check</th><th class="number">Measured</th><th class="number">Limit</th></tr></thead><tbody>)" +
         rows + "</tbody></table></section>";
}

std::string Facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html;
  for (const auto& [name, value] : facts)
    html += "<dt>" + Escape(name) + "</dt><dd>" + Escape(value) + "</dd>";
  return R"(<dl class="facts">)" + html + "</dl>";
}

std::string ConditionFacts(const Scenario& scenario, const Conditions& conditions) {
  std::vector<std::pair<std::string, std::string>> facts{
      {"Seed", std::to_string(conditions.seed)},
      {"Start", ToWords({scenario.start.pipe, "", conditions.start_chainage_m})},
      {"Start yaw", fmt::format("{:+.1f}°", conditions.start_yaw_rad * 180.0 / std::numbers::pi)},
      {"Friction, tyre on wall",
       conditions.friction ? fmt::format("{:.2f}", *conditions.friction)
                           : fmt::format("{:.2f} of the walls' own", conditions.friction_factor)},
      {"Motors, left against right", fmt::format("{:+.1f} %", 200.0 * conditions.motor_mismatch)},
      {"Lights", fmt::format("{:.0f} %", 100.0 * conditions.light)},
      {"Wall texture", fmt::format("{:08x}", conditions.texture)}};
  const auto route = PlannedRoute(scenario);
  for (const auto& [pipe, scale] : conditions.map_scale) {
    const bool driven = std::any_of(route.begin(), route.end(),
                                    [&, name = pipe](const auto& leg) { return leg.pipe == name; });
    if (driven)
      facts.emplace_back("Map of pipe " + pipe,
                         fmt::format("{:+.1f} % long", 100.0 * (scale - 1.0)));
  }
  for (const robot::Fault& fault : scenario.faults)
    facts.emplace_back("Sensor fault", robot::ToString(fault));
  return Facts(facts);
}

std::string Commands(const MissionTrace& trace) {
  return trace.limited + trace.refused == 0
             ? std::to_string(trace.commands)
             : fmt::format("{}, {} cut to what the motors can, {} refused", trace.commands,
                           trace.limited, trace.refused);
}

std::string Losses(const MissionTrace& trace) {
  std::string losses;
  for (const auto& [sensor, readings] : trace.lost) {
    losses += fmt::format("{}{} of {}", losses.empty() ? "" : ", ", readings, Spoken(sensor));
  }
  return losses.empty() ? "none" : losses;
}

std::string RunSection(const Scenario& scenario, const Conditions& conditions,
                       const MissionTrace& trace, const Result& result) {
  const std::string timing =
      Facts({{"Simulated", fmt::format("{:.1f} s", result.timing.sim_s)},
             {"Wall clock", fmt::format("{:.1f} s", result.timing.wall_s)},
             {"Real-time factor", fmt::format("{:.2f}", result.timing.RealTimeFactor())},
             {"Readings", std::to_string(trace.readings)},
             {"Commands", Commands(trace)},
             {"Readings lost", Losses(trace)},
             {"Network", scenario.network_file.filename().string()}});
  return R"(<section class="two"><div><h2>Conditions of this seed</h2>)" +
         ConditionFacts(scenario, conditions) + "</div><div><h2>The run</h2>" + timing +
         R"(<p class="hash">trace )" + Escape(result.trace_sha256) + "</p></div></section>";
}

std::string EventSection(const MissionTrace& trace) {
  if (trace.events.empty()) return "";
  std::string rows;
  for (const Event& event : trace.events) {
    rows += fmt::format("<tr><td class=\"number\">{:.2f} s</td><td>{}</td><td>{}</td></tr>",
                        event.time_s, Escape(event.kind), Escape(Capital(event.text)));
  }
  return fmt::format(
      "<details><summary>All {} events in "
      "order</summary><table><tbody>{}</tbody></table></details>",
      trace.events.size(), rows);
}

}  // namespace

std::string ReportHtml(const Scenario& scenario, const Conditions& conditions,
                       const MissionTrace& trace, const Result& result, const ReportNotes& notes) {
  return fmt::format(
             R"(<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1"><title>{}: {} · seed {}</title><style>{}</style></head><body><main>)",
             Escape(Spoken(result.scenario)), result.verdict.passed ? "passed" : "failed",
             result.seed, kReportStyle) +
         Header(scenario, result) + VerdictBox(result, trace) + Figures(result) +
         PlanSection(scenario, trace) + TimeSection(scenario, trace) + FrameSection(trace) +
         LaserSection(trace, notes) + FaultSection(trace, result.verdict) +
         CheckSection(result.verdict) + RunSection(scenario, conditions, trace, result) +
         EventSection(trace) + "</main></body></html>\n";
}

}  // namespace kantaro::scenarios
