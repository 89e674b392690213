#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "perception/landmark_parameters.hpp"
#include "robot/description.hpp"

namespace kantaro::perception {

/// What a robot knows of the place from its map: a circle's radius in the picture tells its
/// distance only with its size. The laser may tell the pipe's diameter instead.
struct KnownSizes {
  double pipe_diameter_m{};
  double inlet_diameter_m{};  ///< inner, of a house connection; used for inlets alone
  double shaft_diameter_m{};  ///< of a manhole; 0: 500 mm wider than the pipe (thesis 5.2)
};

/// One look at what lies ahead.
struct LandmarkLook {
  cv::Mat image;      ///< rectified brightness of the front camera, or of the left stereo camera
  cv::Mat right;      ///< of the right stereo camera; empty for a single camera
  double travel_m{};  ///< odometry along the pipe, since any fixed moment
};

struct LandmarkAnswer {
  enum class Status {
    kFound,
    /// A good picture that shows no such landmark, or no picture yet. `ours` always answers to a
    /// good picture: where it doubts that there is a landmark, it states a deviation of decimetres.
    kNotSeen,
    kBlank,      ///< nothing can be seen: dark or even all over
    kSaturated,  ///< too bright to see anything
  };
  Status status{Status::kNotSeen};
  /// From the camera to the landmark's plane along the pipe (inlet: to the plane through its
  /// mouth's centre); from the left camera for a pair. As kFound alone.
  double distance_m{};
  double deviation_m{};  ///< standard deviation that the method states; 0: it states none
};
/// "found", "not seen", "blank picture", "saturated picture".
[[nodiscard]] const char* ToString(LandmarkAnswer::Status status);

/// So many pictures of an approach count at most; older ones are forgotten.
inline constexpr int kPicturesOfApproach = 5;

/// Tells how far the nearest landmark of a kind is (thesis 4.3, 5.5). One object follows one
/// approach to one landmark; a new landmark needs a new one.
class LandmarkDistance {
 public:
  LandmarkDistance() = default;
  LandmarkDistance(const LandmarkDistance&) = delete;
  LandmarkDistance& operator=(const LandmarkDistance&) = delete;
  virtual ~LandmarkDistance() = default;

  /// Keeps a look, and answers nothing yet: cheap.
  /// @throws std::invalid_argument for images that are not 8-bit brightness of the camera's size,
  /// and for a travel that is not finite.
  virtual void Add(const LandmarkLook& look) = 0;
  /// From where the last look was taken, by all that were kept.
  [[nodiscard]] virtual LandmarkAnswer Answer() = 0;
  [[nodiscard]] LandmarkAnswer Update(const LandmarkLook& look) {
    Add(look);
    return Answer();
  }
};

/// By a single camera (thesis 4.3), with parameters.mono.
/// @throws std::invalid_argument for sizes that are not above 0, an inlet wider than the pipe, or a
/// shaft that is not.
[[nodiscard]] std::unique_ptr<LandmarkDistance> MakeMonoDistance(
    const robot::Description& description, const LandmarkParameters& parameters, LandmarkKind kind,
    const KnownSizes& sizes);
/// By the stereo pair (thesis 5.5), with parameters.stereo. @throws std::invalid_argument likewise
[[nodiscard]] std::unique_ptr<LandmarkDistance> MakeStereoDistance(
    const robot::Description& description, const LandmarkParameters& parameters, LandmarkKind kind,
    const KnownSizes& sizes);

}  // namespace kantaro::perception
