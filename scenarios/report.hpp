#pragma once

#include <string>

#include "scenarios/conditions.hpp"
#include "scenarios/mission_trace.hpp"
#include "scenarios/result.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// What the report says beside the trace and the result.
struct ReportNotes {
  double laser_threshold_m{0.175};  ///< drawn into the laser's picture
};

/// `report.html`: one page that explains a run to a person. Self-contained: style, drawings and
/// pictures are inside, no script, nothing is fetched. Made for a phone, a wide screen and A4
/// paper, light and dark. Every name from a file is escaped.
[[nodiscard]] std::string ReportHtml(const Scenario& scenario, const Conditions& conditions,
                                     const MissionTrace& trace, const Result& result,
                                     const ReportNotes& notes);

}  // namespace kantaro::scenarios
