#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "network/network.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {

/// Kinds of manhole by the pipes that meet in it (thesis 4.2, fig 4.1).
enum class ManholeKind { kEnd, kStraight, kCurve, kTee, kCross, kOther };

/// Two pipes within 15° of one line make a straight manhole, otherwise a curve; three make a tee,
/// four a cross.
[[nodiscard]] ManholeKind KindOf(const Network& network, const Manhole& manhole);
/// The same for a whole network, without looking names up again. @param manhole  its position.
[[nodiscard]] ManholeKind KindOf(const Network& network, const NetworkIndex& index,
                                 std::size_t manhole);
[[nodiscard]] std::string ToString(ManholeKind kind);

/// Horizontal unit direction in which a pipe leaves a manhole it is connected to.
[[nodiscard]] Eigen::Vector2d DirectionFrom(const Network& network, const Pipe& pipe,
                                            const Manhole& manhole);

/// One pipe of a route and the way it is driven.
struct RouteLeg {
  std::string pipe;
  bool downstream{true};  ///< from the pipe's upstream manhole to its downstream one
};

/// Shortest way over enterable pipes from one manhole to another; empty if there is none or they
/// are the same. @throws std::out_of_range for unknown names.
[[nodiscard]] std::vector<RouteLeg> ShortestRoute(const Network& network, const std::string& from,
                                                  const std::string& to);

/// The part of a network around some manholes: every pipe with an end within a walking distance [m]
/// of one of them, over pipes of any size, and the manholes it ends in. Shafts keep the diameter
/// they have in the whole.
/// @throws std::out_of_range for unknown names.
[[nodiscard]] Network Neighbourhood(const Network& network,
                                    const std::vector<std::string>& manholes, double reach_m);

}  // namespace kantaro::network
