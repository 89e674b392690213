#include "scenarios/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/input_error.hpp"
#include "robot/recording/replay.hpp"
#include "scenarios/pilot.hpp"
#include "scenarios/recorded_mission.hpp"
#include "scenarios/trace_hash.hpp"
#include "scenarios/trace_recorder.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool SameBits(const navigation::Estimate& a, const navigation::Estimate& b) {
  return a.leg == b.leg && SameBits(a.distance_m, b.distance_m) &&
         SameBits(a.deviation_m, b.deviation_m) && SameBits(a.leg_length_m, b.leg_length_m);
}

std::string Words(const navigation::Estimate& estimate) {
  return fmt::format("leg {}, {} m of {} m, deviation {} m", estimate.leg + 1, estimate.distance_m,
                     estimate.leg_length_m, estimate.deviation_m);
}

std::string Words(const robot::Command& command) {
  return fmt::format("{} and {} rad/s, lights {}", command.left_rad_s, command.right_rad_s,
                     command.lights);
}

std::string Words(const Event& event) {
  return fmt::format("{:.2f} s {}: {}", event.time_s, event.kind, event.text);
}

/// Events of `a` that have no equal in `b`.
std::vector<std::string> Without(std::vector<std::string> a, std::vector<std::string> b) {
  for (const std::string& event : b) {
    const auto found = std::find(a.begin(), a.end(), event);
    if (found != a.end()) a.erase(found);
  }
  return a;
}

/// The robot's program over a recording, compared with what it said then.
class Comparison {
 public:
  Comparison(const std::filesystem::path& file,
             const std::optional<std::filesystem::path>& robot_folder)
      : replay_(robot::Recording(file)),
        mission_(MissionOf(replay_.recording())),
        robot_(robot_folder ? OtherRobot(*robot_folder) : mission_.robot),
        pilot_(mission_.scenario, mission_.conditions, robot_),
        recorder_(mission_.scenario, robot_.description) {
    result_.program = mission_.program;
    result_.robot = robot_folder ? robot_folder->string() : "the recording's own";
  }

  ReplayResult Run() {
    recorder_.Sample(0.0, {}, pilot_.executive());
    double end_s = mission_.scenario.time_limit_s;
    while (const std::optional<robot::Reading> reading = replay_.Read()) {
      Tick(*reading);
      if (pilot_.executive().finished()) end_s = std::min(end_s, Now_s());
    }
    CompareEvents();
    result_.recorded_sha256 = recorded_hash_.HexDigest();
    result_.readings = readings_;
    result_.run.conditions = mission_.conditions;
    result_.run.laser_threshold_m = robot_.perception.laser.threshold_m;
    result_.run.trace =
        recorder_.Finish(std::min(end_s, Now_s()), pilot_.executive(),
                         fmt::format("The recording ends after {:.1f} s.", Now_s()));
    return std::move(result_);
  }

  [[nodiscard]] const RecordedMission& mission() const { return mission_; }

 private:
  [[nodiscard]] double Now_s() const { return robot::Seconds(replay_.Now()); }

  [[nodiscard]] RobotFiles OtherRobot(const std::filesystem::path& folder) const {
    RobotFiles robot = ReadRobotFiles(folder);
    const robot::Camera &ours = mission_.robot.description.front_camera,
                        &theirs = robot.description.front_camera;
    if (ours.width_px != theirs.width_px || ours.height_px != theirs.height_px) {
      throw InputError(
          folder / robot::kCamerasFile, {}, "",
          fmt::format("the front camera's images have {} x {} pixels, those of the "
                      "recording {} x {}",
                      theirs.width_px, theirs.height_px, ours.width_px, ours.height_px));
    }
    return robot;
  }

  void Tick(const robot::Reading& reading) {
    const robot::Replay::Answer& answer = replay_.answer();
    if (answer.last && !Ended(answer)) return;  // cut off: what was made of it may be missing
    ++readings_;
    recorder_.Add(reading);
    recorded_hash_.Add(reading);
    const std::optional<robot::Command> command =
        pilot_.Step(reading, [this](const auto& observation, const auto& executive) {
          recorder_.Add(observation, executive);
        });
    Keep(answer);
    if (command) {
      const navigation::Estimate estimate = pilot_.executive().estimate();
      recorder_.Add(replay_.Now(), *command, replay_.Apply(*command), pilot_.executive());
      Compare(*command, answer);
      Compare(estimate, answer);
    } else {
      CountMissing(answer);
    }
    if (replay_.Now() < next_sample_) return;
    recorder_.Sample(Now_s(), {}, pilot_.executive());
    next_sample_ += kSamplePeriod;
  }

  static bool Ended(const robot::Replay::Answer& answer) {
    return !answer.events.empty() && answer.events.back().kind == kEndEvent;
  }

  /// Commands and estimates go into the hash in the order in which the run's own took them.
  void Keep(const robot::Replay::Answer& answer) {
    for (const robot::RecordedCommand& command : answer.commands)
      recorded_hash_.Add(command.command);
    for (const robot::RecordedEstimate& estimate : answer.estimates)
      recorded_hash_.Add(AsEstimate(estimate));
    for (const robot::RecordedEvent& event : answer.events)
      recorded_events_.push_back({robot::Seconds(event.at), event.kind, event.text});
  }

  static navigation::Estimate AsEstimate(const robot::RecordedEstimate& recorded) {
    return {recorded.leg, recorded.distance_m, recorded.deviation_m, recorded.leg_length_m};
  }

  void Diverge(const std::string& what) {
    if (!result_.first) result_.first = Divergence{Now_s(), what};
  }

  void Compare(const robot::Command& command, const robot::Replay::Answer& answer) {
    ++result_.commands.of;
    if (answer.commands.size() == 1 && robot::SameBits(command, answer.commands.front().command)) {
      ++result_.commands.equal;
    } else if (answer.commands.empty()) {
      Diverge("command " + Words(command) + ", where none was recorded");
    } else {
      Diverge("command " + Words(command) + ", recorded " + Words(answer.commands.front().command));
    }
  }

  void Compare(const navigation::Estimate& estimate, const robot::Replay::Answer& answer) {
    ++result_.estimates.of;
    if (answer.estimates.empty()) {
      Diverge("estimate " + Words(estimate) + ", where none was recorded");
      return;
    }
    const navigation::Estimate recorded = AsEstimate(answer.estimates.front());
    if (SameBits(estimate, recorded)) {
      ++result_.estimates.equal;
      return;
    }
    Diverge("estimate " + Words(estimate) + ", recorded " + Words(recorded));
    if (estimate.leg != recorded.leg) {
      ++result_.on_another_leg;
      return;
    }
    const double distance_m = std::abs(estimate.distance_m - recorded.distance_m);
    if (distance_m > result_.distance_m) {
      result_.distance_m = distance_m;
      result_.distance_at_s = Now_s();
    }
    result_.deviation_m =
        std::max(result_.deviation_m, std::abs(estimate.deviation_m - recorded.deviation_m));
  }

  /// What was recorded where the replay says nothing.
  void CountMissing(const robot::Replay::Answer& answer) {
    result_.commands.of += answer.commands.size();
    result_.estimates.of += answer.estimates.size();
    if (!answer.commands.empty())
      Diverge("no command, recorded " + Words(answer.commands.front().command));
  }

  /// What the hardware did, and the run's end, are not the program's.
  void CompareEvents() {
    const auto words = [](const std::vector<Event>& events) {
      std::vector<std::string> all;
      for (const Event& event : events) {
        if (event.kind != kHardwareEvent && event.kind != kEndEvent) all.push_back(Words(event));
      }
      return all;
    };
    const std::vector<std::string> recorded = words(recorded_events_);
    const std::vector<std::string> replayed = words(recorder_.events());
    result_.only_recorded = Without(recorded, replayed);
    result_.only_replayed = Without(replayed, recorded);
    result_.events = {recorded.size() - result_.only_recorded.size(),
                      recorded.size() + result_.only_replayed.size()};
  }

  robot::Replay replay_;
  RecordedMission mission_;
  RobotFiles robot_;
  Pilot pilot_;
  TraceRecorder recorder_;
  TraceHash recorded_hash_;
  ReplayResult result_;
  std::vector<Event> recorded_events_;
  std::uint64_t readings_{};
  robot::RunTime next_sample_{kSamplePeriod};
};

}  // namespace

ReplayResult ReplayRecording(const std::filesystem::path& recording,
                             const std::optional<std::filesystem::path>& robot_folder) {
  const auto began = std::chrono::steady_clock::now();
  Comparison comparison(recording, robot_folder);
  ReplayResult result = comparison.Run();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  MissionRun& run = result.run;
  run.scenario = comparison.mission().scenario;
  run.result = {run.scenario.name,
                run.conditions.seed,
                Judge(run.scenario, run.trace),
                {run.trace.estimate.back().time_s, wall.count()},
                run.trace.sha256};
  return result;
}

Json ToJson(const ReplayResult& result) {
  const auto equality = [](const Equality& e) { return Json{{"equal", e.equal}, {"of", e.of}}; };
  Json json{{"scenario", result.run.result.scenario},
            {"seed", result.run.result.seed},
            {"recorded_by", result.program},
            {"robot", result.robot},
            {"same", result.same()},
            {"readings", result.readings},
            {"estimates", equality(result.estimates)},
            {"commands", equality(result.commands)},
            {"events", equality(result.events)},
            {"first_divergence", nullptr},
            {"largest_difference",
             {{"distance_m", result.distance_m},
              {"at_s", result.distance_at_s},
              {"deviation_m", result.deviation_m},
              {"estimates_on_another_leg", result.on_another_leg}}},
            {"events_only_recorded", result.only_recorded},
            {"events_only_replayed", result.only_replayed},
            {"recorded_sha256", result.recorded_sha256},
            {"trace_sha256", result.run.trace.sha256}};
  if (result.first)
    json["first_divergence"] = {{"time_s", result.first->time_s}, {"what", result.first->what}};
  return json;
}

std::string ToText(const ReplayResult& result) {
  const Result& run = result.run.result;
  const auto line = [](const char* what, const Equality& equality) {
    return fmt::format("  {:<10}{} of {} equal\n", what, equality.equal, equality.of);
  };
  std::string text = fmt::format(
      "{} seed {}, recorded by {}: {} readings in {:.1f} s, replayed with {} ({:.1f} times real "
      "time)\n",
      run.scenario, run.seed, result.program, result.readings, run.timing.sim_s, result.robot,
      run.timing.RealTimeFactor());
  text += line("estimates", result.estimates) + line("commands", result.commands) +
          line("events", result.events);
  if (result.first) {
    text += fmt::format("  first divergence at {:.3f} s: {}\n", result.first->time_s,
                        result.first->what);
    text += fmt::format(
        "  largest difference of the estimate: {:.4f} m at {:.1f} s, of its deviation {:.4f} m; {} "
        "on another leg\n",
        result.distance_m, result.distance_at_s, result.deviation_m, result.on_another_leg);
  }
  for (const std::string& event : result.only_recorded) text += "  - " + event + '\n';
  for (const std::string& event : result.only_replayed) text += "  + " + event + '\n';
  return text + fmt::format("  trace_sha256 {}\n", run.trace_sha256);
}

}  // namespace kantaro::scenarios
