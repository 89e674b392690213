// Contact, rays and pictures come from the same voids: do they agree on where the wall is?
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "base/random.hpp"
#include "network/formats.hpp"
#include "sim/ray_caster.hpp"
#include "sim/renderer.hpp"
#include "sim/sewer.hpp"
#include "sim/surface_mesh.hpp"
#include "sim/void_field.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

/// A point on the wall, with the direction into the void.
struct WallPoint {
  Vector3d p_W;
  Vector3d normal_W;
  bool on_edge{};  ///< another wall within 5 mm
};

/// The kinds of place that the three are compared at.
enum class Place { kStraight, kJoint, kMouth, kChannel, kBend, kInlet, kStep, kFloor, kSolid };

/// One sewer in its three forms, which take seconds to make: tests share it.
struct ThreeForms {
  explicit ThreeForms(const std::string& network) : sewer(BuildSewer(Drained(network))) {}

  /// Pictures show water, which is no wall.
  static network::Network Drained(const std::string& name) {
    network::Network net = network::ReadNetwork(KANTARO_SOURCE_DIR "/models/networks/" + name);
    for (network::Pipe& pipe : net.pipes) pipe.water_m = 0.0;
    return net;
  }

  Sewer sewer;
  VoidField field{sewer.voids, sewer.solids};
  SurfaceMesh mesh = Tessellate(sewer.voids, sewer.solids);
  RayCaster rays{mesh};
  Renderer renderer{std::make_shared<const Scenery>(sewer, mesh)};
};

class AgreementIn : public testing::Test {
 protected:
  explicit AgreementIn(ThreeForms& forms)
      : sewer_(forms.sewer), field_(forms.field), rays_(forms.rays), renderer_(forms.renderer) {}

  static constexpr double kBack_m = 0.03;  ///< looked at from so far inside the void

  const Sewer& sewer_;
  const VoidField& field_;
  const RayCaster& rays_;
  Renderer& renderer_;

  static bool Matches(const VoidPrimitive& v, Place place) {
    switch (place) {
      case Place::kStraight:
        return v.feature == Feature::kStraight;
      case Place::kMouth:
        return v.feature == Feature::kStraight || v.feature == Feature::kInlet;
      case Place::kJoint:
        return v.feature == Feature::kJoint;
      case Place::kChannel:
        return v.feature == Feature::kChannel;
      case Place::kBend:
        return v.feature == Feature::kBend;
      case Place::kInlet:
        return v.feature == Feature::kInlet;
      case Place::kFloor:
        return v.feature == Feature::kShaft;
      case Place::kStep:
      case Place::kSolid:
        break;
    }
    return false;
  }
  [[nodiscard]] bool IsCandidate(const VoidPrimitive& v, Place place) const {
    if (place != Place::kStep) return Matches(v, place);
    const Part& part = sewer_.parts[v.part];
    return Matches(v, Place::kStraight) && part.kind == Part::Kind::kPipe &&
           !sewer_.network.pipes[part.index].diameter_changes.empty();
  }

  /// A point of the side of one primitive, drawn evenly; for mouths, within 10 mm of its start (or
  /// of the pipe's wall, where an inlet begins).
  Vector3d DrawOnSide(const VoidPrimitive& v, Place place, RandomStream& random) const {
    double along = random.Uniform(0.0, v.length_m);
    if (place == Place::kMouth)
      along = random.Uniform(0.0, v.feature == Feature::kInlet ? 0.16 : 0.010);
    const double around = random.Uniform(0.0, 2.0 * std::numbers::pi);
    SweepPoint point{along, v.radius_m * std::cos(around), v.radius_m * std::sin(around)};
    if (v.profile == Profile::kU && point.up_m > 0.0)
      point.left_m = std::copysign(v.radius_m, point.left_m);
    return FromSweep(v, point);
  }

  /// A point of a cap of one primitive: steps are at either end, floors at a shaft's start.
  Vector3d DrawOnCap(const VoidPrimitive& v, Place place, RandomStream& random) const {
    const bool start = place == Place::kFloor || random.Index(2) == 0;
    const double r = v.radius_m;
    return FromSweep(v, {start ? 0.0 : v.length_m, random.Uniform(-r, r), random.Uniform(-r, r)});
  }

  /// A point of some void's wall, unless another void or a solid takes it away.
  std::optional<WallPoint> DrawOnVoid(Place place, RandomStream& random) const {
    std::vector<const VoidPrimitive*> candidates;
    for (const VoidPrimitive& v : sewer_.voids) {
      if (IsCandidate(v, place)) candidates.push_back(&v);
    }
    const VoidPrimitive& v = *candidates[random.Index(candidates.size())];
    const bool cap = place == Place::kStep || place == Place::kFloor;
    const Vector3d p = cap ? DrawOnCap(v, place, random) : DrawOnSide(v, place, random);
    const Walls walls = WallsAround(v, p);
    const auto on =
        std::find_if(walls.wall.begin() + (cap ? 1 : 0), walls.wall.begin() + walls.count,
                     [](const Wall& wall) { return std::abs(wall.distance_m) < 1e-9; });
    const bool taken =
        std::any_of(sewer_.voids.begin(), sewer_.voids.end(), [&](const VoidPrimitive& other) {
          return &other != &v && InsideDistance(other, p) > 1e-5;
        });
    const bool outside = std::any_of(walls.wall.begin(), walls.wall.begin() + walls.count,
                                     [](const Wall& wall) { return wall.distance_m < -1e-9; });
    const bool hidden = std::any_of(
        sewer_.solids.begin(), sewer_.solids.end(),
        [&](const SolidPrimitive& solid) { return SurfaceOf(solid, p).distance_m < 1e-5; });
    if (taken || outside || hidden || on == walls.wall.begin() + walls.count) return {};
    return WallPoint{p, on->normal_W};
  }

  /// A point of some solid's surface that stands in the open.
  std::optional<WallPoint> DrawOnSolid(RandomStream& random) const {
    const SolidPrimitive& solid = sewer_.solids[random.Index(sewer_.solids.size())];
    const Eigen::AlignedBox3d box = BoundingBox(solid);
    Vector3d p;
    for (int i = 0; i < 3; ++i) p[i] = random.Uniform(box.min()[i], box.max()[i]);
    Wall surface = SurfaceOf(solid, p);
    p -= surface.distance_m * surface.normal_W;
    surface = SurfaceOf(solid, p + 1e-4 * surface.normal_W);
    if (std::abs(SurfaceOf(solid, p).distance_m) > 1e-7) return {};
    const bool open =
        std::any_of(sewer_.voids.begin(), sewer_.voids.end(),
                    [&](const VoidPrimitive& v) { return InsideDistance(v, p) > 0.001; });
    const bool hidden =
        std::any_of(sewer_.solids.begin(), sewer_.solids.end(), [&](const SolidPrimitive& other) {
          return &other != &solid && SurfaceOf(other, p).distance_m < 1e-5;
        });
    if (!open || hidden) return {};
    return WallPoint{p, surface.normal_W};
  }

  /// Draws until the point is wall and can be looked at from inside.
  WallPoint Draw(Place place, RandomStream& random) const {
    for (;;) {
      const auto drawn = place == Place::kSolid ? DrawOnSolid(random) : DrawOnVoid(place, random);
      if (!drawn) continue;
      const auto& [p, n, unused] = *drawn;
      const double back = place == Place::kJoint ? 0.003 : kBack_m;
      if (VoidField::NearestWall(field_.Around(p + back * n, 0.1), p + back * n, 0.1).distance_m <
          0.5 * back)
        continue;
      // A groove is looked at from afar; where a joint has moved, its lip may stand in the way.
      bool in_the_way = false;
      for (double range = 0.003; place == Place::kJoint && range < 0.1; range += 0.001) {
        const Vector3d q = p + range * n;
        in_the_way = in_the_way ||
                     VoidField::NearestWall(field_.Around(q, 0.01), q, 0.01).distance_m < 0.0005;
      }
      if (in_the_way) continue;
      // On an edge the wall of a probe beside the point is another one.
      const Vector3d probe = p + 0.005 * n;
      const double nearest =
          VoidField::NearestWall(field_.Around(probe, 0.05), probe, 0.05).distance_m;
      bool edge = nearest < 0.0049;
      bool on_rim = false;
      const auto off_wall = [&](const Vector3d& q) {
        return std::abs(VoidField::NearestWall(field_.Around(q, 0.05), q, 0.05).distance_m);
      };
      for (const Vector3d& side : {n.unitOrthogonal().eval(), n.cross(n.unitOrthogonal()).eval()}) {
        for (const double sign : {-1.0, 1.0}) {
          edge = edge || off_wall(p + 0.005 * sign * side) > 0.001;
          // Facets are true to 0.2 mm: nearer to an edge than that a ray may pass it by.
          on_rim = on_rim || off_wall(p + 0.0003 * sign * side) > 0.0001;
        }
      }
      if (on_rim) continue;
      return {p, n, edge};
    }
  }

  double ByContact(const WallPoint& at) const {
    return VoidField::NearestWall(field_.Around(at.p_W, 0.05), at.p_W, 0.05).distance_m;
  }

  double ByRay(const WallPoint& at, double back_m) const {
    const auto hit = rays_.Cast(at.p_W + back_m * at.normal_W, -at.normal_W, 1.0);
    return hit ? hit->range_m - back_m : INFINITY;
  }

  double ByPicture(const WallPoint& at, double back_m) {
    CameraView view;
    view.width_px = view.height_px = 9;
    view.focal_px = 400.0;
    view.center_x_px = view.center_y_px = 4.0;
    view.X_WC.linear().col(2) = -at.normal_W;
    view.X_WC.linear().col(0) = at.normal_W.unitOrthogonal();
    view.X_WC.linear().col(1) = view.X_WC.linear().col(2).cross(view.X_WC.linear().col(0));
    view.X_WC.translation() = at.p_W + back_m * at.normal_W;
    return renderer_.RenderDepth(view).at<float>(4, 4) - back_m;
  }

  void Compare(Place place, int count) {
    RandomStream random(7, "agreement." + std::to_string(static_cast<int>(place)));
    const double back = place == Place::kJoint ? 0.003 : kBack_m;
    for (int i = 0; i < count; ++i) {
      const WallPoint at = Draw(place, random);
      const double tolerance = at.on_edge ? 0.002 : 0.001;
      EXPECT_NEAR(ByContact(at), 0.0, tolerance) << at.p_W.transpose();
      EXPECT_NEAR(ByRay(at, back), 0.0, tolerance) << at.p_W.transpose();
      // A picture needs its near plane: a groove is looked at from the middle of the pipe.
      const double away = place == Place::kJoint ? 0.1 : back;
      EXPECT_NEAR(ByPicture(at, away), 0.0, tolerance) << at.p_W.transpose();
    }
  }
};

class Agreement : public AgreementIn {
 protected:
  Agreement() : AgreementIn(Forms()) {}
  static ThreeForms& Forms() {
    static ThreeForms forms("test_field.yaml");
    return forms;
  }
};
class AgreementOfElements : public AgreementIn {
 protected:
  AgreementOfElements() : AgreementIn(Forms()) {}
  static ThreeForms& Forms() {
    static ThreeForms forms("every_element.yaml");
    return forms;
  }
};

TEST_F(Agreement, OnStraights) { Compare(Place::kStraight, 167); }
TEST_F(Agreement, InJoints) { Compare(Place::kJoint, 167); }
TEST_F(Agreement, AtMouths) { Compare(Place::kMouth, 167); }
TEST_F(Agreement, InChannels) { Compare(Place::kChannel, 167); }
TEST_F(Agreement, InBends) { Compare(Place::kBend, 166); }
TEST_F(Agreement, InInlets) { Compare(Place::kInlet, 166); }

TEST_F(AgreementOfElements, OnObstaclesAndProtrudingInlets) { Compare(Place::kSolid, 300); }
TEST_F(AgreementOfElements, OnSteps) { Compare(Place::kStep, 100); }
TEST_F(AgreementOfElements, OnFloorsAndBenching) { Compare(Place::kFloor, 100); }
TEST_F(AgreementOfElements, InMovedJoints) { Compare(Place::kJoint, 100); }
// Where the dirt of joints is painted, in whatever width a pipe has there: it is thinner than 1 mm.
TEST_F(AgreementOfElements, BesideJoints) {
  int count = 0;
  for (std::size_t i = 0; i < sewer_.axes.size(); ++i) {
    const network::Pipe& pipe = sewer_.network.pipes[i];
    for (const network::Joint& joint : pipe.joints) {
      for (const double side : {-1.0, 1.0}) {
        const double chainage_m = joint.chainage_m + side * (joint.gap_m / 2.0 + 0.003);
        const Eigen::Isometry3d X_WP = sewer_.axes[i].PoseAt(chainage_m);
        for (const double clock_h : {1.5, 4.5, 7.5, 10.5}) {
          const Vector3d out_P = network::ClockDirection(clock_h);
          const WallPoint at{X_WP * (pipe.DiameterAt(chainage_m) / 2.0 * out_P),
                             -(X_WP.linear() * out_P)};
          if (std::abs(ByContact(at)) > 1e-6) continue;  // a groove, or what stands before it
          ++count;
          EXPECT_NEAR(ByPicture(at, 0.05), 0.0, 0.001)
              << pipe.name << " " << joint.chainage_m << " m, " << clock_h << " h";
        }
      }
    }
  }
  EXPECT_GT(count, 100);
}
TEST_F(AgreementOfElements, InChannels) { Compare(Place::kChannel, 100); }
TEST_F(AgreementOfElements, AtMouthsAndDrops) { Compare(Place::kMouth, 100); }
TEST_F(AgreementOfElements, InSlantingInlets) { Compare(Place::kInlet, 100); }

}  // namespace
}  // namespace kantaro::sim
