#pragma once

#include <vector>

#include "network/network.hpp"

namespace kantaro::network {

/// Joints of a pipe laid from lengths of one size.
struct JointPattern {
  double first_m{};       ///< chainage of the first joint
  double spacing_m{};     ///< from joint to joint, > 0
  double gap_m{0.008};    ///< as in Joint
  double depth_m{0.006};  ///< as in Joint
};

/// The joints at first + k · spacing, up to a quarter of the spacing before the pipe's end: a
/// shorter stub is never laid.
[[nodiscard]] std::vector<Joint> LayJoints(const JointPattern& pattern, double pipe_length_m);

}  // namespace kantaro::network
