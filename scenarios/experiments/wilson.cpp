#include "scenarios/experiments/wilson.hpp"

#include <cmath>
#include <stdexcept>

namespace kantaro::scenarios {

Rate WilsonRate(std::size_t successes, std::size_t trials) {
  if (successes > trials) throw std::invalid_argument("more successes than trials");
  if (trials == 0) return {0.0, 0.0, 1.0};
  constexpr double z = 1.959963984540054;  // 97.5 % of the normal distribution lie below
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
  const double half = z / (1.0 + z * z / n) * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  return {p, successes == 0 ? 0.0 : middle - half, successes == trials ? 1.0 : middle + half};
}

}  // namespace kantaro::scenarios
