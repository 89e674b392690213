#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "base/random.hpp"
#include "random_sewer.hpp"
#include "sim/contact.hpp"
#include "sim/sewer.hpp"
#include "sim/void_field.hpp"

// Any checked network becomes a field that is finite, with unit normals, and that changes no faster
// than the point moves. The bytes are a seed, and places to look at.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kantaro;
  using Eigen::Vector3d;
  std::uint64_t seed = 0;
  std::memcpy(&seed, data, std::min<std::size_t>(size, 4));
  const sim::Sewer sewer = sim::BuildSewer(sim::RandomNetwork(seed, 6));
  const sim::VoidField field(sewer.voids, sewer.solids);
  std::uint64_t places = 0;
  if (size > 4) std::memcpy(&places, data + 4, std::min<std::size_t>(size - 4, 8));
  RandomStream random(places, "places");
  for (int i = 0; i < 300; ++i) {
    const sim::VoidPrimitive& v = sewer.voids[random.Index(sewer.voids.size())];
    const double reach = 1.3 * v.radius_m;
    const Vector3d p = FromSweep(v, {random.Uniform(-0.05, v.length_m + 0.05),
                                     random.Uniform(-reach, reach), random.Uniform(-reach, reach)});
    const Vector3d q =
        p + random.Uniform(1e-6, 0.01) *
                Vector3d(random.Normal(1), random.Normal(1), random.Normal(1)).normalized();
    const sim::Nearby nearby = field.Around(p, 0.2);
    const sim::Wall at_p = sim::VoidField::NearestWall(nearby, p, 0.08);
    const sim::Wall at_q = sim::VoidField::NearestWall(nearby, q, 0.08);
    if (nearby.voids().empty()) continue;
    if (!std::isfinite(at_p.distance_m) || !std::isfinite(at_q.distance_m)) std::abort();
    if (std::abs(at_p.normal_W.norm() - 1.0) > 1e-6) std::abort();
    // In the open; depth in the ground is only a bound.
    if (at_p.distance_m > 0.0 && at_q.distance_m > 0.0 && at_p.distance_m < 0.02 &&
        std::abs(at_p.distance_m - at_q.distance_m) > (p - q).norm() + 1e-3)
      std::abort();
    const sim::Torus wheel{
        p, Vector3d(random.Normal(1), random.Normal(1), random.Normal(1)).normalized(), 0.033,
        0.012};
    for (const sim::WallContact& contact : sim::TorusContacts(field, wheel, 0.002)) {
      if (!contact.p_WC.allFinite() || !(contact.distance_m <= 0.002)) std::abort();
    }
  }
  return 0;
}
