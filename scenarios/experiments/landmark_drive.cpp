#include "scenarios/experiments/landmark_drive.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "perception/attitude.hpp"
#include "sim/robot_model.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using network::Pipe;

constexpr double kSpeed_m_s = 0.15;  ///< the thesis' 15 cm/s
constexpr double kRunUp_m = 1.0;     ///< of the base, from its start to the landmark's edge
constexpr double kBehind_m = 0.6;    ///< pipe behind the start
constexpr double kRunOut_m = 0.25;   ///< of the laser, from the landmark's other edge to the end
constexpr double kAhead_m = 1.2;     ///< pipe beyond the landmark
constexpr double kJointSpacing_m = 0.7;  ///< out of step with all else
constexpr double kPatience = 3.0;        ///< times what the way takes

// As models/kantaro/navigation.yaml steers.
constexpr double kUprightGain = 2.0;
constexpr double kUprightDamping_s = 2.0;
constexpr double kHeadingGain = 2.0;
constexpr double kSteeringLimit = 0.5;

bool IsManhole(PassedKind kind) {
  return kind != PassedKind::kJoints && kind != PassedKind::kInletLeft &&
         kind != PassedKind::kInletRight;
}

perception::LaserStatus StatusOf(PassedKind kind) {
  using perception::LaserStatus;
  switch (kind) {
    case PassedKind::kJoints:
      return LaserStatus::kNoLandmark;
    case PassedKind::kManhole:
      return LaserStatus::kManhole;
    case PassedKind::kInletLeft:
      return LaserStatus::kInletLeft;
    case PassedKind::kInletRight:
      return LaserStatus::kInletRight;
    case PassedKind::kJunctionLeft:
    case PassedKind::kJunctionRight:
      return LaserStatus::kManholeWithJunction;
    case PassedKind::kCross:
      return LaserStatus::kOutsideThePipe;
  }
  throw std::invalid_argument("no kind of landmark");
}

/// Sewers laid along +Wx, each pipe drawn the one way or the other.
class Builder {
 public:
  Builder(double diameter_m, bool downstream) : diameter_m_(diameter_m), downstream_(downstream) {
    network_.name = "landmark";
  }

  void Manhole(std::string name, const Vector3d& p_W) {
    network_.manholes.emplace_back();
    network_.manholes.back().name = std::move(name);
    network_.manholes.back().p_WM = p_W;
  }

  Pipe& Lay(std::string name, std::string from, std::string to, double length_m) {
    network_.pipes.emplace_back();
    Pipe& pipe = network_.pipes.back();
    pipe.name = std::move(name);
    pipe.upstream = std::move(from);
    pipe.downstream = std::move(to);
    if (!downstream_) std::swap(pipe.upstream, pipe.downstream);
    pipe.diameter_m = diameter_m_;
    for (double at = 0.4; at < length_m - 0.2; at += kJointSpacing_m) {
      network::Joint joint;
      joint.chainage_m = downstream_ ? at : length_m - at;
      pipe.joints.push_back(joint);
    }
    if (!downstream_) std::ranges::reverse(pipe.joints);
    return pipe;
  }

  [[nodiscard]] double ShaftRadius() const { return diameter_m_ / 2.0 + 0.25; }  // thesis 5.2
  network::Network Take() { return std::move(network_); }

 private:
  double diameter_m_;
  bool downstream_;
  network::Network network_;
};

}  // namespace

LandmarkCourse MakeLandmarkCourse(PassedKind kind, double diameter_m, bool downstream,
                                  double inlet_m, double inlet_up_h) {
  LandmarkCourse course;
  course.kind = kind;
  course.status = StatusOf(kind);
  Builder builder(diameter_m, downstream);
  const double shaft_m = builder.ShaftRadius();
  const double edge_m = IsManhole(kind) ? shaft_m : inlet_m / 2.0;
  const double before_m = kBehind_m + kRunUp_m;  // of pipe, up to the landmark's edge
  double in_m = before_m;
  builder.Manhole("from", {-edge_m - before_m - shaft_m, 0.0, 0.0});
  builder.Manhole("to", {edge_m + kAhead_m + shaft_m, 0.0, 0.0});
  if (IsManhole(kind)) {
    builder.Manhole("M", Vector3d::Zero());
    builder.Lay("in", "from", "M", in_m);
    builder.Lay("out", "M", "to", kAhead_m);
    const auto branch = [&](const char* name, double side) {
      builder.Manhole(name, {0.0, side * (2.0 * shaft_m + kAhead_m), 0.0});
      builder.Lay(std::string(name) + " pipe", "M", name, kAhead_m);
    };
    if (kind != PassedKind::kManhole && kind != PassedKind::kJunctionRight) branch("left", 1.0);
    if (kind == PassedKind::kJunctionRight || kind == PassedKind::kCross) branch("right", -1.0);
  } else {
    in_m = before_m + 2.0 * edge_m + kAhead_m;
    Pipe& pipe = builder.Lay("in", "from", "to", in_m);
    if (kind != PassedKind::kJoints) {
      // Seen downstream 3 o'clock is to the right; who drives upstream sees it to the left.
      const bool at_three = (kind == PassedKind::kInletRight) == downstream;
      const double middle_m = before_m + edge_m;
      network::Inlet inlet;
      inlet.name = "inlet";
      inlet.diameter_m = inlet_m;
      inlet.chainage_m = downstream ? middle_m : in_m - middle_m;
      inlet.clock_h = at_three ? 3.0 - inlet_up_h : 9.0 + inlet_up_h;
      pipe.inlets = {inlet};
      std::erase_if(pipe.joints, [&](const network::Joint& joint) {
        return std::abs(joint.chainage_m - inlet.chainage_m) <
               inlet_m;  // pipe makers avoid it, too
      });
    }
  }
  course.network = builder.Take();
  course.start = {"in", downstream ? kBehind_m : in_m - kBehind_m, downstream, 0.0, 0.0};
  course.half_length_m = edge_m;
  course.end_x_m = edge_m + kRunOut_m;
  return course;
}

LandmarkDrive DrivePast(const robot::Description& description, const LandmarkCourse& course,
                        const LandmarkDriveConditions& conditions,
                        const std::function<void(const robot::Reading&)>& hear,
                        const std::optional<sim::GripTable>& grips) {
  robot::Description askew = description;
  for (robot::Joint& joint : askew.joints) {
    if (joint.name == askew.laser.mast)
      joint.X_PJ.pretranslate(Vector3d(0.0, -conditions.laser_right_m, conditions.laser_up_m));
  }
  const double diameter_m = course.network.PipeNamed(course.start.pipe).diameter_m;
  LandmarkDrive drive;
  drive.p_BL = sim::MountPose(askew, askew.laser.link, askew.MastHeight(diameter_m)).translation();

  sim::Conditions run;
  run.start = course.start;
  run.start.roll_rad = conditions.roll_rad;
  run.start.yaw_rad = conditions.yaw_rad;
  run.seed = conditions.seed;
  run.wheel_friction = conditions.wheel_friction;
  run.mast_diameter_m = diameter_m;
  run.time_limit_s = kPatience * (kBehind_m + kRunUp_m + 2.0 * course.end_x_m) / kSpeed_m_s;
  sim::Twin twin(sim::BuildWorld(course.network, conditions.seed, false, grips), askew, run);

  const double speed_rad_s = kSpeed_m_s / askew.tyres.at(askew.wheels.front()).radius_m;
  perception::AttitudeFilter attitude;
  std::optional<double> last_s;  // of the inertial unit
  double heading_rad = 0.0;      // since the manhole's mouth
  twin.Apply({speed_rad_s, speed_rad_s});
  while (const auto reading = twin.Read()) {
    const Isometry3d X_WB = twin.Truth().X_WB;
    drive.places.push_back({robot::Seconds(twin.Now()), X_WB});
    if (const auto* inertial = std::get_if<robot::InertialReading>(&reading->value)) {
      const auto lies = attitude.Update(*inertial, reading->captured_at);
      // Across a manhole there is no round wall to lean on: hold the heading of its entry.
      const bool across =
          IsManhole(course.kind) && std::abs(X_WB.translation().x()) < course.half_length_m;
      const double passed_s = last_s ? robot::Seconds(reading->captured_at) - *last_s : 0.0;
      last_s = robot::Seconds(reading->captured_at);
      heading_rad = across ? heading_rad + lies.yaw_rate_rad_s * passed_s : 0.0;
      const double upright = -kUprightGain * (lies.roll_rad - conditions.roll_rad) -
                             kUprightDamping_s * lies.roll_rate_rad_s;
      const double turn = std::clamp(across ? -kHeadingGain * heading_rad : upright,
                                     -kSteeringLimit, kSteeringLimit);
      twin.Apply({speed_rad_s * (1.0 - turn), speed_rad_s * (1.0 + turn)});
    }
    hear(*reading);
    drive.arrived = (X_WB * drive.p_BL).x() > course.end_x_m;
    if (drive.arrived) break;
  }
  return drive;
}

double LandmarkDrive::XAt(const Vector3d& p_BP, double time_s) const {
  if (places.empty()) throw std::invalid_argument("a drive without places");
  const auto x = [&](const RobotPlace& place) { return (place.X_WB * p_BP).x(); };
  const auto after = std::ranges::lower_bound(places, time_s, {}, &RobotPlace::time_s);
  if (after == places.begin()) return x(*after);
  if (after == places.end()) return x(places.back());
  const auto before = after - 1;
  const double span_s = after->time_s - before->time_s;
  const double share = span_s > 0.0 ? (time_s - before->time_s) / span_s : 1.0;
  return x(*before) + share * (x(*after) - x(*before));
}

}  // namespace kantaro::scenarios
