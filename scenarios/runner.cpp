#include "scenarios/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "robot/faults.hpp"
#include "robot/recording/recorder.hpp"
#include "scenarios/pilot.hpp"
#include "scenarios/recorded_mission.hpp"
#include "scenarios/report.hpp"
#include "scenarios/trace_recorder.hpp"

namespace kantaro::scenarios {
namespace {

/// After the robot has declared its mission done it is watched for so long, so that the judge sees
/// it stand.
constexpr double kAfterwards_s = 1.0;
/// A hardware that refuses commands may take them again; after so long the mission is broken off.
constexpr robot::RunTime kPatience = std::chrono::seconds(1);
constexpr robot::RunTime kProgressPeriod = std::chrono::seconds(1);

/// The robot's own loop, from reading to command, watched by the recorder.
class Loop {
 public:
  /// All must outlive this.
  Loop(const Scenario& scenario, const Conditions& conditions, const RunOptions& options)
      : scenario_(scenario),
        options_(options),
        robot_(ReadRobotFiles(scenario.robot_folder)),
        body_(options.make_body ? options.make_body(scenario, conditions, robot_.description)
                                : MakeBody(options.hardware, scenario, conditions,
                                           robot_.description, options.render_threads)),
        hardware_(*body_.hardware, robot_.description, scenario.faults, conditions.seed),
        pilot_(scenario, conditions, robot_),
        recorder_(scenario, robot_.description) {
    if (options.recording) {
      recording_.emplace(*options.recording, MissionFilesOf(scenario, conditions.seed),
                         robot_.description);
    }
  }

  MissionTrace Run() {
    Sample();
    double end_s = scenario_.time_limit_s;
    std::string ending = TimeIsUp();
    while (true) {
      const std::optional<robot::Reading> reading = hardware_.Read();
      if (!reading && Now_s() < scenario_.time_limit_s - kAfterwards_s)
        ending = fmt::format("The hardware had nothing more to say after {:.1f} s.", Now_s());
      if (!reading || Now_s() > scenario_.time_limit_s) break;
      Tick(*reading);
      if (pilot_.executive().finished()) end_s = std::min(end_s, Now_s());
      Sample();
      if (Now_s() >= end_s + kAfterwards_s) break;
      if (taken_at_ + kPatience <= asked_at_) {
        ending = fmt::format("The hardware refused every command since {:.1f} s.",
                             robot::Seconds(taken_at_));
        break;
      }
    }
    hardware_.Stop();
    MissionTrace trace = recorder_.Finish(std::min(end_s, Now_s()), pilot_.executive(), ending);
    if (recording_) {
      recording_->Write(robot::RecordedEvent{hardware_.Now(), kEndEvent, trace.ending});
      recording_->Close();
    }
    return trace;
  }

  [[nodiscard]] double laser_threshold_m() const { return robot_.perception.laser.threshold_m; }

 private:
  [[nodiscard]] double Now_s() const { return robot::Seconds(hardware_.Now()); }
  [[nodiscard]] std::string TimeIsUp() const {
    return fmt::format("The time limit of {:.0f} s was reached.", scenario_.time_limit_s);
  }

  void Tick(const robot::Reading& reading) {
    recorder_.Add(reading);
    if (recording_) recording_->Write(reading);
    const std::optional<robot::Command> command =
        pilot_.Step(reading, [this](const auto& observation, const auto& executive) {
          recorder_.Add(observation, executive);
        });
    if (!command) return;
    const robot::CommandOutcome outcome = hardware_.Apply(*command);
    asked_at_ = hardware_.Now();
    if (outcome != robot::CommandOutcome::kRefused) taken_at_ = asked_at_;
    recorder_.Add(hardware_.Now(), *command, outcome, pilot_.executive());
    if (recording_) Record(*command, outcome);
  }

  void Record(const robot::Command& command, robot::CommandOutcome outcome) {
    const robot::RunTime now = hardware_.Now();
    const navigation::Executive& executive = pilot_.executive();
    const navigation::Estimate estimate = executive.estimate();
    recording_->Write(robot::RecordedCommand{now, command, outcome});
    recording_->Write(robot::RecordedEstimate{
        now, executive.route().legs[estimate.leg].pipe, static_cast<std::uint32_t>(estimate.leg),
        estimate.distance_m, estimate.deviation_m, estimate.leg_length_m});
    const std::vector<Event>& events = recorder_.events();
    for (; recorded_events_ < events.size(); ++recorded_events_) {
      const Event& event = events[recorded_events_];
      const robot::RunTime at(std::llround(event.time_s * 1e9));
      recording_->Write(robot::RecordedEvent{at, event.kind, event.text});
    }
  }

  void Sample() {
    const robot::RunTime now = hardware_.Now();
    if (now < next_sample_) return;
    std::optional<sim::GroundTruth> truth;
    if (body_.truth) truth = body_.truth();
    recorder_.Sample(robot::Seconds(now), truth, pilot_.executive());
    next_sample_ += kSamplePeriod;
    if (now < next_progress_ || !options_.progress) return;
    options_.progress(robot::Seconds(now), scenario_.time_limit_s);
    next_progress_ += kProgressPeriod;
  }

  const Scenario& scenario_;
  const RunOptions& options_;
  RobotFiles robot_;
  Body body_;
  robot::Faulted hardware_;
  Pilot pilot_;
  TraceRecorder recorder_;
  std::optional<robot::Recorder> recording_;
  std::size_t recorded_events_{};
  robot::RunTime asked_at_{};  ///< last command
  robot::RunTime taken_at_{};  ///< last command that was not refused
  robot::RunTime next_sample_{};
  robot::RunTime next_progress_{kProgressPeriod};
};

}  // namespace

MissionRun RunMission(const Scenario& whole, std::uint64_t seed, const RunOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  MissionRun run;
  run.scenario = AroundItsRoute(whole);
  run.conditions = DrawConditions(run.scenario, seed);
  Loop loop(run.scenario, run.conditions, options);
  run.trace = loop.Run();
  run.laser_threshold_m = loop.laser_threshold_m();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  run.result = {run.scenario.name,
                seed,
                Judge(run.scenario, run.trace),
                {run.trace.estimate.back().time_s, wall.count()},
                run.trace.sha256};
  return run;
}

FolderFiles FilesOf(const MissionRun& run) {
  FolderFiles files{{"result.json", ToJson(run.result).dump(2) + "\n"},
                    {"report.html", ReportHtml(run.scenario, run.conditions, run.trace, run.result,
                                               {run.laser_threshold_m})}};
  for (std::size_t i = 0; i < run.trace.frames.size(); ++i) {
    files.emplace_back(fmt::format("frame_{:02}.jpg", i + 1), run.trace.frames[i].jpeg);
  }
  return files;
}

}  // namespace kantaro::scenarios
