// Where a mission's processor time goes: mission_bench [SCENARIO [SEED]], route 1 and seed 1 if not
// given. The mission is driven once, and recorded once more; its commands then drive twins with
// less and less in them, its readings go to perception alone, and what its cameras saw is drawn
// again. All times are processor time, by the clocks of threads and process, so that a busy machine
// changes little. Prints the tables of docs/performance.md.

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "perception/perception.hpp"
#include "scenarios/pilot.hpp"
#include "scenarios/runner.hpp"
#include "scenarios/twin_conditions.hpp"
#include "sim/camera_rig.hpp"
#include "sim/robot_model.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using robot::Reading;

double Clock_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
double Thread_s() { return Clock_s(CLOCK_THREAD_CPUTIME_ID); }
double Process_s() { return Clock_s(CLOCK_PROCESS_CPUTIME_ID); }

/// What a mission told its robot, and when.
struct Told {
  robot::RunTime at;
  robot::Command command;
};

/// What was found out along the way, by the main thread's clock.
struct Watched {
  double twin_s{};        ///< in the twin
  double perception_s{};  ///< in perception, of a copy of each reading
  std::size_t readings{};
  std::vector<Told> told;
};

/// Hands everything through, and gives each reading to a perception of its own.
class WatchedTwin : public robot::Hardware {
 public:
  WatchedTwin(std::unique_ptr<sim::Twin> twin, const RobotFiles& robot, double diameter_m,
              Watched& watched)
      : twin_(std::move(twin)),
        perception_(robot.description, robot.perception),
        watched_(watched) {
    perception_.SetPipeDiameter(diameter_m);
  }
  [[nodiscard]] std::optional<Reading> Read() override {
    const double from_s = Thread_s();
    auto reading = twin_->Read();
    const double to_s = Thread_s();
    watched_.twin_s += to_s - from_s;
    if (!reading) return reading;
    ++watched_.readings;
    static_cast<void>(perception_.Process(*reading));
    watched_.perception_s += Thread_s() - to_s;
    return reading;
  }
  robot::CommandOutcome Apply(const robot::Command& command) override {
    watched_.told.push_back({twin_->Now(), command});
    return twin_->Apply(command);
  }
  void Stop() override { twin_->Stop(); }
  [[nodiscard]] robot::RunTime Now() const override { return twin_->Now(); }
  [[nodiscard]] sim::GroundTruth Truth() { return twin_->Truth(); }

 private:
  std::unique_ptr<sim::Twin> twin_;
  perception::Perception perception_;
  Watched& watched_;
};

struct Mission {
  Scenario scenario;
  std::uint64_t seed;
  RobotFiles robot;
  Conditions conditions;
  sim::World world;
};

sim::World MakeWorld(const Mission& mission, bool cameras) {
  return sim::BuildWorld(mission.scenario.network, mission.conditions.texture, cameras,
                         sim::ReadGripTable(mission.scenario.materials_file));
}

struct Cost {
  double process_s{}, main_s{}, wall_s{};
};

/// Drives the mission. @param recording  empty: none.
MissionRun Drive(const Mission& mission, const std::filesystem::path& recording, Watched& watched,
                 Cost& cost) {
  RunOptions options;
  if (!recording.empty()) options.recording = recording;
  double began_process_s = 0.0, began_main_s = 0.0, began_wall_s = 0.0;
  options.make_body = [&](const Scenario& scenario, const Conditions& conditions,
                          const robot::Description& description) {
    const double diameter_m = scenario.network.PipeNamed(scenario.start.pipe).diameter_m;
    auto body = std::make_unique<WatchedTwin>(
        std::make_unique<sim::Twin>(mission.world, description,
                                    TwinConditions(scenario, conditions)),
        mission.robot, diameter_m, watched);
    WatchedTwin& known = *body;
    began_process_s = Process_s();
    began_main_s = Thread_s();
    began_wall_s = Clock_s(CLOCK_MONOTONIC);
    return Body{std::move(body), [&known] { return known.Truth(); }};
  };
  MissionRun run = RunMission(mission.scenario, mission.seed, options);
  cost = {Process_s() - began_process_s, Thread_s() - began_main_s,
          Clock_s(CLOCK_MONOTONIC) - began_wall_s};
  return run;
}

/// Processor time of a twin that gets the mission's commands, and nobody looks at what it measures.
double DriveAgain(const Mission& mission, const std::vector<Told>& told, bool laser) {
  robot::Description description = mission.robot.description;
  if (!laser) description.laser.speed_rpm = 0.0;
  sim::Twin twin(MakeWorld(mission, false), description,
                 TwinConditions(mission.scenario, mission.conditions));
  const double from_s = Thread_s();
  auto next = told.begin();
  while (next != told.end()) {
    if (!twin.Read()) break;
    while (next != told.end() && next->at <= twin.Now())
      static_cast<void>(twin.Apply((next++)->command));
  }
  return Thread_s() - from_s;
}

struct FrameCost {
  double drawing_s{}, picture_s{};  ///< mean of a frame: the sharp one; with all that lens and
                                    ///< sensor make of it
};

/// Draws what a camera saw along the way, once a second of it.
FrameCost DrawAgain(const Mission& mission, const MissionTrace& trace,
                    const robot::Camera& camera) {
  const sim::Conditions twin = TwinConditions(mission.scenario, mission.conditions);
  const double mast_m = mission.robot.description.MastHeight(twin.mast_diameter_m);
  Eigen::Isometry3d X_BC = sim::MountPose(mission.robot.description, camera.link, mast_m);
  X_BC.rotate(camera.R_LC);
  RandomStream random(mission.seed, "lens." + camera.link);
  const auto imager = std::make_shared<const sim::Imager>(
      camera, sim::ScatterDrops(twin.cameras.drops_on_lens, camera, random));
  const sim::CameraView ideal = imager->lens().ideal();
  sim::Renderer renderer(mission.world.scenery, {ideal.width_px, ideal.height_px});
  sim::CameraRig rig(mission.world.scenery, mission.world.rays,
                     cv::Size(ideal.width_px, ideal.height_px), 0);
  FrameCost cost;
  int frames = 0;
  for (std::size_t i = 10; i < trace.truth.size(); i += 20, ++frames) {
    const Eigen::Isometry3d& X_WB = trace.truth[i].X_WB;
    sim::Shot shot;
    shot.imager = imager;
    shot.X_WC = X_WB * X_BC;
    shot.motion.velocity_C = X_BC.linear().transpose() * Eigen::Vector3d(0.1, 0.0, 0.0);
    shot.noise_stream = std::to_string(i);
    for (const std::string& link : mission.robot.description.lights) {
      const Eigen::Isometry3d X_WLamp =
          X_WB * sim::MountPose(mission.robot.description, link, mast_m);
      shot.lamps.p_WLamp.push_back(X_WLamp.translation());
      if (shot.lamps.p_WLamp.size() == 1) shot.lamps.direction_W = X_WLamp.linear().col(0);
    }
    sim::CameraView view = ideal;
    view.X_WC = shot.X_WC;
    const double from_s = Process_s();
    static_cast<void>(renderer.Render(view, shot.lamps));
    const double drawn_s = Process_s();
    static_cast<void>(rig.Capture(std::move(shot)).get());
    cost.drawing_s += drawn_s - from_s;
    cost.picture_s += Process_s() - drawn_s;
  }
  cost.drawing_s /= frames;
  cost.picture_s /= frames;
  return cost;
}

/// Along the mission's way: revolutions of its laser's scanner from where it was.
double Rays_s(const Mission& mission, const MissionTrace& trace) {
  std::vector<sim::Ray> rays;
  for (std::size_t i = 0; i < trace.truth.size(); i += 2) {
    const Eigen::Isometry3d& X_WB = trace.truth[i].X_WB;
    for (int beam = 0; beam < 333; ++beam) {
      const double angle = 2.0 * M_PI * beam / 333;
      rays.push_back({X_WB * Eigen::Vector3d(-0.1, 0.0, 0.1),
                      X_WB.linear() * Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle))});
    }
  }
  std::vector<std::optional<sim::RayHit>> hits(rays.size());
  const double from_s = Thread_s();
  mission.world.rays->Cast(rays, mission.robot.description.laser.range_max_m, hits);
  return static_cast<double>(rays.size()) / (Thread_s() - from_s);
}

void Row(const char* stage, double stage_s, double sim_s, double all_s) {
  fmt::print("| {} | {:.1f} | {:.1f} | {:.0f} % |\n", stage, stage_s, 1e3 * stage_s / sim_s,
             100.0 * stage_s / all_s);
}

int Measure(const std::filesystem::path& file, std::uint64_t seed) {
  const Scenario whole = ReadScenario(file);
  Mission mission{AroundItsRoute(whole), seed, ReadRobotFiles(whole.robot_folder), {}, {}};
  mission.conditions = DrawConditions(mission.scenario, seed);
  mission.world = MakeWorld(mission, true);

  Watched watched, watched_too;
  Cost cost, recorded;
  const MissionRun run = Drive(mission, {}, watched, cost);
  const auto bag =
      std::filesystem::temp_directory_path() / fmt::format("mission_bench-{}.bag", getpid());
  static_cast<void>(Drive(mission, bag, watched_too, recorded));
  std::filesystem::remove(bag);

  const robot::Description& description = mission.robot.description;
  const double sim_s = run.result.timing.sim_s;
  // Perception worked twice, once to be watched.
  const double main_s = cost.main_s - watched.perception_s;
  const double all_s = cost.process_s - watched.perception_s;
  const double cameras_s = cost.process_s - cost.main_s;
  const double without_cameras_s = DriveAgain(mission, watched.told, true);
  const double without_laser_s = DriveAgain(mission, watched.told, false);
  const FrameCost front = DrawAgain(mission, run.trace, description.front_camera);
  const FrameCost left = DrawAgain(mission, run.trace, description.stereo_left);
  const FrameCost right = DrawAgain(mission, run.trace, description.stereo_right);
  const double picture_s = front.picture_s + left.picture_s + right.picture_s;
  const double drawing_share = (front.drawing_s + left.drawing_s + right.drawing_s) / picture_s;

  fmt::print("{} seed {}: {} in {:.1f} s of simulated time\n\n", run.scenario.name, seed,
             run.result.verdict.passed ? "passed" : "FAILED", sim_s);
  fmt::print(
      "| stage | processor time, s | ms for each simulated second | share |\n"
      "|---|---:|---:|---:|\n");
  Row("physics, contact and small sensors", without_laser_s, sim_s, all_s);
  Row("laser rays and their noise", without_cameras_s - without_laser_s, sim_s, all_s);
  Row("drawing", cameras_s * drawing_share, sim_s, all_s);
  Row("lens and sensor of the cameras", cameras_s * (1.0 - drawing_share), sim_s, all_s);
  Row("perception", watched.perception_s, sim_s, all_s);
  Row("navigation, judging, trace and the rest", main_s - watched.twin_s - watched.perception_s,
      sim_s, all_s);
  Row("all", all_s, sim_s, all_s);
  Row("recording, where asked for", recorded.process_s - cost.process_s, sim_s, all_s);
  fmt::print("\n| | |\n|---|---:|\n");
  const auto rate = [](const char* what, const FrameCost& frame) {
    fmt::print("| {}, frames/s on one core | {:.0f} ({:.1f} ms, of it {:.1f} drawing) |\n", what,
               1.0 / frame.picture_s, 1e3 * frame.picture_s, 1e3 * frame.drawing_s);
  };
  rate("front camera", front);
  rate("stereo left", left);
  rate("stereo right", right);
  fmt::print("| rays/s on one core | {:.2f} million |\n", 1e-6 * Rays_s(mission, run.trace));
  fmt::print("| physics steps/s | {:.0f} |\n", sim_s / 0.002 / without_laser_s);
  fmt::print("| times real time here and now | {:.1f} |\n", sim_s / cost.wall_s);
  fmt::print("| most on two cores, were both always busy | {:.1f} |\n", 2.0 * sim_s / all_s);
  fmt::print("| most that the main thread allows | {:.1f} |\n", sim_s / main_s);
  fmt::print("| processor time to be saved for 10 on two cores | {:.0f} % |\n",
             100.0 * std::max(0.0, 1.0 - 0.2 * sim_s / all_s));
  return run.result.verdict.passed ? 0 : 1;
}

}  // namespace
}  // namespace kantaro::scenarios

int main(int argc, char** argv) {
  try {
    return kantaro::scenarios::Measure(
        argc > 1 ? argv[1] : std::filesystem::path(KANTARO_SOURCE_DIR) / "scenarios/route_1.yaml",
        argc > 2 ? std::stoull(argv[2]) : 1);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
}
