#include "network/joints.hpp"

namespace kantaro::network {

std::vector<Joint> LayJoints(const JointPattern& pattern, double pipe_length_m) {
  std::vector<Joint> joints;
  const double last_m = pipe_length_m - pattern.spacing_m / 4;
  for (int i = 0;; ++i) {
    const double chainage_m = pattern.first_m + i * pattern.spacing_m;
    if (chainage_m > last_m) return joints;
    joints.push_back({chainage_m, pattern.gap_m, pattern.depth_m});
  }
}

}  // namespace kantaro::network
