#include "pose_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "random_sewer.hpp"
#include "sampled_sewer.hpp"
#include "sim/contact.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kReach_m = 0.06;
constexpr double kNear_m = 0.02;
constexpr double kMargin_m = 0.005;
constexpr double kRing_m = 0.033, kTread_m = 0.012;

Vector3d Direction(RandomStream& random) {
  return Vector3d(random.Normal(1.0), random.Normal(1.0), random.Normal(1.0)).normalized();
}

class Measurement {
 public:
  Measurement(std::uint64_t seed, PoseErrors& errors)
      : seed_(seed), random_(seed, "poses"), errors_(errors) {}

  void Run(int poses) {
    for (int i = 0; i < poses; ++i) i % 2 == 0 ? Sphere() : Wheel();
  }

 private:
  /// A free point within a distance of some wall.
  Vector3d FreePoint(double away_m) {
    for (;;) {
      const Vector3d p = sampled_.Sample(random_.Index(sampled_.size())) +
                         random_.Uniform(0.0005, away_m) * Direction(random_);
      if (sampled_.IsFree(p)) return p;
    }
  }

  void Note(double error_m, double distance_m, std::vector<double>& errors, const char* what,
            const Vector3d& p) {
    errors.push_back(error_m);
    if (error_m <= errors_.worst_size) return;
    errors_.worst_size = error_m;
    errors_.worst =
        fmt::format("{} of seed {}: {:.2f} mm off at {:.2f} mm, ({:.5f}, {:.5f}, {:.5f})", what,
                    seed_, error_m * 1e3, distance_m * 1e3, p.x(), p.y(), p.z());
  }

  void Sphere() {
    const Vector3d p = FreePoint(random_.Index(4) == 0 ? kReach_m : kNear_m);
    const double truth = sampled_.Distance(p, kReach_m);
    const double found = VoidField::NearestWall(field_.Around(p, kReach_m), p, kReach_m).distance_m;
    if (truth <= kNear_m) {
      Note(std::abs(found - truth), truth, errors_.near, "sphere", p);
    } else {
      errors_.far.push_back(found - truth);
    }
  }

  void Wheel() {
    Torus wheel;
    wheel.ring_m = kRing_m;
    wheel.tread_m = kTread_m;
    double truth = 0.0;
    // A wheel that stands about on the wall: its ring lies in the open, at most 5 mm too deep.
    for (;;) {
      wheel.p_WT = FreePoint(0.07);
      wheel.axis_W = Direction(random_);
      truth = RingDistance(wheel) - kTread_m;
      if (truth > -0.005 && truth < kMargin_m) break;
    }
    const std::vector<WallContact> contacts = TorusContacts(field_, wheel, kMargin_m);
    const double found = contacts.empty() ? kMargin_m : contacts.front().distance_m;
    Note(std::abs(found - truth), truth, errors_.wheels, "wheel", wheel.p_WT);
  }

  /// From a wheel's ring to the wall; 0 where the ring leaves the open.
  double RingDistance(const Torus& wheel) const {
    const Vector3d u = wheel.axis_W.unitOrthogonal() * wheel.ring_m;
    const Vector3d v = wheel.axis_W.cross(u);
    const auto at = [&](double t) {
      return Vector3d(wheel.p_WT + std::cos(t) * u + std::sin(t) * v);
    };
    constexpr double kReachOfRing = kTread_m + kMargin_m + 0.004;
    constexpr int kCount = 48;
    constexpr double kStep = 2.0 * std::numbers::pi / kCount;
    std::vector<std::pair<double, int>> rough;
    for (int i = 0; i < kCount; ++i) {
      const Vector3d p = at(i * kStep);
      if (!sampled_.IsFree(p)) return 0.0;
      rough.emplace_back(sampled_.Roughly(p, kReachOfRing), i);
    }
    std::sort(rough.begin(), rough.end());
    double best = kReachOfRing;
    // Between samples the distance can fall by less than half a step of the ring.
    for (const auto& [distance, i] : rough) {
      if (distance > best + 0.003 || distance >= kReachOfRing) break;
      for (int k = -2; k <= 2; ++k)
        best = std::min(best, sampled_.Distance(at((i + 0.25 * k) * kStep), kReachOfRing));
    }
    return best;
  }

  std::uint64_t seed_;
  RandomStream random_;
  PoseErrors& errors_;
  Sewer sewer_ = BuildSewer(RandomNetwork(seed_, 4));
  VoidField field_{sewer_.voids, sewer_.solids};
  SampledSewer sampled_{sewer_};
};

}  // namespace

PoseErrors MeasurePoseErrors(std::uint64_t first_seed, int sewers, int poses_each) {
  PoseErrors errors;
  for (int i = 0; i < sewers; ++i)
    Measurement(first_seed + static_cast<std::uint64_t>(i), errors).Run(poses_each);
  return errors;
}

double Quantile(std::vector<double> values, double share) {
  for (double& value : values) value = std::abs(value);
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(share * last)];
}

}  // namespace kantaro::sim
