#include "network/laid_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kantaro::network {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kExact_m = 1e-10;      // joints stand at their chainage to within this
constexpr int kMostRounds = 60;         // each brings them nearer by the stretch, at least 2 times
constexpr double kCrumb_m = 1e-9;       // pieces below this are none
constexpr double kNearestCentre = 0.5;  // of a bend, in its radii

/// A place where the line as laid is broken, or given: a joint or a diameter change.
struct Break {
  double chainage_m{};                      // where it stands on the line as laid
  double design_m{};                        // and on the design line
  Vector2d jump_m{Vector2d::Zero()};        // of u there: an offset
  Vector2d slope_change{Vector2d::Zero()};  // of u
  double step_m{};                          // of the axis, up: a diameter change
  bool is_joint{true};
  double below_m{};                                                // how far a sag has taken it
  Vector2d before_m{Vector2d::Zero()}, after_m{Vector2d::Zero()};  // u
};

Vector2d LeftUp(double clock_h) { return ClockDirection(clock_h).tail<2>(); }

double Step(const DiameterChange& change, double diameter_before_m) {
  const double half_m = (change.diameter_m - diameter_before_m) / 2.0;
  switch (change.alignment) {
    case Alignment::kInvert:
      return half_m;
    case Alignment::kCrown:
      return -half_m;
    case Alignment::kAxis:
      break;
  }
  return 0.0;
}

double SagAt(const Pipe& pipe, double chainage_m) {
  for (const Sag& sag : pipe.sags) {
    const double from_m = chainage_m - sag.start_m, to_m = sag.end_m - chainage_m;
    if (from_m > 0.0 && to_m > 0.0) {
      return 4.0 * sag.depth_m * from_m * to_m / std::pow(sag.end_m - sag.start_m, 2);
    }
  }
  return 0.0;
}

/// In the order of chainage, each at first where the design line has its chainage.
std::vector<Break> BreaksOf(const Pipe& pipe) {
  std::vector<Break> breaks;
  for (const Joint& joint : pipe.joints) {
    if (joint.offset_m == 0.0 && joint.deflection_rad == 0.0 && pipe.sags.empty()) continue;
    Break at;
    at.chainage_m = joint.chainage_m;
    at.jump_m = joint.offset_m * LeftUp(joint.offset_clock_h);
    at.slope_change = std::tan(joint.deflection_rad) * LeftUp(joint.deflection_clock_h);
    at.below_m = SagAt(pipe, joint.chainage_m);
    breaks.push_back(at);
  }
  double diameter_m = pipe.diameter_m;
  for (const DiameterChange& change : pipe.diameter_changes) {
    Break at;
    at.chainage_m = change.chainage_m;
    at.step_m = Step(change, diameter_m);
    at.is_joint = false;
    breaks.push_back(at);
    diameter_m = change.diameter_m;
  }
  std::erase_if(breaks, [](const Break& at) { return !(at.chainage_m > 0.0); });
  std::stable_sort(breaks.begin(), breaks.end(),
                   [](const Break& a, const Break& b) { return a.chainage_m < b.chainage_m; });
  for (Break& at : breaks) at.design_m = at.chainage_m;
  return breaks;
}

/// Sags take the lengths between joints down as chords: what stands in between goes with them.
void SinkBetweenJoints(std::vector<Break>& breaks, double end_m) {
  double from_m = 0.0, from_below_m = 0.0;
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    if (breaks[i].is_joint) {
      from_m = breaks[i].design_m;
      from_below_m = breaks[i].below_m;
      continue;
    }
    const auto next = std::find_if(breaks.begin() + static_cast<std::ptrdiff_t>(i), breaks.end(),
                                   [](const Break& at) { return at.is_joint; });
    const double to_m = next == breaks.end() ? end_m : next->design_m;
    const double to_below_m = next == breaks.end() ? 0.0 : next->below_m;
    const double share = to_m > from_m ? (breaks[i].design_m - from_m) / (to_m - from_m) : 0.0;
    breaks[i].below_m = from_below_m + share * (to_below_m - from_below_m);
  }
}

/// u before and after each break, and at the end: linear in between, 0 at the start and on the
/// grade at the end.
Vector2d Displace(std::vector<Break>& breaks, double end_m) {
  SinkBetweenJoints(breaks, end_m);
  Vector2d u_m = Vector2d::Zero(), slope = Vector2d::Zero();
  double at_m = 0.0, step_m = 0.0;
  for (Break& at : breaks) {
    u_m += slope * (at.design_m - at_m);
    at_m = at.design_m;
    const auto risen = [&] { return Vector2d(0.0, step_m - at.below_m); };
    at.before_m = u_m + risen();
    u_m += at.jump_m;
    slope += at.slope_change;
    step_m += at.step_m;
    at.after_m = u_m + risen();
  }
  const Vector2d shared_slope = -(u_m + slope * (end_m - at_m)) / end_m;
  for (Break& at : breaks) {
    at.before_m += shared_slope * at.design_m;
    at.after_m += shared_slope * at.design_m;
  }
  return {0.0, step_m};
}

/// The stretch from_m … to_m of a piece of the design line, moved to run between two points.
AxisPiece Move(const AxisPiece& design, double from_m, double to_m, const Vector3d& p_WFrom,
               const Vector3d& p_WTo) {
  const Eigen::Isometry3d X_WF = PoseOn(design, from_m - design.start_m);
  const Vector3d chord = p_WTo - p_WFrom;
  const Vector3d designed =
      PoseOn(design, to_m - design.start_m).translation() - X_WF.translation();
  const double half_turn = design.curvature * (to_m - from_m) / 2.0;
  AxisPiece piece;
  piece.X_WS.linear() =
      Quaterniond::FromTwoVectors(designed, chord).toRotationMatrix() * X_WF.linear();
  piece.X_WS.translation() = p_WFrom;
  const double arc_per_chord = half_turn == 0.0 ? 1.0 : half_turn / std::sin(half_turn);
  piece.length_m = chord.norm() * arc_per_chord;
  piece.curvature = 2.0 * half_turn / piece.length_m;
  return piece;
}

void CheckNear(const AxisPiece& design, double length_m, const Vector2d& from_u_m,
               const Vector2d& to_u_m) {
  const double slope = (to_u_m - from_u_m).norm() / length_m;
  if (!(slope <= kSteepestLength)) {
    throw std::invalid_argument(
        fmt::format("its joints and sags turn a length by {:.3f} to 1 from the line from manhole "
                    "to manhole, more than {}",
                    slope, kSteepestLength));
  }
  if (!(std::max(from_u_m.x() * design.curvature, to_u_m.x() * design.curvature) <=
        kNearestCentre)) {
    throw std::invalid_argument("its joints and sags move it to the centre of a bend");
  }
}

/// The point beside a piece of the design line. Where the next piece begins, its frame counts,
/// which on a grade is not quite this one's: in between, from one to the other.
Vector3d Beside(const AxisPiece& piece, const AxisPiece* next, double design_m,
                const Vector2d& u_m) {
  const Eigen::Isometry3d X_WD = PoseOn(piece, design_m - piece.start_m);
  const Vector3d u_D(0.0, u_m.x(), u_m.y());
  if (next == nullptr) return X_WD * u_D;
  const Eigen::Matrix3d R_WE = PoseOn(piece, piece.length_m).linear();
  const Vector3d u_E = R_WE.transpose() * next->X_WS.linear() * u_D;
  const double share = (design_m - piece.start_m) / piece.length_m;
  return X_WD * (u_D + share * (u_E - u_D));
}

/// A line in the making.
struct Line {
  std::vector<AxisPiece> pieces;
  double length_m{};
};

/// Adds what lies between two breaks, along all the pieces of the design line in between.
void AddLength(const std::vector<AxisPiece>& design, double from_m, double to_m,
               const Vector2d& from_u_m, const Vector2d& to_u_m, Line& line) {
  if (to_m - from_m < kCrumb_m) return;
  const auto beside = [&](const auto& piece, double design_m) {
    const auto next = std::next(piece);
    return Beside(*piece, next == design.end() ? nullptr : &*next, design_m,
                  from_u_m + (to_u_m - from_u_m) * ((design_m - from_m) / (to_m - from_m)));
  };
  auto piece = std::prev(std::upper_bound(
      design.begin() + 1, design.end(), from_m,
      [](double value, const AxisPiece& candidate) { return value < candidate.start_m; }));
  Vector3d p_WFrom = beside(piece, from_m);
  for (double at_m = from_m; at_m < to_m; ++piece) {
    const auto next = std::next(piece);
    const double until_m = next == design.end() ? to_m : std::min(to_m, next->start_m);
    CheckNear(*piece, to_m - from_m, from_u_m, to_u_m);
    if (until_m - at_m >= kCrumb_m) {
      const Vector3d p_WTo = beside(piece, until_m);
      AxisPiece moved = Move(*piece, at_m, until_m, p_WFrom, p_WTo);
      moved.start_m = line.length_m;
      line.length_m += moved.length_m;
      line.pieces.push_back(moved);
      p_WFrom = p_WTo;
    }
    at_m = until_m;
  }
}

/// Lays the line for breaks at their places on the design line, then moves these by what each
/// misses its chainage by. Returns the largest miss.
double LayOnce(const std::vector<AxisPiece>& design, double end_m, std::vector<Break>& breaks,
               Line& line) {
  const Vector2d end_u_m = Displace(breaks, end_m);
  line = {};
  double from_m = 0.0, largest_m = 0.0;
  Vector2d from_u_m = Vector2d::Zero();
  std::vector<double> misses_m;
  for (const Break& at : breaks) {
    AddLength(design, from_m, at.design_m, from_u_m, at.before_m, line);
    misses_m.push_back(at.chainage_m - line.length_m);
    if (std::abs(misses_m.back()) <= kExact_m) line.length_m = at.chainage_m;
    from_m = at.design_m;
    from_u_m = at.after_m;
  }
  AddLength(design, from_m, end_m, from_u_m, end_u_m, line);
  double least_m = 0.0;
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    const double wanted_m = breaks[i].design_m + misses_m[i];
    breaks[i].design_m = least_m = std::clamp(wanted_m, least_m, end_m);
    if (breaks[i].design_m < end_m) largest_m = std::max(largest_m, std::abs(misses_m[i]));
  }
  return largest_m;
}

}  // namespace

bool LiesAsDesigned(const Pipe& pipe) {
  return pipe.sags.empty() && pipe.diameter_changes.empty() &&
         std::all_of(pipe.joints.begin(), pipe.joints.end(), [](const Joint& joint) {
           return joint.offset_m == 0.0 && joint.deflection_rad == 0.0;
         });
}

double TotalStep(const Pipe& pipe) {
  double step_m = 0.0, diameter_m = pipe.diameter_m;
  for (const DiameterChange& change : pipe.diameter_changes) {
    step_m += Step(change, diameter_m);
    diameter_m = change.diameter_m;
  }
  return step_m;
}

std::vector<AxisPiece> LayLengths(const std::vector<AxisPiece>& design, double end_m,
                                  const Pipe& pipe) {
  if (!(end_m >= kShortestPipe_m)) {
    throw std::invalid_argument("its diameter changes leave nothing of it between the shafts");
  }
  std::vector<Break> breaks = BreaksOf(pipe);
  Line line;
  for (int round = 0; round < kMostRounds; ++round) {
    if (LayOnce(design, end_m, breaks, line) <= kExact_m) return std::move(line.pieces);
  }
  throw std::invalid_argument("its joints and sags displace it too far");
}

}  // namespace kantaro::network
