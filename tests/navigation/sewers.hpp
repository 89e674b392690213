#pragma once

#include <string>
#include <utility>

#include "network/network.hpp"

namespace kantaro::navigation {

inline network::Manhole ManholeAt(std::string name, double x_m, double y_m) {
  network::Manhole manhole;
  manhole.name = std::move(name);
  manhole.p_WM = {x_m, y_m, 0.0};
  return manhole;
}

/// 300 mm, so that the shafts are 800 mm wide: 400 mm from a manhole's centre to the wall.
inline network::Pipe PipeFrom(std::string name, std::string upstream, std::string downstream) {
  network::Pipe pipe;
  pipe.name = std::move(name);
  pipe.upstream = std::move(upstream);
  pipe.downstream = std::move(downstream);
  pipe.diameter_m = 0.3;
  return pipe;
}

inline constexpr double kShaftRadius_m = 0.4;
/// Of the centre line of a curved channel: 0.66 of the shaft's radius (docs/network_format.md).
inline constexpr double kChannelRadius_m = 0.66 * kShaftRadius_m;

/// Seen from above, water flowing away from A; every pipe 7.2 m from wall to wall.
///
///               C
///               | P3
///   A ---P1--- M ---P2--- B ---P4--- E          x to the right, y up
///
/// M is a tee, B a straight manhole.
inline network::Network TeeField() {
  network::Network network;
  network.name = "tee field";
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("M", 8, 0), ManholeAt("B", 16, 0),
                      ManholeAt("C", 8, 8), ManholeAt("E", 24, 0)};
  network.pipes = {PipeFrom("P1", "A", "M"), PipeFrom("P2", "M", "B"), PipeFrom("P3", "M", "C"),
                   PipeFrom("P4", "B", "E")};
  return network;
}

/// Two pipes of 7.2 m with a left turn of 90° at M.
inline network::Network Curve() {
  network::Network network;
  network.name = "curve";
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("M", 8, 0), ManholeAt("C", 8, 8)};
  network.pipes = {PipeFrom("P1", "A", "M"), PipeFrom("P2", "M", "C")};
  return network;
}

/// A ring of pipes round a block, entered from A; T is a tee.
///
///        Y ---- Z
///        |      |
///   A -- T ---- X
inline network::Network Block() {
  network::Network network;
  network.name = "block";
  network.manholes = {ManholeAt("A", 0, 0), ManholeAt("T", 8, 0), ManholeAt("X", 16, 0),
                      ManholeAt("Y", 8, 8), ManholeAt("Z", 16, 8)};
  network.pipes = {PipeFrom("AT", "A", "T"), PipeFrom("TX", "T", "X"), PipeFrom("XZ", "X", "Z"),
                   PipeFrom("ZY", "Z", "Y"), PipeFrom("YT", "Y", "T")};
  return network;
}

}  // namespace kantaro::navigation
