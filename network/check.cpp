#include "network/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>
#include <vector>

#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "network/laid_line.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {
namespace {

constexpr double kFarthest_m = 1e7;  // a millimetre is still exact there
constexpr double kLargestShaft_m = 50.0;
constexpr double kDeepest_m = 500.0;
constexpr double kLongestPipe_m = 20'000.0;
constexpr double kLargestGap_m = 0.2;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestDeflection_rad = 10.0 * kDegree;
constexpr double kDeepestSag_m = 1.0;
constexpr double kFlattestInlet_rad = 30.0 * kDegree;
constexpr double kSteepestInlet_rad = 150.0 * kDegree;
constexpr double kGrace = 1e-12;  // of a number that was written in degrees or millimetres

void Want(bool good, const char* field, const std::string& problem) {
  if (!good) throw Flaw(field, problem);
}

/// low < value <= high; NaN fails.
void WantWithin(double value, double low, double high, const char* field, double unit = 1.0) {
  if (value > low && value <= high) return;
  throw Flaw(field, fmt::format("{:.6g} must be above {:.6g} and at most {:.6g}", value * unit,
                                low * unit, high * unit));
}

void WantMillimetres(double value_m, double low_m, double high_m, const char* field) {
  WantWithin(value_m, low_m, high_m, field, 1000.0);
}

/// 0 <= value < limit; NaN fails.
void WantBelow(double value_m, double limit_m, const char* field, const char* whose) {
  Want(value_m >= 0.0 && value_m < limit_m, field,
       fmt::format("{:.6g} must be at least 0 and less than {} {:.6g}", value_m * 1000.0, whose,
                   limit_m * 1000.0));
}

/// Runs a check of a part and puts the part's place before what it complains of.
template <typename Function>
void Inside(const char* list, std::size_t index, Function&& check) {
  try {
    check();
  } catch (const Flaw& flaw) {
    throw Flaw(fmt::format("{}[{}].{}", list, index, flaw.field), flaw.what());
  }
}

template <typename Item, typename Function>
void ForEach(const char* list, const std::vector<Item>& items, Function&& check) {
  for (std::size_t i = 0; i < items.size(); ++i) Inside(list, i, [&] { check(items[i]); });
}

void CheckName(const std::string& name) {
  Want(!name.empty(), "name", "a name is wanted here");
  Want(name.size() <= kLongestName, "name",
       fmt::format("a name has at most {} bytes", kLongestName));
  const bool printable = std::all_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
  });
  Want(printable && IsUtf8(name), "name", "a name is made of printable UTF-8 characters");
}

/// Names are unique; `taken` remembers where each was used first.
void CheckUnique(std::map<std::string_view, std::string>& taken, const std::string& name,
                 const std::string& place) {
  CheckName(name);
  const auto [first, is_new] = taken.emplace(name, place);
  Want(is_new, "name", fmt::format("the name \"{}\" is taken by {} already", name, first->second));
}

void CheckManhole(const Manhole& manhole) {
  Want(manhole.p_WM.allFinite() && manhole.p_WM.cwiseAbs().maxCoeff() <= kFarthest_m, "position_m",
       fmt::format("coordinates must lie within {:.0f} m of the origin", kFarthest_m));
  WantWithin(manhole.depth_m, 0.0, kDeepest_m, "depth_m");
  if (manhole.bench_height == BenchHeight::kGiven) {
    Want(manhole.given_bench_m > 0.0 && manhole.given_bench_m < manhole.depth_m, "bench_height",
         fmt::format("{:.6g} mm must be above 0 and below the cover at {:.6g} mm",
                     manhole.given_bench_m * 1000, manhole.depth_m * 1000));
  }
  if (manhole.shaft_diameter_m) {
    WantMillimetres(*manhole.shaft_diameter_m, 0.0, kLargestShaft_m, "shaft_diameter_mm");
  }
  if (manhole.channel_radius_m) {
    WantMillimetres(*manhole.channel_radius_m, 0.0, kLargestShaft_m, "channel_radius_mm");
  }
}

/// What the pipes that meet in a manhole demand of it.
void CheckFit(const Manhole& manhole, const Pipe& pipe, double offset_m) {
  const double diameter_m = pipe.DiameterIn(manhole.name);
  Want(!manhole.shaft_diameter_m ||
           *manhole.shaft_diameter_m >= diameter_m + kLeastBenching_m - kGrace,
       "shaft_diameter_mm",
       fmt::format("{:.6g} must be at least {:.0f} more than pipe \"{}\" with its {:.6g}",
                   manhole.shaft_diameter_m.value_or(0.0) * 1000, kLeastBenching_m * 1000,
                   pipe.name, diameter_m * 1000));
  Want(!manhole.channel_radius_m || *manhole.channel_radius_m > diameter_m / 2, "channel_radius_mm",
       fmt::format("the channel's radius must be above half of pipe \"{}\" ({:.6g} mm)", pipe.name,
                   diameter_m * 500));
  Want(manhole.depth_m >= offset_m + diameter_m, "depth_m",
       fmt::format("the crown of pipe \"{}\" lies {:.3f} m above the invert, higher than the cover "
                   "at {:.3f} m",
                   pipe.name, offset_m + diameter_m, manhole.depth_m));
}

void CheckClock(double clock_h, const char* field = "clock") {
  WantWithin(clock_h, 0.0, 12.0, field);
}

/// What displaces the centre line must be sound before it can be laid.
void CheckJoints(const Pipe& pipe) {
  double end_of_last_m = 0.0;
  ForEach("joints", pipe.joints, [&](const Joint& joint) {
    WantMillimetres(joint.gap_m, 0.0, kLargestGap_m, "gap_mm");
    WantMillimetres(joint.depth_m, 0.0, kLargestGap_m, "depth_mm");
    WantBelow(joint.offset_m, pipe.DiameterAt(joint.chainage_m) / 2, "offset_mm",
              "the pipe's radius");
    CheckClock(joint.offset_clock_h, "offset_clock");
    Want(joint.deflection_rad >= 0.0 && joint.deflection_rad <= kLargestDeflection_rad + kGrace,
         "deflection_deg",
         fmt::format("{:.6g} must be between 0 and {:.6g}", joint.deflection_rad / kDegree,
                     kLargestDeflection_rad / kDegree));
    CheckClock(joint.deflection_clock_h, "deflection_clock");
    Want(joint.chainage_m - joint.gap_m / 2 >= end_of_last_m, "at_m",
         "joints stand within the pipe, in the order of chainage, and do not overlap");
    end_of_last_m = joint.chainage_m + joint.gap_m / 2;
  });
}

void CheckDiameterChanges(const Pipe& pipe) {
  double last_m = 0.0;
  ForEach("diameter_changes", pipe.diameter_changes, [&](const DiameterChange& change) {
    WantMillimetres(change.diameter_m, 0.0, kLargestDiameter_m, "diameter_mm");
    Want(change.chainage_m > last_m, "at_m",
         "diameter changes lie within the pipe, in the order of chainage");
    last_m = change.chainage_m;
    for (const Joint& joint : pipe.joints) {
      Want(std::abs(change.chainage_m - joint.chainage_m) > joint.gap_m / 2, "at_m",
           fmt::format("{:.6g} lies in the groove of the joint at {:.6g}", change.chainage_m,
                       joint.chainage_m));
    }
  });
}

void CheckSags(const Pipe& pipe) {
  double last_m = 0.0;
  ForEach("sags", pipe.sags, [&](const Sag& sag) {
    WantMillimetres(sag.depth_m, 0.0, kDeepestSag_m, "depth_mm");
    Want(sag.start_m >= last_m, "from_m",
         "sags lie within the pipe, in the order of chainage, and do not overlap");
    Want(sag.end_m > sag.start_m, "to_m", "a sag ends after it begins");
    Want(std::any_of(pipe.joints.begin(), pipe.joints.end(),
                     [&](const Joint& joint) {
                       return joint.chainage_m > sag.start_m && joint.chainage_m < sag.end_m;
                     }),
         "from_m", "a pipe sags at its joints: at least one must lie within");
    last_m = sag.end_m;
  });
}

void CheckLaidWithin(const Pipe& pipe, double length_m) {
  const auto within = [&](double chainage_m, double half_m, const char* field) {
    Want(chainage_m + half_m <= length_m, field,
         fmt::format("{:.6g} lies outside the pipe, which is {:.3f} m long between its shafts",
                     chainage_m, length_m));
  };
  ForEach("joints", pipe.joints,
          [&](const Joint& joint) { within(joint.chainage_m, joint.gap_m / 2, "at_m"); });
  ForEach("diameter_changes", pipe.diameter_changes,
          [&](const DiameterChange& change) { within(change.chainage_m, 0.0, "at_m"); });
  ForEach("sags", pipe.sags, [&](const Sag& sag) { within(sag.end_m, 0.0, "to_m"); });
}

void CheckInside(double chainage_m, double half_m, double length_m) {
  Want(chainage_m - half_m >= 0.0 && chainage_m + half_m <= length_m, "at_m",
       fmt::format("{:.6g} ± {:.3f} m reaches outside the pipe, which is {:.3f} m long between its "
                   "shafts",
                   chainage_m, half_m, length_m));
}

void CheckInlet(const Inlet& inlet, const Pipe& pipe, double length_m) {
  CheckName(inlet.name);
  const double pipe_diameter_m = pipe.DiameterAt(inlet.chainage_m);
  Want(inlet.diameter_m > 0.0 && inlet.diameter_m < pipe_diameter_m, "diameter_mm",
       fmt::format("{:.6g} must be above 0 and less than the pipe's {:.6g}",
                   inlet.diameter_m * 1000, pipe_diameter_m * 1000));
  CheckClock(inlet.clock_h);
  Want(inlet.angle_rad >= kFlattestInlet_rad - kGrace &&
           inlet.angle_rad <= kSteepestInlet_rad + kGrace,
       "angle_deg",
       fmt::format("{:.6g} must be between {:.0f} and {:.0f}", inlet.angle_rad / kDegree,
                   kFlattestInlet_rad / kDegree, kSteepestInlet_rad / kDegree));
  WantBelow(inlet.protrusion_m, pipe_diameter_m, "protrusion_mm", "the pipe's diameter");
  CheckInside(inlet.chainage_m, inlet.diameter_m / 2 / std::sin(inlet.angle_rad), length_m);
}

/// Width across the pipe, which means something else for each kind.
void CheckWidth(const Obstacle& obstacle, double pipe_diameter_m) {
  const double round_m = std::numbers::pi * pipe_diameter_m;
  switch (obstacle.kind) {
    case ObstacleKind::kSediment:
      Want(obstacle.width_m == 0.0, "width_mm", "sediment lies level from wall to wall");
      Want(obstacle.clock_h == 6.0, "clock", "sediment lies at 6");
      break;
    case ObstacleKind::kStone:
      WantMillimetres(obstacle.width_m, 0.0, pipe_diameter_m, "width_mm");
      Want(obstacle.width_m >= 2 * obstacle.height_m, "width_mm",
           fmt::format("{:.6g} is less than twice the height: a stone is at most half a ball",
                       obstacle.width_m * 1000));
      Want(obstacle.length_m == obstacle.width_m, "length_mm", "a stone is as long as it is wide");
      break;
    case ObstacleKind::kMortarRidge:
      Want(obstacle.width_m >= 0.0 && obstacle.width_m <= round_m, "width_mm",
           fmt::format("{:.6g} must be between 0 (a full ring) and {:.6g}, once round the wall",
                       obstacle.width_m * 1000, round_m * 1000));
      break;
    case ObstacleKind::kBrick:
      WantMillimetres(obstacle.width_m, 0.0, pipe_diameter_m, "width_mm");
      break;
  }
}

void CheckObstacle(const Obstacle& obstacle, const Pipe& pipe, double length_m) {
  CheckName(obstacle.name);
  CheckClock(obstacle.clock_h);
  const double pipe_diameter_m = pipe.DiameterAt(obstacle.chainage_m);
  Want(obstacle.height_m > 0.0 && obstacle.height_m < pipe_diameter_m, "height_mm",
       fmt::format("{:.6g} must be above 0 and less than the pipe's diameter {:.6g}",
                   obstacle.height_m * 1000, pipe_diameter_m * 1000));
  CheckWidth(obstacle, pipe_diameter_m);
  WantMillimetres(obstacle.length_m, 0.0, length_m, "length_mm");
  CheckInside(obstacle.chainage_m, obstacle.length_m / 2, length_m);
}

void CheckFault(const Fault& fault, const Pipe& pipe, double length_m) {
  CheckName(fault.name);
  CheckClock(fault.clock_h);
  WantMillimetres(fault.length_m, 0.0, length_m, "length_mm");
  WantMillimetres(fault.width_m, 0.0, std::numbers::pi * pipe.DiameterAt(fault.chainage_m),
                  "width_mm");
  CheckInside(fault.chainage_m, fault.length_m / 2, length_m);
}

void CheckOffset(double offset_m, const char* field) {
  Want(offset_m >= 0.0 && offset_m <= kDeepest_m, field,
       fmt::format("{:.6g} must be between 0 and {:.0f}", offset_m * 1000, kDeepest_m * 1000));
}

/// The centre line, or the flaw that there can be none.
PipeAxis AxisOf(const Pipe& pipe, const ShaftEnd& upstream, const ShaftEnd& downstream) {
  const char* field = pipe.bends.empty() ? "to" : "bends";
  try {
    if (!LiesAsDesigned(pipe)) {
      (void)DesignLength(upstream, downstream, pipe);
      field = pipe.joints.empty() ? "diameter_changes" : "joints";
    }
    return {upstream, downstream, pipe};
  } catch (const std::invalid_argument& error) {
    throw Flaw(field, error.what());
  }
}

/// Sizes of what the whole pipe has.
void CheckBody(const Pipe& pipe) {
  CheckName(pipe.name);
  WantMillimetres(pipe.diameter_m, 0.0, kLargestDiameter_m, "diameter_mm");
  CheckOffset(pipe.upstream_offset_m, "from_offset_mm");
  CheckOffset(pipe.downstream_offset_m, "to_offset_mm");
  CheckJoints(pipe);
  CheckDiameterChanges(pipe);
  CheckSags(pipe);
  double narrowest_m = pipe.diameter_m, widest_m = pipe.diameter_m;
  for (const DiameterChange& change : pipe.diameter_changes) {
    narrowest_m = std::min(narrowest_m, change.diameter_m);
    widest_m = std::max(widest_m, change.diameter_m);
  }
  WantBelow(pipe.water_m, narrowest_m, "water_mm", "the pipe's diameter");
  ForEach("bends", pipe.bends, [&](const Bend& bend) {
    Want(bend.p_W.allFinite() && bend.p_W.cwiseAbs().maxCoeff() <= kFarthest_m, "at_m",
         fmt::format("coordinates must lie within {:.0f} m of the origin", kFarthest_m));
    WantMillimetres(bend.radius_m, widest_m / 2, kLongestPipe_m, "radius_mm");
  });
}

void CheckReference(const std::map<std::string_view, std::string>& manholes,
                    const std::string& manhole, const char* field) {
  Want(manholes.count(manhole) == 1, field, fmt::format("no manhole is named \"{}\"", manhole));
}

/// Names and references, without which nothing else can be looked at.
void CheckNames(const Network& network) {
  CheckName(network.name);
  Want(!network.pipes.empty(), "pipes", "a network has at least one pipe");
  std::map<std::string_view, std::string> manholes, pipes, inlets, obstacles, faults;
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    Inside("manholes", i, [&] {
      CheckUnique(manholes, network.manholes[i].name, fmt::format("manholes[{}]", i));
    });
  }
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const Pipe& pipe = network.pipes[i];
    Inside("pipes", i, [&] {
      CheckUnique(pipes, pipe.name, fmt::format("pipes[{}]", i));
      CheckReference(manholes, pipe.upstream, "from");
      CheckReference(manholes, pipe.downstream, "to");
      Want(pipe.upstream != pipe.downstream, "to", "a pipe joins two different manholes");
      ForEach("inlets", pipe.inlets, [&](const Inlet& inlet) {
        CheckUnique(inlets, inlet.name, "an inlet of pipe " + pipe.name);
      });
      ForEach("obstacles", pipe.obstacles, [&](const Obstacle& obstacle) {
        CheckUnique(obstacles, obstacle.name, "an obstacle in pipe " + pipe.name);
      });
      ForEach("faults", pipe.faults, [&](const Fault& fault) {
        CheckUnique(faults, fault.name, "a fault in pipe " + pipe.name);
      });
    });
  }
}

}  // namespace

bool IsUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t tail = lead < 0x80                   ? 0
                             : lead >= 0xC2 && lead < 0xE0 ? 1
                             : (lead & 0xF0) == 0xE0       ? 2
                             : lead >= 0xF0 && lead < 0xF5 ? 3
                                                           : 4;
    if (tail == 4 || text.size() - i <= tail) return false;
    for (std::size_t k = 1; k <= tail; ++k) {
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0) != 0x80) return false;
    }
    i += tail + 1;
  }
  return true;
}

void CheckPipe(const Pipe& pipe, const ShaftEnd& upstream, const ShaftEnd& downstream) {
  CheckBody(pipe);
  const double length_m = AxisOf(pipe, upstream, downstream).length_m();
  Want(length_m <= kLongestPipe_m, "to",
       fmt::format("the pipe is {:.0f} m long, more than {:.0f} m", length_m, kLongestPipe_m));
  CheckLaidWithin(pipe, length_m);
  ForEach("inlets", pipe.inlets, [&](const Inlet& inlet) { CheckInlet(inlet, pipe, length_m); });
  ForEach("obstacles", pipe.obstacles,
          [&](const Obstacle& obstacle) { CheckObstacle(obstacle, pipe, length_m); });
  ForEach("faults", pipe.faults, [&](const Fault& fault) { CheckFault(fault, pipe, length_m); });
}

void CheckNetwork(const Network& network) {
  CheckNames(network);
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    Inside("manholes", i, [&] { CheckManhole(network.manholes[i]); });
  }
  const NetworkIndex index(network);
  std::size_t joints = 0;
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    const Pipe& pipe = network.pipes[i];
    const std::size_t up = index.upstream[i], down = index.downstream[i];
    Inside("pipes", i, [&] {
      CheckPipe(pipe, EndAt(network, index, up), EndAt(network, index, down));
      joints += pipe.joints.size();
      Want(joints <= kMostJoints, "joints",
           fmt::format("a network has at most {} joints", kMostJoints));
    });
    Inside("manholes", up, [&] { CheckFit(network.manholes[up], pipe, pipe.upstream_offset_m); });
    Inside("manholes", down,
           [&] { CheckFit(network.manholes[down], pipe, pipe.downstream_offset_m); });
  }
}

void Check(const Network& network, const std::filesystem::path& name) {
  try {
    CheckNetwork(network);
  } catch (const Flaw& flaw) {
    throw InputError(name, std::nullopt, flaw.field, flaw.what());
  }
}

}  // namespace kantaro::network
