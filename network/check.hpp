#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "network/network.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::network {

/// What is wrong with a network, and where, in the words of its YAML format:
/// "pipes[3].inlets[0].at_m". Readers turn it into an InputError with their file and line; it does
/// not leave this room.
struct Flaw : std::runtime_error {
  Flaw(std::string where, const std::string& problem)
      : std::runtime_error(problem), field(std::move(where)) {}
  std::string field;
};

/// Shortest length between regular joints [m], and most joints of a network: more is a slip of the
/// pen.
inline constexpr double kShortestSpacing_m = 0.2;
inline constexpr double kLargestDiameter_m = 10.0;
inline constexpr std::size_t kLongestName = 200;  // bytes
inline constexpr std::size_t kMostJoints = 10'000'000;

/// References, names, sizes and geometry of everything. @throws Flaw for the first that is wrong.
void CheckNetwork(const Network& network);
[[nodiscard]] bool IsUtf8(std::string_view text);
/// One pipe, its fields relative to it ("joints[2].at_m"). @throws Flaw
void CheckPipe(const Pipe& pipe, const ShaftEnd& upstream, const ShaftEnd& downstream);

}  // namespace kantaro::network
