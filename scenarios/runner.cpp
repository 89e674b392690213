#include "scenarios/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "navigation/executive.hpp"
#include "network/pipe_axis.hpp"
#include "perception/perception.hpp"
#include "robot/description.hpp"
#include "robot/recording/recorder.hpp"
#include "scenarios/blinded.hpp"
#include "scenarios/report.hpp"
#include "scenarios/trace_recorder.hpp"
#include "scenarios/twin_conditions.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

/// After the robot has declared its mission done it is watched for so long, so that the judge sees
/// it stand.
constexpr double kAfterwards_s = 1.0;
constexpr robot::RunTime kSamplePeriod(static_cast<robot::RunTime::rep>(kTracePeriod_s * 1e9));
constexpr robot::RunTime kProgressPeriod = std::chrono::seconds(1);

navigation::Executive MakeExecutive(const Scenario& scenario, const Conditions& conditions,
                                    const robot::Description& description) {
  // The crew sets the robot down where the scenario says, and does not know by how much it missed.
  const network::Pipe& pipe = scenario.network.PipeNamed(scenario.start.pipe);
  const double chainage_m = scenario.start.chainage_m;
  const double start_m = pipe.upstream == scenario.start.manhole
                             ? chainage_m
                             : network::PipeAxis(scenario.network, pipe).length_m() - chainage_m;
  return {navigation::MakeRoute(scenario.network, RouteManholes(scenario), conditions.map_scale),
          start_m, navigation::RobotGeometry::Of(description),
          navigation::ReadParameters(scenario.robot_folder / "navigation.yaml")};
}

/// The robot's own loop, from reading to command, watched by the recorder.
class Loop {
 public:
  Loop(const Scenario& scenario, const Conditions& conditions, const RunOptions& options)
      : scenario_(scenario),
        options_(options),
        description_(robot::ReadDescription(scenario.robot_folder)),
        perception_parameters_(
            perception::ReadParameters(scenario.robot_folder / "perception.yaml")),
        world_(sim::BuildWorld(scenario.network, conditions.texture,
                               scenario.blind.count(Sense::kCameras) == 0,
                               sim::ReadGripTable(scenario.materials_file))),
        twin_(world_, description_, TwinConditions(scenario, conditions)),
        hardware_(twin_, scenario.blind),
        perception_(description_, perception_parameters_),
        executive_(MakeExecutive(scenario, conditions, description_)),
        recorder_(scenario, world_.sewer->network, description_) {
    if (options.recording) recording_.emplace(*options.recording, description_);
  }

  MissionTrace Run() {
    recorder_.Sample(0.0, twin_.Truth(), executive_);
    double end_s = scenario_.time_limit_s;
    while (const std::optional<robot::Reading> reading = hardware_.Read()) {
      Tick(*reading);
      const double now_s = robot::Seconds(hardware_.Now());
      if (executive_.finished()) end_s = std::min(end_s, now_s);
      Sample();
      if (now_s >= end_s + kAfterwards_s) break;
    }
    if (recording_) recording_->Close();
    return recorder_.Finish(std::min(end_s, robot::Seconds(hardware_.Now())), executive_);
  }

 private:
  void Tick(const robot::Reading& reading) {
    recorder_.Add(reading);
    if (recording_) recording_->Write(reading);
    perception_.SetPipeDiameter(executive_.pipe_diameter_m());
    std::optional<robot::Command> command;
    for (const perception::Observation& observation : perception_.Process(reading)) {
      recorder_.Add(observation, executive_);
      command = executive_.Step(observation);
    }
    if (!command) return;
    hardware_.Apply(*command);
    recorder_.Add(*command, executive_);
    if (recording_) Record(*command);
  }

  void Record(const robot::Command& command) {
    const navigation::Estimate estimate = executive_.estimate();
    recording_->Write(hardware_.Now(), command);
    recording_->Write(hardware_.Now(), {executive_.route().legs[estimate.leg].pipe,
                                        estimate.distance_m, estimate.deviation_m});
  }

  void Sample() {
    const robot::RunTime now = hardware_.Now();
    if (now < next_sample_) return;
    recorder_.Sample(robot::Seconds(now), twin_.Truth(), executive_);
    next_sample_ += kSamplePeriod;
    if (now < next_progress_ || !options_.progress) return;
    options_.progress(robot::Seconds(now), scenario_.time_limit_s);
    next_progress_ += kProgressPeriod;
  }

  const Scenario& scenario_;
  const RunOptions& options_;
  robot::Description description_;
  perception::Parameters perception_parameters_;
  sim::World world_;
  sim::Twin twin_;
  Blinded hardware_;
  perception::Perception perception_;
  navigation::Executive executive_;
  TraceRecorder recorder_;
  std::optional<robot::Recorder> recording_;
  robot::RunTime next_sample_{kSamplePeriod};
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
                {run.trace.truth.back().time_s, wall.count()},
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
