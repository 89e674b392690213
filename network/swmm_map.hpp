#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "network/swmm_model.hpp"

namespace kantaro::network::swmm {

/// From the units in which a model is drawn to metres around the drawing's middle. Many models are
/// drawn in other units than their conduits' lengths: if these are more than 5 % off at the median,
/// the drawing is scaled by it. Degrees are projected on the plane that touches WGS 84 in the
/// middle: a town's distances come out within 0.2 %.
class MapFrame {
 public:
  /// Adds a remark on everything it does to `model`'s. @throws InputError (file `file`) for
  /// degrees that are none.
  MapFrame(Model& model, const std::filesystem::path& file);

  [[nodiscard]] Eigen::Vector2d Exactly(const Eigen::Vector2d& drawn) const {
    return (drawn - middle_).cwiseProduct(metres_per_unit_);
  }
  /// To the millimetre.
  [[nodiscard]] Eigen::Vector2d ToWorld(const Eigen::Vector2d& drawn) const;

 private:
  void Project(Model& model, const std::filesystem::path& file);
  void ScaleToLengths(Model& model);

  Eigen::Vector2d middle_{Eigen::Vector2d::Zero()};
  Eigen::Vector2d metres_per_unit_{Eigen::Vector2d::Ones()};
};

/// Along the vertices from node to node [m], absent if one is not drawn.
[[nodiscard]] std::optional<double> DrawnLength(const Model& model, const MapFrame& frame,
                                                const Link& link);

}  // namespace kantaro::network::swmm
