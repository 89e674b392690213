#include "tests/scenarios/synthetic_mission.hpp"

#include <cmath>
#include <numbers>

namespace kantaro::scenarios {
namespace {

constexpr double kSpeed_m_s = 0.12;

network::Pipe MakePipe(const std::string& name, const std::string& upstream,
                       const std::string& downstream) {
  network::Pipe pipe;
  pipe.name = name;
  pipe.upstream = upstream;
  pipe.downstream = downstream;
  pipe.diameter_m = 0.300;
  pipe.joints = {{1.0, 0.008, 0.006}, {2.0, 0.008, 0.006}};
  return pipe;
}

network::Manhole MakeManhole(const std::string& name, double x_m, double y_m) {
  network::Manhole manhole;
  manhole.name = name;
  manhole.p_WM = {x_m, y_m, 0.0};
  return manhole;
}

/// Adds samples of truth and estimate, keeping the clock.
class Recorder {
 public:
  explicit Recorder(MissionTrace& trace) : trace_(trace) {}

  /// Drives straight ahead, by the world's x and y.
  void Drive(double distance_m, const std::string& phase) {
    for (double gone_m = 0.0; gone_m < distance_m - 1e-9; gone_m += kSpeed_m_s * kTracePeriod_s) {
      const double step_m = std::min(kSpeed_m_s * kTracePeriod_s, distance_m - gone_m);
      x_m_ += step_m * std::cos(yaw_rad_);
      y_m_ += step_m * std::sin(yaw_rad_);
      Note(kSpeed_m_s, phase, false);
    }
  }
  void Turn(double angle_rad) {
    for (int i = 0; i < 60; ++i) {
      yaw_rad_ += angle_rad / 60.0;
      Note(0.0, "turning", true);
    }
  }
  void Tell(const std::string& kind, const std::string& text) {
    trace_.events.push_back({time_s_, kind, text});
  }
  [[nodiscard]] double time_s() const { return time_s_; }

 private:
  [[nodiscard]] Place PlaceHere() const {
    const bool branch = y_m_ > 0.4;
    if (branch) return y_m_ < 3.6 ? Place{"B-M2", "", 3.6 - y_m_} : Place{"", "B", 0.0};
    if (x_m_ > 0.4 && x_m_ < 3.6) return {"S-M1", "", x_m_ - 0.4};
    if (x_m_ > 4.4 && x_m_ < 6.6) return {"M1-M2", "", x_m_ - 4.4};
    return {"", x_m_ <= 0.4 ? "S" : x_m_ <= 4.4 ? "M1" : "M2", 0.0};
  }
  void Note(double speed_m_s, const std::string& phase, bool turning) {
    TruthSample truth;
    truth.time_s = time_s_;
    truth.X_WB.translation() = Eigen::Vector3d(x_m_, y_m_, 0.12);
    truth.X_WB.linear() = Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    truth.place = PlaceHere();
    truth.speed_m_s = speed_m_s;
    // In a manhole the robot counts on along the pipe it came by until it has turned.
    const EstimateSample estimate =
        y_m_ > 0.0    ? EstimateSample{time_s_, "B-M2", 3.6 - y_m_, 0.01, phase, turning}
        : x_m_ <= 4.4 ? EstimateSample{time_s_, "S-M1", x_m_ - 0.4, 0.01, phase, turning}
                      : EstimateSample{time_s_, "M1-M2", x_m_ - 4.4, 0.01, phase, turning};
    trace_.truth.push_back(truth);
    trace_.estimate.push_back(estimate);
    time_s_ += kTracePeriod_s;
  }

  MissionTrace& trace_;
  double time_s_{}, x_m_{0.9}, y_m_{}, yaw_rad_{};
};

}  // namespace

network::Network TeeNetwork() {
  network::Network network;
  network.name = "tee";
  network.manholes = {MakeManhole("S", 0.0, 0.0), MakeManhole("M1", 4.0, 0.0),
                      MakeManhole("M2", 7.0, 0.0), MakeManhole("E", 11.0, 0.0),
                      MakeManhole("B", 7.0, 4.0)};
  network.pipes = {MakePipe("S-M1", "S", "M1"), MakePipe("M1-M2", "M1", "M2"),
                   MakePipe("M2-E", "M2", "E"), MakePipe("B-M2", "B", "M2")};
  network.pipes[0].faults = {
      {"crack", network::FaultCategory::kCrack, network::FaultRank::kA, 1.5, 3.0, 0.2, 0.004}};
  network.pipes[1].inlets = {{"house", 1.3, 0.1, 3.0}};
  return network;
}

Scenario TeeScenario() {
  Scenario scenario;
  scenario.file = "tee.yaml";
  scenario.name = "tee";
  scenario.description = "Turn left at the tee.";
  scenario.network_file = "tee_network.yaml";
  scenario.network = TeeNetwork();
  scenario.start = {"S", "S-M1", 0.5};
  scenario.goal = "B";
  scenario.time_limit_s = 200.0;
  return scenario;
}

MissionTrace PerfectMission() {
  MissionTrace trace;
  Recorder recorder(trace);
  recorder.Drive(2.7, "driving");
  recorder.Tell("landmark", "manhole M1 seen");
  recorder.Drive(3.4, "driving");
  recorder.Tell("manoeuvre", "turn begins in M2");
  recorder.Turn(std::numbers::pi / 2.0);
  recorder.Tell("manoeuvre", "turn ends in M2");
  recorder.Drive(4.0, "driving");
  recorder.Tell("arrival", "goal reached");
  AddSighting(trace.faults, {10.0, "S-M1", 1.52, 3.1, 0.83});
  trace.finished = true;
  trace.ending = "The robot arrived at its goal.";
  trace.end_s = recorder.time_s();
  trace.readings = 12345;
  trace.commands = 2345;
  trace.sha256 = std::string(64, 'a');
  return trace;
}

}  // namespace kantaro::scenarios
