#include "sim/contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <shared_mutex>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

/// Walls taken as flat look a little too far from afar: so much of a distance is certain.
constexpr double kTrust = 0.85;
/// A box that lies on the wall is held at both ends.
constexpr double kBoxSeparation_m = 0.1;
const double kSameNormal = std::cos(25.0 * std::numbers::pi / 180.0);

/// Collects the local minima of one shape and keeps the deepest that are distinct: their normals
/// differ by more than 25°, or they lie further apart than `separation`.
class Contacts {
 public:
  explicit Contacts(double separation_m) : separation_m_(separation_m) {}

  void Offer(const WallContact& contact) { contacts_.push_back(contact); }

  /// Deepest first.
  std::vector<WallContact> Take() {
    std::sort(contacts_.begin(), contacts_.end(), [](const WallContact& a, const WallContact& b) {
      return a.distance_m < b.distance_m;
    });
    std::vector<WallContact> distinct;
    for (const WallContact& contact : contacts_) {
      const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](const WallContact& kept) {
        return kept.normal_W.dot(contact.normal_W) >= kSameNormal &&
               (kept.p_WC - contact.p_WC).norm() < separation_m_;
      });
      if (!seen && distinct.size() < kMostContacts) distinct.push_back(contact);
    }
    return distinct;
  }

 private:
  double separation_m_;
  std::vector<WallContact> contacts_;
};

/// Local minima of the wall distance along a curve p(t), searched between samples.
/// `speed` bounds |dp/dt|; a stretch is split until it cannot hold a contact or is shorter than
/// `finest`.
template <typename Curve>
class CurveSearch {
 public:
  CurveSearch(const Nearby& nearby, const Curve& curve, double speed, double rounding,
              double margin, Contacts& contacts)
      : nearby_(nearby),
        curve_(curve),
        speed_(speed),
        rounding_(rounding),
        margin_(margin),
        contacts_(contacts) {}

  struct Sample {
    double t{};
    Wall wall;
    double slope{};  ///< of the wall distance along the curve
  };

  Sample At(double t) const {
    const Vector3d p = curve_.Point(t);
    Sample sample{t, VoidField::NearestWall(nearby_, p, kCap_m), 0.0};
    sample.slope = sample.wall.normal_W.dot(curve_.Tangent(t));
    return sample;
  }

  void Search(double from, double to) const {
    const double half_m = 0.5 * speed_ * (to - from);
    const double middle = 0.5 * (from + to);
    const double middle_m =
        VoidField::NearestWall(nearby_, curve_.Point(middle), kCap_m).distance_m;
    if (kTrust * middle_m - half_m > rounding_ + margin_) return;
    if (2.0 * half_m > kFinest_m) {
      Search(from, middle);
      Search(middle, to);
      return;
    }
    const Sample a = At(from);
    const Sample b = At(to);
    // Where a stretch lies flat on the wall, its ends are the contacts.
    const double flat = 1e-6 * speed_;
    const bool falls = a.slope < -flat;
    const bool rises = b.slope > flat;
    if (falls && rises) Refine(a, b);
    if (falls && std::abs(b.slope) <= flat) Offer(b);
    if (std::abs(a.slope) <= flat && rises) Offer(a);
    if (from == ends_[0]) Offer(a);
    if (to == ends_[1]) Offer(b);
  }

  /// The curve has ends that can touch the wall though it goes on falling beyond them.
  void HasEnds(double from, double to) { ends_ = {from, to}; }

  void Offer(const Sample& sample) const {
    const double distance = sample.wall.distance_m - rounding_;
    if (distance > margin_) return;
    const Vector3d p = curve_.Point(sample.t);
    contacts_.Offer(
        {distance, p - sample.wall.normal_W * (rounding_ + 0.5 * distance), sample.wall.normal_W});
  }

 private:
  /// The slope changes sign between the two: a few secant steps, kept between the ends.
  void Refine(Sample a, Sample b) const {
    Sample best = a.wall.distance_m < b.wall.distance_m ? a : b;
    for (int i = 0; i < 3; ++i) {
      const double share = std::clamp(a.slope / (a.slope - b.slope), 0.1, 0.9);
      const Sample middle = At(a.t + share * (b.t - a.t));
      if (middle.wall.distance_m <= best.wall.distance_m) best = middle;
      if (std::abs(middle.slope) < 1e-3 * speed_) break;
      (middle.slope < 0.0 ? a : b) = middle;
    }
    Offer(best);
  }

  static constexpr double kCap_m = 0.08;  // beyond it only "far" matters
  static constexpr double kFinest_m = 0.007;

  const Nearby& nearby_;
  const Curve& curve_;
  double speed_, rounding_, margin_;
  std::array<double, 2> ends_{std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::quiet_NaN()};
  Contacts& contacts_;
};

struct Circle {
  Vector3d center, u, v;  // u, v scaled by the radius
  Vector3d Point(double t) const { return center + std::cos(t) * u + std::sin(t) * v; }
  Vector3d Tangent(double t) const { return -std::sin(t) * u + std::cos(t) * v; }
};

struct Segment {
  Vector3d start, along;
  Vector3d Point(double t) const { return start + t * along; }
  Vector3d Tangent(double) const { return along; }
};

void SearchSegment(const Nearby& nearby, const Vector3d& start, const Vector3d& end, double margin,
                   Contacts& contacts) {
  const Segment segment{start, end - start};
  CurveSearch<Segment> search(nearby, segment, segment.along.norm(), kBoxRounding_m, margin,
                              contacts);
  search.HasEnds(0.0, 1.0);
  search.Search(0.0, 1.0);
}

Vector3d ToEigen(const mjtNum* v) { return {v[0], v[1], v[2]}; }

int Fill(const std::vector<WallContact>& contacts, mjContact* out) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    out[i].dist = contacts[i].distance_m;
    for (int k = 0; k < 3; ++k) {
      out[i].pos[k] = contacts[i].p_WC[k];
      out[i].frame[k] = contacts[i].normal_W[k];
    }
    mju_zero3(out[i].frame + 3);
    mju_zero3(out[i].frame + 6);
  }
  return static_cast<int>(contacts.size());
}

/// The fields of the models in use. Guarded: the one piece of shared state, because MuJoCo's table
/// has no user pointer.
class Registry {
 public:
  void Add(const mjModel* model, const VoidField* field) {
    const std::unique_lock lock(mutex_);
    fields_[model] = field;
  }
  void Remove(const mjModel* model) {
    const std::unique_lock lock(mutex_);
    fields_.erase(model);
  }
  const VoidField* Find(const mjModel* model) const {
    const std::shared_lock lock(mutex_);
    const auto found = fields_.find(model);
    return found == fields_.end() ? nullptr : found->second;
  }

 private:
  mutable std::shared_mutex mutex_;
  std::map<const mjModel*, const VoidField*> fields_;
};

Registry& TheRegistry() {
  static Registry registry;
  return registry;
}

int CollideWheel(const mjModel* model, const mjData* data, mjContact* out, int /*wall*/, int wheel,
                 mjtNum margin) {
  const VoidField* field = TheRegistry().Find(model);
  if (field == nullptr) return 0;
  const mjtNum* R_WG = data->geom_xmat + 9 * wheel;
  const double tread = model->geom_user[static_cast<std::ptrdiff_t>(model->nuser_geom) * wheel];
  const Torus torus{ToEigen(data->geom_xpos + 3 * wheel),
                    {R_WG[2], R_WG[5], R_WG[8]},
                    model->geom_size[3 * wheel] - tread,
                    tread};
  return Fill(TorusContacts(*field, torus, margin), out);
}

int CollideBox(const mjModel* model, const mjData* data, mjContact* out, int /*wall*/, int box,
               mjtNum margin) {
  const VoidField* field = TheRegistry().Find(model);
  if (field == nullptr) return 0;
  SolidBox solid;
  solid.half_m = ToEigen(model->geom_size + 3 * box);
  solid.X_WB.translation() = ToEigen(data->geom_xpos + 3 * box);
  solid.X_WB.linear() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->geom_xmat + 9 * box);
  return Fill(BoxContacts(*field, solid, margin), out);
}

}  // namespace

std::vector<WallContact> TorusContacts(const VoidField& field, const Torus& torus,
                                       double margin_m) {
  const Nearby nearby = field.Around(torus.p_WT, torus.ring_m + torus.tread_m + margin_m);
  Circle circle{torus.p_WT, torus.axis_W.unitOrthogonal() * torus.ring_m, Vector3d::Zero()};
  circle.v = torus.axis_W.cross(circle.u);
  Contacts contacts(std::numeric_limits<double>::infinity());
  const CurveSearch<Circle> search(nearby, circle, torus.ring_m, torus.tread_m, margin_m, contacts);
  constexpr int kStart = 8;
  constexpr double kStep = 2.0 * std::numbers::pi / kStart;
  for (int i = 0; i < kStart; ++i) search.Search(i * kStep, (i + 1) * kStep);
  return contacts.Take();
}

std::vector<WallContact> BoxContacts(const VoidField& field, const SolidBox& box, double margin_m) {
  const Nearby nearby = field.Around(
      box.X_WB.translation(), std::min(box.half_m.norm() + margin_m, VoidField::kLargestReach_m));
  // Most boxes are nowhere near a wall.
  const double reach_m = box.half_m.norm() + margin_m;
  const double room_m =
      VoidField::NearestWall(nearby, box.X_WB.translation(), 2.0 * reach_m).distance_m;
  if (kTrust * room_m > reach_m) return {};
  const Vector3d inner = (box.half_m.array() - kBoxRounding_m).max(0.0);
  const auto corner = [&](double x, double y, double z) {
    return Vector3d(box.X_WB * inner.cwiseProduct(Vector3d(x, y, z)));
  };
  Contacts contacts(kBoxSeparation_m);
  const auto search = [&](const Vector3d& a, const Vector3d& b) {
    SearchSegment(nearby, a, b, margin_m, contacts);
  };
  for (const double i : {-1.0, 0.0, 1.0}) {
    for (const double j : {-1.0, 0.0, 1.0}) {
      if (i == 0.0 && j == 0.0) continue;  // inside the box
      search(corner(-1.0, i, j), corner(1.0, i, j));
      search(corner(i, -1.0, j), corner(i, 1.0, j));
      search(corner(i, j, -1.0), corner(i, j, 1.0));
    }
  }
  return contacts.Take();
}

ContactBinding::ContactBinding(const mjModel* model, const VoidField* field) : model_(model) {
  TheRegistry().Add(model, field);
  static std::once_flag once;
  std::call_once(once, [] {
    mjCOLLISIONFUNC[mjGEOM_ELLIPSOID][mjGEOM_CYLINDER] = CollideWheel;
    mjCOLLISIONFUNC[mjGEOM_ELLIPSOID][mjGEOM_BOX] = CollideBox;
  });
}

ContactBinding::~ContactBinding() { TheRegistry().Remove(model_); }

}  // namespace kantaro::sim
