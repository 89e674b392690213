#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "network/network.hpp"
#include "network/swmm_text.hpp"

// What an EPA SWMM file describes, in metres where the file gives lengths, in the map's own units
// where it draws.
namespace kantaro::network::swmm {

enum class MapUnits { kNone, kFeet, kMetres, kDegrees };

struct Options {
  double unit_m{};  ///< length of the file's unit
  bool offsets_are_elevations{};
  MapUnits map_units{MapUnits::kNone};
};

struct Node {
  std::string name;
  int line{};
  double elevation_m{};
  double depth_m{};  ///< 0: not given
  bool is_storage{};
  std::optional<Eigen::Vector2d> drawn;  ///< map units
};

struct Link {
  std::string name, from, to;
  int line{};
  std::string device;  ///< "a pump" ...; empty for a conduit
  double length_m{};   ///< as stated, of a conduit
  double roughness{};  ///< Manning's n
  double from_offset_m{}, to_offset_m{};
  std::string shape;  ///< of a conduit, in capitals
  double height_m{};  ///< 0: not known
  double barrels{1.0};
  std::vector<Eigen::Vector2d> vertices;  ///< map units
};

struct Model {
  Options options;
  std::vector<Node> nodes;
  std::map<std::string, std::size_t, std::less<>> node_of;
  std::vector<Link> links;  ///< conduits first
  std::map<std::string, std::size_t, std::less<>> link_of;
  std::vector<Remark> remarks;  ///< on what was filled in or left out

  /// Null if the node is not defined or has no coordinates.
  [[nodiscard]] const Node* Drawn(std::string_view node) const;
};

/// @throws InputError for what makes no model, or the trace of a file cut short.
[[nodiscard]] Model ReadModel(const Text& text, std::string_view whole,
                              const std::filesystem::path& file);

/// To the nearest millimetre, as the decimal number that a person would write.
[[nodiscard]] double ToMillimetres(double value_m);

}  // namespace kantaro::network::swmm
