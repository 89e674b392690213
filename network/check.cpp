#include "network/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "base/input_error.hpp"
#include "network/formats.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {
namespace {

constexpr double kFarthest_m = 1e7;  // a millimetre is still exact there
constexpr double kLargestDiameter_m = 10.0;
constexpr double kLargestShaft_m = 50.0;
constexpr double kDeepest_m = 500.0;
constexpr double kLongestPipe_m = 20'000.0;
constexpr double kLargestGap_m = 0.2;

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

/// Runs a check of a part and puts the part's place before what it complains of.
template <typename Function>
void Inside(const char* list, std::size_t index, Function&& check) {
  try {
    check();
  } catch (const Flaw& flaw) {
    throw Flaw(fmt::format("{}[{}].{}", list, index, flaw.field), flaw.what());
  }
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
  if (manhole.shaft_diameter_m) {
    WantMillimetres(*manhole.shaft_diameter_m, 0.0, kLargestShaft_m, "shaft_diameter_mm");
  }
  if (manhole.channel_radius_m) {
    WantMillimetres(*manhole.channel_radius_m, 0.0, kLargestShaft_m, "channel_radius_mm");
  }
}

/// What the pipes that meet in a manhole demand of it.
void CheckFit(const Manhole& manhole, const Pipe& pipe, double offset_m) {
  Want(!manhole.shaft_diameter_m || *manhole.shaft_diameter_m > pipe.diameter_m,
       "shaft_diameter_mm",
       fmt::format("the shaft must be wider than pipe \"{}\" ({:.6g} mm)", pipe.name,
                   pipe.diameter_m * 1000));
  Want(!manhole.channel_radius_m || *manhole.channel_radius_m > pipe.diameter_m / 2,
       "channel_radius_mm",
       fmt::format("the channel's radius must be above half of pipe \"{}\" ({:.6g} mm)", pipe.name,
                   pipe.diameter_m * 500));
  Want(manhole.depth_m >= offset_m + pipe.diameter_m, "depth_m",
       fmt::format("the crown of pipe \"{}\" lies {:.3f} m above the invert, higher than the cover "
                   "at {:.3f} m",
                   pipe.name, offset_m + pipe.diameter_m, manhole.depth_m));
}

void CheckJoints(const Pipe& pipe, double length_m) {
  double end_of_last_m = 0.0;
  for (std::size_t i = 0; i < pipe.joints.size(); ++i) {
    const Joint& joint = pipe.joints[i];
    Inside("joints", i, [&] {
      WantMillimetres(joint.gap_m, 0.0, kLargestGap_m, "gap_mm");
      WantMillimetres(joint.depth_m, 0.0, kLargestGap_m, "depth_mm");
      const double half_m = joint.gap_m / 2;
      Want(joint.chainage_m - half_m >= 0.0 && joint.chainage_m + half_m <= length_m, "at_m",
           fmt::format("{:.6g} lies outside the pipe, which is {:.3f} m long between its shafts",
                       joint.chainage_m, length_m));
      Want(joint.chainage_m - half_m >= end_of_last_m, "at_m",
           "joints stand in the order of chainage and do not overlap");
      end_of_last_m = joint.chainage_m + half_m;
    });
  }
}

void CheckClock(double clock_h) { WantWithin(clock_h, 0.0, 12.0, "clock"); }

void CheckInside(double chainage_m, double half_m, double length_m) {
  Want(chainage_m - half_m >= 0.0 && chainage_m + half_m <= length_m, "at_m",
       fmt::format("{:.6g} ± {:.3f} m reaches outside the pipe, which is {:.3f} m long between its "
                   "shafts",
                   chainage_m, half_m, length_m));
}

void CheckInlet(const Inlet& inlet, const Pipe& pipe, double length_m) {
  CheckName(inlet.name);
  Want(inlet.diameter_m > 0.0 && inlet.diameter_m < pipe.diameter_m, "diameter_mm",
       fmt::format("{:.6g} must be above 0 and less than the pipe's {:.6g}",
                   inlet.diameter_m * 1000, pipe.diameter_m * 1000));
  CheckClock(inlet.clock_h);
  CheckInside(inlet.chainage_m, inlet.diameter_m / 2, length_m);
}

void CheckFault(const Fault& fault, const Pipe& pipe, double length_m) {
  CheckName(fault.name);
  CheckClock(fault.clock_h);
  WantMillimetres(fault.length_m, 0.0, length_m, "length_mm");
  WantMillimetres(fault.width_m, 0.0, std::numbers::pi * pipe.diameter_m, "width_mm");
  CheckInside(fault.chainage_m, fault.length_m / 2, length_m);
}

void CheckOffset(double offset_m, const char* field) {
  Want(offset_m >= 0.0 && offset_m <= kDeepest_m, field,
       fmt::format("{:.6g} must be between 0 and {:.0f}", offset_m * 1000, kDeepest_m * 1000));
}

/// The centre line, or the flaw that there can be none.
PipeAxis AxisOf(const Pipe& pipe, const ShaftEnd& upstream, const ShaftEnd& downstream) {
  try {
    return {upstream, downstream, pipe};
  } catch (const std::invalid_argument& error) {
    throw Flaw(pipe.bends.empty() ? "to" : "bends", error.what());
  }
}

void CheckReference(const std::map<std::string_view, std::string>& manholes,
                    const std::string& manhole, const char* field) {
  Want(manholes.count(manhole) == 1, field, fmt::format("no manhole is named \"{}\"", manhole));
}

/// Names and references, without which nothing else can be looked at.
void CheckNames(const Network& network) {
  CheckName(network.name);
  Want(!network.pipes.empty(), "pipes", "a network has at least one pipe");
  std::map<std::string_view, std::string> manholes, pipes, inlets, faults;
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
      for (std::size_t k = 0; k < pipe.inlets.size(); ++k) {
        Inside("inlets", k,
               [&] { CheckUnique(inlets, pipe.inlets[k].name, "an inlet of pipe " + pipe.name); });
      }
      for (std::size_t k = 0; k < pipe.faults.size(); ++k) {
        Inside("faults", k,
               [&] { CheckUnique(faults, pipe.faults[k].name, "a fault in pipe " + pipe.name); });
      }
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
  CheckName(pipe.name);
  WantMillimetres(pipe.diameter_m, 0.0, kLargestDiameter_m, "diameter_mm");
  CheckOffset(pipe.upstream_offset_m, "from_offset_mm");
  CheckOffset(pipe.downstream_offset_m, "to_offset_mm");
  for (std::size_t i = 0; i < pipe.bends.size(); ++i) {
    Inside("bends", i, [&] {
      const Bend& bend = pipe.bends[i];
      Want(bend.p_W.allFinite() && bend.p_W.cwiseAbs().maxCoeff() <= kFarthest_m, "at_m",
           fmt::format("coordinates must lie within {:.0f} m of the origin", kFarthest_m));
      WantMillimetres(bend.radius_m, pipe.diameter_m / 2, kLongestPipe_m, "radius_mm");
    });
  }
  const double length_m = AxisOf(pipe, upstream, downstream).length_m();
  Want(length_m <= kLongestPipe_m, "to",
       fmt::format("the pipe is {:.0f} m long, more than {:.0f} m", length_m, kLongestPipe_m));
  CheckJoints(pipe, length_m);
  for (std::size_t i = 0; i < pipe.inlets.size(); ++i) {
    Inside("inlets", i, [&] { CheckInlet(pipe.inlets[i], pipe, length_m); });
  }
  for (std::size_t i = 0; i < pipe.faults.size(); ++i) {
    Inside("faults", i, [&] { CheckFault(pipe.faults[i], pipe, length_m); });
  }
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
