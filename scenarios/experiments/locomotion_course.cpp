#include "scenarios/experiments/locomotion_course.hpp"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace kantaro::scenarios {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using network::Joint;
using network::Manhole;
using network::Network;
using network::Pipe;

constexpr double kFast_m_s = 0.15;   ///< straight ahead in a pipe: the thesis' 15 cm/s
constexpr double kRunUp_m_s = 0.20;  ///< against a ring, which takes momentum where it is wet
constexpr double kSpeed_m_s = 0.10;  ///< tread speed through bends and manholes
constexpr double kTurn_m_s = 0.07;   ///< mean of both sides in a manhole's turn: 0.15 outside
constexpr double kStart_m = 0.5;     ///< chainage where every course starts
constexpr double kRun_m = 0.8;       ///< from there to the middle of what is to be passed
constexpr double kBeyond_m = 0.4;    ///< from its end to the goal
constexpr double kFarEnd_m = 0.6;    ///< pipe behind the goal

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// ---------------------------------------------------------------- profiles

Profile Straight(double speed_m_s, double seconds) { return {{seconds, speed_m_s, speed_m_s}}; }

/// Straight up to `from_m` before the middle of a turn, then one side faster by `ratio` and the
/// other slower for `turn_s`, then straight. Left is positive.
Profile Turn(double from_m, double speed_m_s, double ratio, double turn_s, double then_s) {
  return {{(kRun_m - from_m) / kSpeed_m_s, kSpeed_m_s, kSpeed_m_s},
          {turn_s, speed_m_s * (1.0 - ratio), speed_m_s * (1.0 + ratio)},
          {then_s, kSpeed_m_s, kSpeed_m_s}};
}

// ---------------------------------------------------------------- pieces

Manhole At(std::string name, const Vector3d& p_W) {
  Manhole manhole;
  manhole.name = std::move(name);
  manhole.p_WM = p_W;
  return manhole;
}

Pipe Between(std::string name, std::string upstream, std::string downstream, double diameter_m) {
  Pipe pipe;
  pipe.name = std::move(name);
  pipe.upstream = std::move(upstream);
  pipe.downstream = std::move(downstream);
  pipe.diameter_m = diameter_m;
  return pipe;
}

double ShaftRadius(double diameter_m) { return diameter_m / 2.0 + 0.25; }  // thesis 5.2

/// A straight pipe "pipe" with the thing to be passed at chainage kStart_m + kRun_m.
constexpr double kMiddle_m = kStart_m + kRun_m;

Course StraightCourse(double diameter_m, double grade) {
  Course course;
  const double length_m = kMiddle_m + kBeyond_m + kFarEnd_m;
  const double plan_m = length_m / std::hypot(1.0, grade) + 2.0 * ShaftRadius(diameter_m);
  course.network.name = "course";
  course.network.manholes = {At("start", {0.0, 0.0, std::max(0.0, -grade * plan_m)}),
                             At("end", {plan_m, 0.0, std::max(0.0, grade * plan_m)})};
  course.network.pipes = {Between("pipe", "start", "end", diameter_m)};
  course.start = {"pipe", kStart_m, true, 0.0, 0.0};
  course.goal_pipe = "pipe";
  course.goal_chainage_m = kMiddle_m + kBeyond_m;
  return course;
}

Course WithJoint(double diameter_m, const Joint& at_any_place) {
  Course course = StraightCourse(diameter_m, 0.0);
  Joint joint = at_any_place;
  joint.chainage_m = kMiddle_m;
  course.network.pipes[0].joints = {joint};
  return course;
}

Course WithOffset(double diameter_m, double clock_h) {
  Joint joint;
  joint.offset_m = 0.010;
  joint.offset_clock_h = clock_h;
  return WithJoint(diameter_m, joint);
}

/// A stone 60 mm across, right in the left wheels' way: a tyre's
/// tread runs 58 mm beside the middle.
Course WithLump(double diameter_m, double height_m) {
  Course course = StraightCourse(diameter_m, 0.0);
  network::Obstacle lump;
  lump.name = "lump";
  lump.kind = network::ObstacleKind::kStone;
  lump.chainage_m = kMiddle_m;
  lump.clock_h = 6.0 + std::asin(0.058 / (diameter_m / 2.0 - 0.012)) * 6.0 / std::numbers::pi;
  lump.height_m = height_m;
  lump.width_m = lump.length_m = 0.060;
  course.network.pipes[0].obstacles = {lump};
  return course;
}

/// A ring of mortar all round, 20 mm long.
Course WithRing(double diameter_m, double height_m) {
  Course course = StraightCourse(diameter_m, 0.0);
  network::Obstacle ring;
  ring.name = "ring";
  ring.kind = network::ObstacleKind::kMortarRidge;
  ring.chainage_m = kMiddle_m;
  ring.height_m = height_m;
  ring.length_m = 0.020;
  course.network.pipes[0].obstacles = {ring};
  return course;
}

Course WithStep(double diameter_m, double next_m) {
  Course course = StraightCourse(diameter_m, 0.0);
  course.network.pipes[0].diameter_changes = {{kMiddle_m, next_m, network::Alignment::kInvert}};
  return course;
}

Course Bend(double diameter_m, double angle_rad) {
  const double radius_m = 1.5 * diameter_m;
  const double tangent_m = radius_m * std::tan(angle_rad / 2.0);
  const double half_arc_m = radius_m * angle_rad / 2.0;
  const double corner_m = ShaftRadius(diameter_m) + kMiddle_m - half_arc_m + tangent_m;
  const double after_m = tangent_m + kBeyond_m + kFarEnd_m + ShaftRadius(diameter_m);
  const Vector3d corner(corner_m, 0.0, 0.0);
  const Vector3d out(std::cos(angle_rad), std::sin(angle_rad), 0.0);
  Course course = StraightCourse(diameter_m, 0.0);
  course.network.manholes[1].p_WM = corner + after_m * out;
  course.network.pipes[0].bends = {{corner.head<2>(), radius_m}};
  course.goal_chainage_m = kMiddle_m + half_arc_m + kBeyond_m;
  return course;
}

/// Pipe "in" from the west into manhole "M", and pipes to the directions given: "ahead", "left",
/// "right". The middle of the manhole lies kRun_m from the start.
Course Junction(double diameter_m, const std::vector<std::string>& ways, const std::string& goal,
                double drop_m = 0.0) {
  const double shaft_m = ShaftRadius(diameter_m);
  const double length_m = shaft_m + kMiddle_m;
  Course course;
  course.network.name = "course";
  course.network.manholes = {At("start", {-length_m, 0.0, drop_m}), At("M", Vector3d::Zero())};
  course.network.pipes = {Between("in", "start", "M", diameter_m)};
  course.network.pipes[0].downstream_offset_m = drop_m;
  const double out_m = 2.0 * shaft_m + kBeyond_m + kFarEnd_m;
  for (const std::string& way : ways) {
    const Vector3d direction = way == "ahead"  ? Vector3d(1.0, 0.0, 0.0)
                               : way == "left" ? Vector3d(0.0, 1.0, 0.0)
                                               : Vector3d(0.0, -1.0, 0.0);
    course.network.manholes.push_back(At("end " + way, out_m * direction));
    course.network.pipes.push_back(Between(way, "M", "end " + way, diameter_m));
  }
  course.start = {"in", kStart_m, true, 0.0, 0.0};
  course.goal_pipe = goal;
  course.goal_chainage_m = kBeyond_m;
  return course;
}

const std::vector<double> kSizes_m{0.200, 0.250, 0.300, 0.350};

std::vector<LocomotionCase> MakeCases() {
  const Profile over = Straight(kFast_m_s, 14.0);
  const Profile run_up = Straight(kRunUp_m_s, 14.0);
  const Profile across = Straight(kSpeed_m_s, 25.0);
  return {
      {"straight", "a straight pipe, level", over, kSizes_m,
       [](double d) { return StraightCourse(d, 0.0); }},
      {"bend_45", "a bend of 45°, centre-line radius 1.5 diameters",
       Turn(0.3, kSpeed_m_s, 0.4, 6.0, 16.0), kSizes_m,
       [](double d) { return Bend(d, Radians(45.0)); }},
      {"bend_90", "a bend of 90°, centre-line radius 1.5 diameters",
       Turn(0.5, kSpeed_m_s, 0.4, 10.0, 16.0), kSizes_m,
       [](double d) { return Bend(d, Radians(90.0)); }},
      {"tee_left", "from the through line of a tee into its branch on the left",
       Turn(0.36, kTurn_m_s, 1.1, 9.0, 18.0), kSizes_m,
       [](double d) {
         return Junction(d, {"ahead", "left"}, "left");
       }},
      {"tee_right", "and into its branch on the right", Turn(0.36, kTurn_m_s, -1.1, 9.0, 18.0),
       kSizes_m,
       [](double d) {
         return Junction(d, {"ahead", "right"}, "right");
       }},
      {"tee_straight", "straight across a tee", across, kSizes_m,
       [](double d) {
         return Junction(d, {"ahead", "left"}, "ahead");
       }},
      {"cross", "straight across a cross", across, kSizes_m,
       [](double d) {
         return Junction(d, {"ahead", "left", "right"}, "ahead");
       }},
      {"drop_50", "a drop of 50 mm into a manhole, and on", across, kSizes_m,
       [](double d) { return Junction(d, {"ahead"}, "ahead", 0.050); }},
      {"drop_100", "a drop of 100 mm into a manhole, and on", across, kSizes_m,
       [](double d) { return Junction(d, {"ahead"}, "ahead", 0.100); }},
      {"lump_10", "a lump 10 mm high and 60 mm wide in the left wheels' way", over, kSizes_m,
       [](double d) { return WithLump(d, 0.010); }},
      {"lump_20", "a lump 20 mm high and 60 mm wide in the left wheels' way", over, kSizes_m,
       [](double d) { return WithLump(d, 0.020); }},
      {"ring_10", "a ring of mortar 10 mm high and 20 mm long, all round", run_up, kSizes_m,
       [](double d) { return WithRing(d, 0.010); }},
      {"ring_20", "the same, 20 mm high", run_up, kSizes_m,
       [](double d) { return WithRing(d, 0.020); }, false},
      {"offset_up_10", "a joint, the next length 10 mm higher", over, kSizes_m,
       [](double d) { return WithOffset(d, 12.0); }},
      {"offset_down_10", "a joint, the next length 10 mm lower", over, kSizes_m,
       [](double d) { return WithOffset(d, 6.0); }},
      {"offset_lateral_10", "a joint, the next length 10 mm to the right", over, kSizes_m,
       [](double d) { return WithOffset(d, 3.0); }},
      {"step_250_300",
       "from 250 mm into 300 mm in line, the inverts level",
       over,
       {0.250},
       [](double d) { return WithStep(d, 0.300); }},
      {"step_300_250",
       "from 300 mm into 250 mm in line, the inverts level",
       over,
       {0.300},
       [](double d) { return WithStep(d, 0.250); }},
      {"gap_20", "a joint 20 mm wide", over, kSizes_m,
       [](double d) {
         Joint joint;
         joint.gap_m = 0.020;
         return WithJoint(d, joint);
       }},
      {"slope_up_10", "a slope of +10 %", over, kSizes_m,
       [](double d) { return StraightCourse(d, 0.10); }},
      {"slope_down_10", "a slope of -10 %", over, kSizes_m,
       [](double d) { return StraightCourse(d, -0.10); }},
  };
}

}  // namespace

double Duration_s(const Profile& profile) {
  return std::accumulate(profile.begin(), profile.end(), 0.0,
                         [](double sum, const ProfileStep& step) { return sum + step.duration_s; });
}

const std::vector<LocomotionCase>& LocomotionCases() {
  static const std::vector<LocomotionCase> cases = MakeCases();
  return cases;
}

}  // namespace kantaro::scenarios
