#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "network/generator.hpp"

namespace kantaro::network {

/// A network from above. Edges stand in an order of growth: each starts or ends at a node that an
/// earlier one reached, so that any first few make a whole. In a forest edge k leads down from
/// node k + 1.
struct Plan {
  /// A pipe from above, drawn towards the outfall.
  struct Edge {
    std::size_t up{}, down{};
    std::optional<Eigen::Vector2d> corner;
  };
  std::vector<Eigen::Vector2d> nodes;
  std::vector<Edge> edges;
};

/// That the shafts of 200 mm pipes and some larger take of an edge.
inline constexpr double kShafts_m = 0.75;

[[nodiscard]] inline double Centimetres(double value_m) {
  return std::round(value_m * 100.0) / 100.0;
}

/// Between the manholes' middles, round the corner.
[[nodiscard]] double Length(const Plan& plan, const Plan::Edge& edge);

/// Lays manholes and pipes out in the plane, as many or as long as is wanted.
[[nodiscard]] Plan MakePlan(const GeneratorOptions& options);

}  // namespace kantaro::network
