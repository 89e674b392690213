#pragma once

#include <optional>
#include <string>
#include <vector>

#include "navigation/executive.hpp"
#include "perception/observations.hpp"
#include "robot/description.hpp"
#include "robot/readings.hpp"
#include "scenarios/mission_trace.hpp"
#include "scenarios/scenario.hpp"
#include "scenarios/trace_hash.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {

/// Watches a run and keeps what the judge and the report need. It changes nothing.
class TraceRecorder {
 public:
  /// @param world  what the twin's indices point into.
  TraceRecorder(const Scenario& scenario, const network::Network& world,
                const robot::Description& description);

  void Add(const robot::Reading& reading);
  void Add(const perception::Observation& observation, const navigation::Executive& executive);
  /// After the executive's step: its command, as applied, and what it had to tell.
  void Add(const robot::Command& command, navigation::Executive& executive);
  /// Notes truth and estimate down; to be called every kTracePeriod_s.
  void Sample(double time_s, const sim::GroundTruth& truth, const navigation::Executive& executive);

  /// @param ended_by_limit  the run's time was up.
  [[nodiscard]] MissionTrace Finish(double end_s, const navigation::Executive& executive);

 private:
  void Keep(const navigation::Event& event);
  void Look(const perception::FaultObservation& faults, const navigation::Executive& executive);
  void Look(const perception::LaserObservation& laser, const navigation::Executive& executive);
  /// Chainage in the true pipe of a distance along a leg (see EstimateSample::chainage_m).
  [[nodiscard]] double ChainageOf(const navigation::MapLeg& leg, double distance_m) const;
  /// Where the robot thinks it is, in the true network.
  [[nodiscard]] EstimateSample Believed(double time_s,
                                        const navigation::Executive& executive) const;
  [[nodiscard]] std::string Thumbnail(const perception::FaultCandidate& candidate,
                                      double pipe_diameter_m) const;

  const Scenario& scenario_;
  const network::Network& world_;
  robot::Camera camera_;
  double camera_x_m_{};
  MissionTrace trace_;
  TraceHash hash_;
  cv::Mat front_image_;
  robot::LaserRevolution revolution_;
  double roll_rad_{};
  perception::LaserStatus last_status_{perception::LaserStatus::kNoLandmark};
  int status_run_{};
  int ring_rank_{};
};

}  // namespace kantaro::scenarios
