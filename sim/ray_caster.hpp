#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "sim/surface_mesh.hpp"

namespace kantaro::sim {

/// A half line in the world.
struct Ray {
  Eigen::Vector3d p_WR{Eigen::Vector3d::Zero()};          ///< origin [m]
  Eigen::Vector3d direction_W{Eigen::Vector3d::UnitX()};  ///< unit
};

/// Where a ray meets the wall.
struct RayHit {
  double range_m{};          ///< along the ray
  Eigen::Vector3d normal_W;  ///< of the true surface there, unit, into the void
  std::uint32_t owner{};     ///< number of the primitive whose wall it is, as in SurfaceMesh
};

/// Finds the nearest wall along a ray (Embree); none slips through where triangles meet.
/// Both sides of the wall count: a ray that starts in the ground hits it from behind, and then
/// normal · direction > 0. The mesh is kept in single precision about its middle: to 4 µm
/// within 50 m of it, 0.1 mm within 1 km; of a whole city, give it the part around the robot
/// (Extract). Holds its own copy of the mesh. Casting is const and may go on in many threads at
/// once; one mesh and one ray give the same hit to the bit, whichever instructions the processor
/// has.
class RayCaster {
 public:
  /// @param instructions  to use, by Embree's name ("sse2", "avx2"); null: the best there are.
  /// Decides speed, never a hit.
  /// @throws std::runtime_error if Embree cannot be started or runs out of memory
  explicit RayCaster(const SurfaceMesh& mesh, const char* instructions = nullptr);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// Absent if there is no wall within max_range_m.
  [[nodiscard]] std::optional<RayHit> Cast(const Eigen::Vector3d& p_WR,
                                           const Eigen::Vector3d& direction_W,
                                           double max_range_m) const;

  /// hits[i] answers rays[i]. @throws std::invalid_argument if the spans differ in length
  void Cast(std::span<const Ray> rays, double max_range_m,
            std::span<std::optional<RayHit>> hits) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace kantaro::sim
