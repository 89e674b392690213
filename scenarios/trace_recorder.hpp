#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "navigation/executive.hpp"
#include "perception/observations.hpp"
#include "robot/description.hpp"
#include "robot/hardware.hpp"
#include "robot/readings.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/mission_trace.hpp"
#include "scenarios/scenario.hpp"
#include "scenarios/trace_hash.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {

/// Watches a run and keeps what the judge and the report need. It changes nothing.
class TraceRecorder {
 public:
  /// @param scenario  must outlive this.
  TraceRecorder(const Scenario& scenario, const robot::Description& description);

  void Add(const robot::Reading& reading);
  void Add(const perception::Observation& observation, const navigation::Executive& executive);
  /// After the executive's step: its command, what became of it, and what the executive had to
  /// tell.
  void Add(robot::RunTime at, const robot::Command& command, robot::CommandOutcome outcome,
           navigation::Executive& executive);
  /// Notes the estimate down, and the truth where it is known; to be called every kTracePeriod_s.
  void Sample(double time_s, const std::optional<sim::GroundTruth>& truth,
              const navigation::Executive& executive);
  [[nodiscard]] const std::vector<Event>& events() const { return trace_.events; }

  /// @param ending  why the run ended, one sentence, if the robot itself did not end it.
  [[nodiscard]] MissionTrace Finish(double end_s, const navigation::Executive& executive,
                                    const std::string& ending);

 private:
  void Keep(const navigation::Event& event);
  void Note(robot::RunTime at, const std::string& text);
  void Count(robot::RunTime at, const robot::Loss& loss);
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
  robot::Camera camera_;
  robot::Rectifier rectifier_;
  double camera_x_m_{};
  double tyre_radius_m_{};
  MissionTrace trace_;
  TraceHash hash_;
  cv::Mat front_image_;
  robot::LaserRevolution revolution_;
  double roll_rad_{};
  robot::Command command_{0.0, 0.0, 0.0};  ///< in force
  robot::CommandOutcome outcome_{robot::CommandOutcome::kHonoured};
  std::set<robot::Sensor> silent_;  ///< their line is down
  perception::LaserStatus last_status_{perception::LaserStatus::kNoLandmark};
  int status_run_{};
  int ring_rank_{};
};

}  // namespace kantaro::scenarios
