#pragma once

#include <cstdint>
#include <vector>

#include "network/network.hpp"
#include "network/pipe_axis.hpp"
#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// What a void belongs to.
struct Part {
  enum class Kind : std::uint8_t { kPipe, kManhole };
  Kind kind{Kind::kPipe};
  std::size_t index{};  ///< into the network's pipes or manholes
};

/// A network as geometry: the union of voids from which contact, the render mesh and the ray-cast
/// mesh all come.
struct Sewer {
  network::Network network;
  std::vector<network::PipeAxis> axes;  ///< one for each pipe
  std::vector<Part> parts;              ///< VoidPrimitive::part points here
  std::vector<VoidPrimitive> voids;
};

/// Builds the voids of a checked network. @throws std::invalid_argument if pipes do not fit their
/// shafts.
[[nodiscard]] Sewer BuildSewer(const network::Network& network);

}  // namespace kantaro::sim
