#pragma once

#include <vector>

namespace kantaro::perception {

/// A distance and how far it may be off, before calibration.
struct RangedLandmark {
  double distance_m{};
  double deviation_m{};
};

/// A distance tried, and the logarithm of how likely it is, but for a constant.
struct TriedDistance {
  double distance_m{}, log_odds{};
};

/// The likeliest stretch: where it lies, and how far the truth may be from there, in that stretch
/// or any other. Distances are as likely as each other before anything is seen.
[[nodiscard]] RangedLandmark Likeliest(const std::vector<TriedDistance>& tried);

}  // namespace kantaro::perception
