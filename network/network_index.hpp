#pragma once

#include <cstddef>
#include <map>
#include <string_view>
#include <vector>

#include "network/network.hpp"

namespace kantaro::network {

/// Names of a network resolved once, for whoever walks over all of it: O(n log n) to make.
/// Refers to the network's names: do not outlive it or change it meanwhile.
class NetworkIndex {
 public:
  /// @throws std::out_of_range if a pipe names an unknown manhole.
  explicit NetworkIndex(const Network& network);

  std::map<std::string_view, std::size_t> manholes;  ///< by name
  std::vector<std::size_t> upstream;                 ///< manhole of each pipe
  std::vector<std::size_t> downstream;               ///< likewise
  std::vector<std::vector<std::size_t>> pipes_at;    ///< of each manhole, in the order of the pipes
  std::vector<double> shaft_diameter_m;              ///< of each manhole, given or by default
};

}  // namespace kantaro::network
