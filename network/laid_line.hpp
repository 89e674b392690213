#pragma once

#include <vector>

#include "network/network.hpp"
#include "network/pipe_axis.hpp"

namespace kantaro::network {

/// Whether nothing displaces a pipe's centre line from its design.
[[nodiscard]] bool LiesAsDesigned(const Pipe& pipe);

/// By how much the diameter changes of a pipe raise its axis in all, square to it [m].
[[nodiscard]] double TotalStep(const Pipe& pipe);

/// The centre line as laid (see PipeAxis) for a pipe whose joints, sags and diameter changes stand
/// in the order of chainage.
/// @param design  pieces of the design line, at least one
/// @param end_m   where on the design line, going on straight, the pipe ends, > 0
/// @throws std::invalid_argument if a length leaves the design line by more than kSteepestLength or
///         comes near the centre of a bend.
[[nodiscard]] std::vector<AxisPiece> LayLengths(const std::vector<AxisPiece>& design, double end_m,
                                                const Pipe& pipe);

}  // namespace kantaro::network
