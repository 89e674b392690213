#pragma once

#include <cstddef>

namespace kantaro::scenarios {

/// A rate and its 95 % confidence interval.
struct Rate {
  double share{}, low{}, high{};
};

/// Wilson's score interval for `successes` of `trials` (E. B. Wilson, J. Am. Stat. Assoc. 22,
/// 1927). 0 to 1 where nothing was tried. @throws std::invalid_argument if successes > trials
[[nodiscard]] Rate WilsonRate(std::size_t successes, std::size_t trials);

}  // namespace kantaro::scenarios
