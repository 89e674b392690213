#include "scenarios/mission_trace.hpp"

#include <algorithm>
#include <cmath>

namespace kantaro::scenarios {
namespace {

/// The way round the clock from one position to another, −6 to 6 h.
double ClockStep(double from_h, double to_h) { return std::remainder(to_h - from_h, 12.0); }

double WrapClock(double clock_h) {
  const double wrapped = std::fmod(std::fmod(clock_h, 12.0) + 12.0, 12.0);
  return wrapped == 0.0 ? 12.0 : wrapped;
}

}  // namespace

double ClockDistance(double a_h, double b_h) { return std::abs(ClockStep(a_h, b_h)); }

ReportedFault& AddSighting(std::vector<ReportedFault>& reports, const FaultSighting& sighting) {
  const auto report = std::find_if(reports.begin(), reports.end(), [&](const ReportedFault& known) {
    return known.first.pipe == sighting.pipe &&
           std::abs(known.chainage_m - sighting.chainage_m) <= kFaultReach_m &&
           ClockDistance(known.clock_h, sighting.clock_h) <= kFaultReach_h;
  });
  if (report == reports.end()) {
    return reports.emplace_back(
        ReportedFault{sighting, sighting.chainage_m, sighting.clock_h, sighting.similarity, 1, ""});
  }
  ++report->sightings;
  report->chainage_m += (sighting.chainage_m - report->chainage_m) / report->sightings;
  report->clock_h =
      WrapClock(report->clock_h + ClockStep(report->clock_h, sighting.clock_h) / report->sightings);
  report->similarity = std::min(report->similarity, sighting.similarity);
  return *report;
}

}  // namespace kantaro::scenarios
