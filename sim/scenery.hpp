#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/sewer.hpp"
#include "sim/surface_mesh.hpp"
#include "sim/water_sheet.hpp"

namespace kantaro::sim {

struct SceneryOptions {
  std::uint64_t seed{1};         ///< of stains, scratches and tones
  double texture_contrast{1.0};  ///< 0 clean and smooth … 1 a used sewer … 2 filthy
  double chunk_length_m{
      1.0};  ///< walls are cut to this along the axis, so that only near ones are drawn
};

/// Everything that cameras see of a sewer: walls, joints, shafts and faults with their looks, as a
/// MuJoCo model of visual meshes alone. Immutable: any number of renderers on any threads may draw
/// it.
class Scenery {
 public:
  /// @throws std::invalid_argument if the mesh is not the sewer's. @throws MujocoError
  Scenery(const Sewer& sewer, const SurfaceMesh& mesh, const SceneryOptions& options = {});

  /// One piece of the scene, placed absolutely; renderers draw it relative to their camera.
  struct Piece {
    mjvGeom geom{};                                      ///< ready to draw but for its position
    Eigen::Vector3d p_WG{Eigen::Vector3d::Zero()};       ///< of the geom's frame
    Eigen::Vector3d p_WCentre{Eigen::Vector3d::Zero()};  ///< of a sphere around it
    double radius_m{};
    int triangle_count{};
  };

  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<WaterSheet>& water() const { return water_; }

 private:
  struct Deleter {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
  };
  std::unique_ptr<mjModel, Deleter> model_;
  std::vector<Piece> pieces_;
  std::vector<WaterSheet> water_;
};

}  // namespace kantaro::sim
