#pragma once

#include <cstdint>
#include <vector>

#include "network/network.hpp"
#include "network/pipe_axis.hpp"
#include "sim/solid_primitive.hpp"
#include "sim/void_primitive.hpp"

namespace kantaro::sim {

/// What a void belongs to.
struct Part {
  enum class Kind : std::uint8_t { kPipe, kManhole };
  Kind kind{Kind::kPipe};
  std::size_t index{};  ///< into the network's pipes or manholes
};

/// A network as geometry: the union of voids, less the solids in them, from which contact, the
/// render mesh and the ray-cast mesh all come.
struct Sewer {
  network::Network network;
  std::vector<network::PipeAxis> axes;  ///< one for each pipe
  std::vector<Part> parts;              ///< VoidPrimitive::part points here
  std::vector<VoidPrimitive> voids;
  std::vector<SolidPrimitive> solids;
};

/// Slope at which the ends of a sediment bed lie, rise over run: sand's angle of repose under water
/// is 32° (R. Soulsby, Dynamics of Marine Sands, 1997, section 6.4).
inline constexpr double kReposeSlope = 0.62487;
/// Wall of an inlet's pipe where it stands into the main, in inner diameters: PVC-U of SDR 34
/// (EN 1401-1).
inline constexpr double kStubWallRatio = 1.0 / 32.0;

/// Builds the voids and solids of a checked network. Tubes reach so far into a round shaft that no
/// wall is left between their flat ends and the shaft. Where two pipes' channel cannot be rounded
/// in the shaft (wide pipes, sharp turns), it is mitred.
/// @throws std::invalid_argument if pipes do not fit their shafts.
[[nodiscard]] Sewer BuildSewer(const network::Network& network);

}  // namespace kantaro::sim
