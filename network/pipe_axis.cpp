#include "network/pipe_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "network/laid_line.hpp"

namespace kantaro::network {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kTiny_m = 1e-6;           // legs below this are none
constexpr double kTinyTurn = 1e-3;         // bends below this stay corners: an arc would be a crumb
constexpr double kSharpestArc = pi / 4.0;  // of one piece; see the header on the residual
constexpr double kSharpestBend = 170.0 * pi / 180.0;
constexpr double kSteepestGrade = 1.0;

/// A piece as seen from above.
struct PlanPiece {
  Vector2d start{Vector2d::Zero()};
  double heading{};  // at its start
  double length_m{};
  double turn{};  // positive to the left, 0 if straight
};

double Heading(const Vector2d& direction) { return std::atan2(direction.y(), direction.x()); }
Vector2d Unit(double heading) { return {std::cos(heading), std::sin(heading)}; }

double TurnBetween(const Vector2d& before, const Vector2d& after) {
  return std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
}

void AddArc(const Vector2d& start, double heading, double turn, double radius_m,
            std::vector<PlanPiece>& plan) {
  const int count = static_cast<int>(std::ceil(std::abs(turn) / kSharpestArc - 1e-9));
  const double step = turn / count;
  Vector2d from = start;
  for (int i = 0; i < count; ++i) {
    plan.push_back({from, heading, radius_m * std::abs(step), step});
    from += 2.0 * radius_m * std::sin(std::abs(step) / 2.0) * Unit(heading + step / 2.0);
    heading += step;
  }
}

[[noreturn]] void RefuseLeg(std::size_t leg, std::size_t bends, double length_m, double needed_m) {
  if (bends == 0) {
    throw std::invalid_argument(
        fmt::format("the manholes stand {:.3f} m apart, but their shafts alone take {:.3f} m",
                    length_m, needed_m));
  }
  throw std::invalid_argument(fmt::format(
      "leg {} of the centre line is {:.3f} m long, but the bends and shafts at its ends "
      "take {:.3f} m: move the bend or make its radius smaller",
      leg + 1, length_m, needed_m));
}

/// The centre line from above, from shaft wall to shaft wall.
std::vector<PlanPiece> MakePlan(const ShaftEnd& upstream, const ShaftEnd& downstream,
                                const Pipe& pipe) {
  std::vector<Vector2d> corners{upstream.p_WM.head<2>()};
  for (const Bend& bend : pipe.bends) corners.push_back(bend.p_W);
  corners.emplace_back(downstream.p_WM.head<2>());

  const std::size_t legs = corners.size() - 1;
  std::vector<Vector2d> direction(legs);
  for (std::size_t i = 0; i < legs; ++i) {
    direction[i] = corners[i + 1] - corners[i];
    if (!(direction[i].norm() > kTiny_m)) {
      throw std::invalid_argument("two points of the centre line coincide");
    }
  }
  // What each corner cuts off the legs that meet in it.
  std::vector<double> turn(corners.size(), 0.0), cut_m(corners.size(), 0.0);
  cut_m.front() = upstream.radius_m;
  cut_m.back() = downstream.radius_m;
  for (std::size_t i = 1; i < legs; ++i) {
    turn[i] = TurnBetween(direction[i - 1], direction[i]);
    if (std::abs(turn[i]) > kSharpestBend) {
      throw std::invalid_argument(fmt::format("bend {} turns back on itself", i));
    }
    if (std::abs(turn[i]) > kTinyTurn) {
      cut_m[i] = pipe.bends[i - 1].radius_m * std::tan(std::abs(turn[i]) / 2.0);
    }
  }

  std::vector<PlanPiece> plan;
  for (std::size_t i = 0; i < legs; ++i) {
    const double length_m = direction[i].norm();
    const double straight_m = length_m - cut_m[i] - cut_m[i + 1];
    const Vector2d along = direction[i] / length_m;
    if (!(straight_m >= -kTiny_m)) RefuseLeg(i, pipe.bends.size(), length_m, length_m - straight_m);
    if (straight_m > kTiny_m) {
      plan.push_back({corners[i] + cut_m[i] * along, Heading(along), straight_m, 0.0});
    }
    if (cut_m[i + 1] > 0.0 && i + 1 < legs) {
      AddArc(corners[i + 1] - cut_m[i + 1] * along, Heading(along), turn[i + 1],
             pipe.bends[i].radius_m, plan);
    }
  }
  return plan;
}

/// Lifts a piece of the plan into space, tilted so that it rises by grade · plan length.
AxisPiece Lift(const PlanPiece& plan, double z_m, double grade) {
  const double half = plan.turn / 2.0;
  const double chord_per_arc = plan.turn == 0.0 ? 1.0 : std::sin(half) / half;
  const double tilt = std::atan(grade / chord_per_arc);
  const Vector2d chord = Unit(plan.heading + half);
  const Vector3d c(std::cos(tilt) * chord.x(), std::cos(tilt) * chord.y(), std::sin(tilt));
  const Vector3d left(-chord.y(), chord.x(), 0.0);

  AxisPiece piece;
  Matrix3d R_WS;
  R_WS.col(0) = std::cos(half) * c - std::sin(half) * left;
  R_WS.col(1) = std::sin(half) * c + std::cos(half) * left;
  R_WS.col(2) = c.cross(left);
  piece.X_WS.linear() = R_WS;
  piece.X_WS.translation() << plan.start, z_m;
  piece.length_m = plan.length_m / std::cos(tilt);
  piece.curvature = plan.turn / piece.length_m;
  return piece;
}

/// How far along a piece its nearest point to p lies, within the piece.
double NearestOn(const AxisPiece& piece, const Vector3d& p_W) {
  const Vector3d p_S = piece.X_WS.inverse(Eigen::Isometry) * p_W;
  if (piece.curvature == 0.0) return std::clamp(p_S.x(), 0.0, piece.length_m);
  const double radius_m = 1.0 / std::abs(piece.curvature);
  const double inward_m = piece.curvature > 0.0 ? p_S.y() : -p_S.y();
  const double half = piece.length_m / radius_m / 2.0;
  // Measured from the arc's middle, so that the far side of the circle falls to the nearer end.
  const double from_middle =
      std::remainder(std::atan2(p_S.x(), radius_m - inward_m) - half, 2.0 * pi);
  return (std::clamp(from_middle, -half, half) + half) * radius_m;
}

ShaftEnd EndNamed(const Network& network, const std::string& name) {
  const Manhole& manhole = network.ManholeNamed(name);
  return {manhole.p_WM, network.ShaftDiameter(manhole) / 2.0};
}

/// The centre line as designed.
struct Design {
  std::vector<AxisPiece> pieces;
  double length_m{};
  double grade{};  ///< rise over plan length
};

/// Grade of the design line if steps raise the axis by `step_m` square to it, `rise_m` in all.
double GradeFor(double rise_m, double step_m, double plan_m) {
  double grade = rise_m / plan_m;
  for (int i = 0; i < 20 && step_m != 0.0; ++i) {
    grade = (rise_m - step_m * std::hypot(1.0, grade)) / plan_m;
  }
  return grade;
}

Design MakeDesign(const ShaftEnd& upstream, const ShaftEnd& downstream, const Pipe& pipe) {
  const std::vector<PlanPiece> plan = MakePlan(upstream, downstream, pipe);
  double plan_m = 0.0;
  for (const PlanPiece& piece : plan) plan_m += piece.length_m;
  if (plan_m < kShortestPipe_m) {
    throw std::invalid_argument(
        fmt::format("only {:.3f} m of pipe lie between the two shafts, at least {} m are wanted",
                    plan_m, kShortestPipe_m));
  }
  const double start_z_m = upstream.p_WM.z() + pipe.upstream_offset_m + pipe.diameter_m / 2.0;
  const double end_z_m =
      downstream.p_WM.z() + pipe.downstream_offset_m + pipe.DownstreamDiameter() / 2.0;
  Design design;
  design.grade = GradeFor(end_z_m - start_z_m, TotalStep(pipe), plan_m);
  if (!(std::abs(design.grade) <= kSteepestGrade)) {
    throw std::invalid_argument(fmt::format("it is steeper than 45° ({:.3f} m over {:.3f} m)",
                                            end_z_m - start_z_m, plan_m));
  }
  double gone_m = 0.0;
  for (const PlanPiece& piece : plan) {
    AxisPiece lifted = Lift(piece, start_z_m + design.grade * gone_m, design.grade);
    lifted.start_m = design.length_m;
    design.length_m += lifted.length_m;
    gone_m += piece.length_m;
    design.pieces.push_back(lifted);
  }
  return design;
}

}  // namespace

Isometry3d PoseOn(const AxisPiece& piece, double along_m) {
  const double on_m = std::clamp(along_m, 0.0, piece.length_m);
  const double angle = piece.curvature * on_m;
  Isometry3d X_SA = Isometry3d::Identity();
  if (piece.curvature == 0.0) {
    X_SA.translation().x() = on_m;
  } else {
    X_SA.linear() = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
    X_SA.translation() << std::sin(angle) / piece.curvature,
        (1.0 - std::cos(angle)) / piece.curvature, 0.0;
  }
  X_SA.translation() += (along_m - on_m) * X_SA.linear().col(0);
  return piece.X_WS * X_SA;
}

ShaftEnd EndAt(const Network& network, const NetworkIndex& index, std::size_t manhole) {
  return {network.manholes[manhole].p_WM, index.shaft_diameter_m[manhole] / 2.0};
}

PipeAxis::PipeAxis(const Network& network, const Pipe& pipe)
    : PipeAxis(EndNamed(network, pipe.upstream), EndNamed(network, pipe.downstream), pipe) {}

PipeAxis::PipeAxis(const Network& network, const NetworkIndex& index, std::size_t pipe)
    : PipeAxis(EndAt(network, index, index.upstream[pipe]),
               EndAt(network, index, index.downstream[pipe]), network.pipes[pipe]) {}

PipeAxis::PipeAxis(const ShaftEnd& upstream, const ShaftEnd& downstream, const Pipe& pipe) {
  Design design = MakeDesign(upstream, downstream, pipe);
  grade_ = design.grade;
  if (LiesAsDesigned(pipe)) {
    pieces_ = std::move(design.pieces);
    length_m_ = design.length_m;
    return;
  }
  // The steps stand square to the grade: with them the line comes to the shaft's wall earlier or
  // later.
  pieces_ = LayLengths(design.pieces, design.length_m + grade_ * TotalStep(pipe), pipe);
  length_m_ = pieces_.back().start_m + pieces_.back().length_m;
}

double DesignLength(const ShaftEnd& upstream, const ShaftEnd& downstream, const Pipe& pipe) {
  return MakeDesign(upstream, downstream, pipe).length_m;
}

Isometry3d PipeAxis::PoseAt(double chainage_m) const {
  const auto after =
      std::upper_bound(pieces_.begin(), pieces_.end(), chainage_m,
                       [](double value, const AxisPiece& piece) { return value < piece.start_m; });
  const AxisPiece& piece = after == pieces_.begin() ? *after : *std::prev(after);
  return PoseOn(piece, chainage_m - piece.start_m);
}

PipePosition PipeAxis::Locate(const Vector3d& p_W) const {
  double best_m = std::numeric_limits<double>::infinity();
  PipePosition position;
  const auto consider = [&](const AxisPiece& piece, double along_m) {
    const Vector3d p_A = PoseOn(piece, along_m).inverse(Eigen::Isometry) * p_W;
    if (p_A.norm() >= best_m) return;
    best_m = p_A.norm();
    position.chainage_m = piece.start_m + along_m;
    position.offset_m = best_m;
    const double hours = std::atan2(-p_A.y(), p_A.z()) * 6.0 / pi;
    position.clock_h = hours > 0.0 ? hours : hours + 12.0;
  };
  for (const AxisPiece& piece : pieces_) consider(piece, NearestOn(piece, p_W));

  const AxisPiece &first = pieces_.front(), &last = pieces_.back();
  const double before_m = (first.X_WS.inverse(Eigen::Isometry) * p_W).x();
  if (before_m < 0.0) consider(first, before_m);
  const double beyond_m = (PoseOn(last, last.length_m).inverse(Eigen::Isometry) * p_W).x();
  if (beyond_m > 0.0) consider(last, last.length_m + beyond_m);
  return position;
}

Vector3d ClockDirection(double clock_h) {
  const double angle = clock_h * pi / 6.0;
  return {0.0, -std::sin(angle), std::cos(angle)};
}

}  // namespace kantaro::network
