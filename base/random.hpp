#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace kantaro {

/// One named stream of random numbers of a run. Streams are independent: each is seeded from
/// (run seed, stream name) alone, so a new consumer moves no other. Never shared between owners.
class RandomStream {
 public:
  RandomStream(std::uint64_t run_seed, std::string_view name);

  /// Uniform in [low, high).
  [[nodiscard]] double Uniform(double low, double high);
  /// Normal with mean 0.
  [[nodiscard]] double Normal(double standard_deviation);
  /// Uniform over 0 … count − 1. @throws std::invalid_argument if count is 0.
  [[nodiscard]] std::uint64_t Index(std::uint64_t count);

 private:
  std::mt19937_64 engine_;
};

}  // namespace kantaro
