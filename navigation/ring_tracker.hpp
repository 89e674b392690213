#pragma once

#include <optional>
#include <vector>

#include "perception/observations.hpp"

namespace kantaro::navigation {

/// How much of the wheels' travel is true, measured against one ring of the wall.
struct ScaleSighting {
  double scale{};  ///< true travel per wheel travel
  double deviation{};
};

/// Follows rings from frame to frame while the robot drives towards them. A ring comes nearer by
/// what the robot truly travels: the slope of its distance over the wheels' travel is the wheels'
/// scale.
class RingTracker {
 public:
  /// Takes the rings of one image, taken at this wheel travel [m].
  /// @returns the scale from each ring that was lost after having been followed far enough.
  [[nodiscard]] std::vector<ScaleSighting> Follow(
      const std::vector<perception::RingSighting>& rings, double wheel_travel_m);
  /// In how many images the ring was seen that this sighting, just followed, belongs to.
  [[nodiscard]] std::size_t TimesSeen(const perception::RingSighting& ring) const;
  void Forget() { tracks_.clear(); }

 private:
  struct Track {
    perception::RingKind kind{};
    std::vector<double> travel_m, distance_m;
    int missed{};
  };
  std::vector<Track> tracks_;
};

/// Least-squares slope of distance over travel, negated, with its standard deviation from the
/// residuals. Absent for fewer than 5 sightings or less than 0.25 m.
[[nodiscard]] std::optional<ScaleSighting> FitScale(const std::vector<double>& travel_m,
                                                    const std::vector<double>& distance_m);

}  // namespace kantaro::navigation
