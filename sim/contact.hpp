#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "sim/void_field.hpp"

namespace kantaro::sim {

/// A body shape that touches the wall.
struct WallContact {
  double distance_m{};                                ///< negative where it overlaps the wall
  Eigen::Vector3d p_WC{Eigen::Vector3d::Zero()};      ///< midway between the two surfaces
  Eigen::Vector3d normal_W{Eigen::Vector3d::Zero()};  ///< from the wall into the void
};

/// At most this many contacts of one shape, deepest first. A wheel's normals differ by more than
/// 25° (it stands in a groove on two sides, but one side is one contact); a box' contacts may also
/// lie apart along it.
inline constexpr std::size_t kMostContacts = 8;

/// A wheel: the points within `tread_m` of a circle of `ring_m` about an axis.
struct Torus {
  Eigen::Vector3d p_WT{Eigen::Vector3d::Zero()};
  Eigen::Vector3d axis_W{Eigen::Vector3d::UnitZ()};  ///< unit
  double ring_m{};
  double tread_m{};
};

/// Contacts nearer than `margin_m`. The circle is searched by halving: the field changes no faster
/// than the point moves, so an arc whose ends are far enough from the wall is left out with
/// certainty.
[[nodiscard]] std::vector<WallContact> TorusContacts(const VoidField& field, const Torus& torus,
                                                     double margin_m);

/// A box with edges rounded to `kBoxRounding_m`, touched along its edges and the centre lines of
/// its faces.
struct SolidBox {
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};
  Eigen::Vector3d half_m{Eigen::Vector3d::Zero()};
};
inline constexpr double kBoxRounding_m = 0.003;
[[nodiscard]] std::vector<WallContact> BoxContacts(const VoidField& field, const SolidBox& box,
                                                   double margin_m);

/// Makes MuJoCo collide a model's cylinders (as wheels: tread rounding in their geom_user) and
/// boxes with a field, for as long as it lives. The model must hold exactly one ellipsoid, which
/// stands for the wall.
///
/// MuJoCo's collision table is global, so this file alone writes it: entries for ellipsoid–cylinder
/// and ellipsoid–box look the field up by model. Bindings may be made and used from several
/// threads, each with its own model.
class ContactBinding {
 public:
  ContactBinding(const mjModel* model, const VoidField* field);
  ~ContactBinding();
  ContactBinding(const ContactBinding&) = delete;
  ContactBinding& operator=(const ContactBinding&) = delete;

 private:
  const mjModel* model_;
};

}  // namespace kantaro::sim
