#include "base/random.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kantaro {
namespace {

/// FNV-1a, so that the stream depends on nothing but the bytes of its name.
std::uint64_t HashName(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : name) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3u;
  }
  return hash;
}

std::mt19937_64 MakeEngine(std::uint64_t run_seed, std::string_view name) {
  const std::uint64_t hash = HashName(name);
  std::seed_seq sequence{static_cast<std::uint32_t>(run_seed),
                         static_cast<std::uint32_t>(run_seed >> 32),
                         static_cast<std::uint32_t>(hash), static_cast<std::uint32_t>(hash >> 32)};
  return std::mt19937_64(sequence);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t run_seed, std::string_view name)
    : engine_(MakeEngine(run_seed, name)) {}

// The standard's distributions differ between libraries; these few lines do not.
double RandomStream::Uniform(double low, double high) {
  const double unit = static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  return low + (high - low) * unit;
}

double RandomStream::Normal(double standard_deviation) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(0.0, 1.0)));
  return standard_deviation * radius * std::cos(2.0 * std::numbers::pi * Uniform(0.0, 1.0));
}

std::uint64_t RandomStream::Index(std::uint64_t count) {
  if (count == 0)
    throw std::invalid_argument("a random index needs at least one thing to choose from");
  return engine_() % count;
}

}  // namespace kantaro
