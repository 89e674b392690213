#pragma once

#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "network/network.hpp"
#include "network/network_index.hpp"

namespace kantaro::network {

/// Kinds of manhole by the pipes that meet in it (thesis 4.2, fig 4.1).
enum class ManholeKind { kEnd, kStraight, kCurve, kTee, kWye, kCross, kOther };

/// Two pipes within 15° of one line make a straight manhole, otherwise a curve. Three make a tee if
/// two of them run straight through (within 15°) and the third leaves within 30° of square to
/// these, otherwise a wye. Four make a cross.
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

/// The sharpest turn in a manhole that a channel is built for, and that KANTARO makes.
inline constexpr double kSharpestTurn_rad = 120.0 * std::numbers::pi / 180.0;

/// How far one turns in a manhole, arriving by one of its pipes and leaving by another [rad]:
/// positive to the left, −π to π.
[[nodiscard]] double TurnInto(const Network& network, const Manhole& manhole, const Pipe& arriving,
                              const Pipe& leaving);

enum class Turns { kDrivable, kAny };

/// Shortest way over enterable pipes that passes these manholes in this order, turning in none by
/// more than kSharpestTurn_rad unless `turns` is kAny; it may well take a detour to turn round.
/// Empty if there is none or the manholes are all the same. Of equally short ways it is the same
/// one on every machine. @throws std::out_of_range for unknown names.
[[nodiscard]] std::vector<RouteLeg> ShortestRoute(const Network& network,
                                                  const std::vector<std::string>& manholes,
                                                  Turns turns = Turns::kDrivable);

/// Manhole at which a leg ends.
[[nodiscard]] const std::string& EndOf(const Network& network, const RouteLeg& leg);

/// The part of a network around some manholes: every pipe with an end within a walking distance [m]
/// of one of them, over pipes of any size, and the manholes it ends in. Shafts keep the diameter
/// they have in the whole.
/// @throws std::out_of_range for unknown names.
[[nodiscard]] Network Neighbourhood(const Network& network,
                                    const std::vector<std::string>& manholes, double reach_m);

}  // namespace kantaro::network
