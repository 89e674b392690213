#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "sim/sewer.hpp"

namespace kantaro::sim {

/// A sewer measured without reckoning: its surfaces are sampled densely, tests of membership say
/// what is ground, and the distance to the wall is that to the nearest sample, moved about on its
/// surface as long as it comes nearer. It shares no formula with VoidField.
class SampledSewer {
 public:
  explicit SampledSewer(const Sewer& sewer, double spacing_m = 0.004);

  [[nodiscard]] bool IsFree(const Eigen::Vector3d& p_W) const;
  /// From a free point; no more than `reach_m`, which is at most 0.1.
  [[nodiscard]] double Distance(const Eigen::Vector3d& p_W, double reach_m) const;
  /// The same to the nearest sample alone: too far by up to half a spacing near edges.
  [[nodiscard]] double Roughly(const Eigen::Vector3d& p_W, double reach_m) const;
  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  [[nodiscard]] Eigen::Vector3d Sample(std::size_t index) const;

 private:
  /// One smooth piece of a primitive's surface, over two parameters of about a metre's scale.
  struct Patch {
    std::uint32_t primitive{};  ///< voids first, then solids
    int face{};
    double u_m[2]{}, v_m[2]{};
  };
  struct Place {
    std::uint32_t patch{};
    float u{}, v{};
    Eigen::Vector3f p{};  ///< from the first manhole
  };
  void AddPatches(std::uint32_t primitive);
  [[nodiscard]] std::optional<Eigen::Vector3d> GroundAt(const Patch& patch, double u,
                                                        double v) const;
  [[nodiscard]] Eigen::Vector3d PointOn(const Patch& patch, double u, double v) const;
  [[nodiscard]] std::vector<std::uint32_t> Near(const Eigen::Vector3d& p_W, double reach_m) const;

  const Sewer& sewer_;
  double spacing_m_;
  Eigen::Vector3d origin_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<Patch> patches_;
  std::vector<Place> samples_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace kantaro::sim
