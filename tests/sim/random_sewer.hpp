#pragma once

#include <cstdint>

#include "network/network.hpp"

namespace kantaro::sim {

/// A checked network around one manhole, with up to `most_pipes` short pipes of any size and all
/// that may be in them: joints that have moved, steps, bends, sags, inlets, obstacles; any floor.
[[nodiscard]] network::Network RandomNetwork(std::uint64_t seed, int most_pipes);

}  // namespace kantaro::sim
