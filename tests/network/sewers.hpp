#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "network/network.hpp"

namespace kantaro::network {

inline Manhole ManholeAt(std::string name, double x_m, double y_m, double z_m = 0.0) {
  Manhole manhole;
  manhole.name = std::move(name);
  manhole.p_WM = {x_m, y_m, z_m};
  return manhole;
}

inline Pipe PipeFrom(std::string name, std::string upstream, std::string downstream,
                     double diameter_m = 0.3) {
  Pipe pipe;
  pipe.name = std::move(name);
  pipe.upstream = std::move(upstream);
  pipe.downstream = std::move(downstream);
  pipe.diameter_m = diameter_m;
  return pipe;
}

/// A 300 mm pipe "P" from "A" at the origin to "B" at (10, 0), level; shafts of 800 mm.
inline Network OnePipe() {
  Network network;
  network.name = "one pipe";
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("B", 10, 0)};
  network.pipes = {PipeFrom("P", "A", "B")};
  return network;
}

/// A chain of pipes over manholes that stand 12 to 30 m apart, with chance numbers in everything.
Network RandomSewer(std::uint64_t seed);

}  // namespace kantaro::network
