#include "scenarios/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "robot/faults.hpp"
#include "robot/recording/recorder.hpp"
#include "scenarios/pilot.hpp"
#include "scenarios/report.hpp"
#include "scenarios/trace_recorder.hpp"

namespace kantaro::scenarios {
namespace {

/// After the robot has declared its mission done it is watched for so long, so that the judge sees
/// it stand.
constexpr double kAfterwards_s = 1.0;
/// A hardware that refuses commands may take them again; after so long the mission is broken off.
constexpr robot::RunTime kPatience = std::chrono::seconds(1);
constexpr robot::RunTime kSamplePeriod(static_cast<robot::RunTime::rep>(kTracePeriod_s * 1e9));
constexpr robot::RunTime kProgressPeriod = std::chrono::seconds(1);

/// The robot's own loop, from reading to command, watched by the recorder.
class Loop {
 public:
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
    if (options.recording) recording_.emplace(*options.recording, robot_.description);
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
    if (recording_) recording_->Close();
    return recorder_.Finish(std::min(end_s, Now_s()), pilot_.executive(), ending);
  }

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
    if (recording_) Record(*command);
  }

  void Record(const robot::Command& command) {
    const navigation::Executive& executive = pilot_.executive();
    const navigation::Estimate estimate = executive.estimate();
    recording_->Write(hardware_.Now(), command);
    recording_->Write(hardware_.Now(), {executive.route().legs[estimate.leg].pipe,
                                        estimate.distance_m, estimate.deviation_m});
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
  robot::RunTime asked_at_{};  ///< last command
  robot::RunTime taken_at_{};  ///< last command that was not refused
  robot::RunTime next_sample_{};
  robot::RunTime next_progress_{kProgressPeriod};
};

}  // namespace

MissionRun RunMission(const Scenario& whole, std::uint64_t seed, const RunOptions& options) {
  const Scenario scenario = AroundItsRoute(whole);
  const auto began = std::chrono::steady_clock::now();
  MissionRun run;
  run.conditions = DrawConditions(scenario, seed);
  run.trace = Loop(scenario, run.conditions, options).Run();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  run.result = {scenario.name,
                seed,
                Judge(scenario, run.trace),
                {run.trace.estimate.back().time_s, wall.count()},
                run.trace.sha256};
  return run;
}

void WriteRun(const std::filesystem::path& folder, const Scenario& whole, const MissionRun& run,
              const std::optional<std::filesystem::path>& recording) {
  const Scenario scenario = AroundItsRoute(whole);
  const perception::Parameters parameters =
      perception::ReadParameters(scenario.robot_folder / "perception.yaml");
  FolderFiles files{{"result.json", ToJson(run.result).dump(2) + "\n"},
                    {"report.html", ReportHtml(scenario, run.conditions, run.trace, run.result,
                                               {parameters.laser.threshold_m})}};
  for (std::size_t i = 0; i < run.trace.frames.size(); ++i) {
    files.emplace_back(fmt::format("frame_{:02}.jpg", i + 1), run.trace.frames[i].jpeg);
  }
  WriteFolder(folder, files, recording ? MovedFiles{{"recording.bag", *recording}} : MovedFiles{});
}

}  // namespace kantaro::scenarios
