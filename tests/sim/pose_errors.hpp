#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kantaro::sim {

/// How far the contact function is from sampled geometry, over random poses in random sewers [m].
struct PoseErrors {
  std::vector<double> near;    ///< of spheres whose middle lies within 20 mm of the wall: sizes
  std::vector<double> far;     ///< within 20 to 60 mm: signed, positive where contact says too much
  std::vector<double> wheels;  ///< sizes
  double worst_size{};
  std::string worst;  ///< its seed and place, for a person to look at
};

/// @param sewers  random networks of `first_seed` and on; half of the poses are spheres.
[[nodiscard]] PoseErrors MeasurePoseErrors(std::uint64_t first_seed, int sewers, int poses_each);

/// The value that so large a share of the sizes stays below.
[[nodiscard]] double Quantile(std::vector<double> values, double share);

}  // namespace kantaro::sim
