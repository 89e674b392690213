#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kantaro::perception {

/// Landmarks ahead of the robot (thesis 4.2). Left and right are the robot's.
enum class LandmarkKind { kManhole, kJoint, kInletLeft, kInletRight };

/// What calibration tells apart: inlets to either side are one.
enum class LandmarkClass { kManhole, kJoint, kInlet };
inline constexpr std::array kLandmarkClasses{LandmarkClass::kManhole, LandmarkClass::kJoint,
                                             LandmarkClass::kInlet};
[[nodiscard]] LandmarkClass ClassOf(LandmarkKind kind);
/// "manhole", "joint", "inlet".
[[nodiscard]] const char* ToString(LandmarkClass landmark);

/// thesis: as chapters 4 and 5 say. ours: see docs/localisation.md.
enum class LandmarkMethod { kThesis, kOurs };

/// Distance [m] by radius [px] of the Hough circle (thesis 4.3, "radius-distance data in field
/// test"), the picture being scaled to a pipe, or an inlet, of the reference diameter. Distances
/// rise and radii fall; in between, distance is linear in 1 / radius.
struct RadiusTable {
  std::vector<std::pair<double, double>> distance_radius;

  /// Beyond its ends the last stretch goes on. Needs two entries.
  [[nodiscard]] double DistanceAt(double radius_px) const;
};
inline constexpr double kReferencePipe_m = 0.300, kReferenceInlet_m = 0.130;

/// Distance = at_none_m + per_edge_m * number of edge pixels (thesis fig 5.25).
struct EdgeFit {
  double at_none_m{}, per_edge_m{};
  [[nodiscard]] double DistanceAt(double edges) const { return at_none_m + per_edge_m * edges; }
};

/// How what `ours` says compares with what was so, in training views.
struct ErrorFit {
  double bias{};       ///< subtract this share of the distance
  double factor{1.0};  ///< times the deviation that the method works out by itself
};

/// What `kantaro calibrate` learns of one class of landmarks.
struct ClassCalibration {
  RadiusTable radius;       ///< thesis, mono
  EdgeFit shorter, longer;  ///< thesis, stereo: Canny (50, 150) and (50, 250)
  ErrorFit mono, stereo;    ///< ours
};

struct LandmarkCalibration {
  std::array<ClassCalibration, kLandmarkClasses.size()> classes;  ///< in their order

  [[nodiscard]] const ClassCalibration& Of(LandmarkKind kind) const;
};

/// Reads `landmarks.yaml`. Every key must be there and no other. @throws InputError
[[nodiscard]] LandmarkCalibration ReadLandmarkCalibration(const std::filesystem::path& file);
[[nodiscard]] LandmarkCalibration ParseLandmarkCalibration(const std::string& text,
                                                           const std::filesystem::path& name);
/// The file's text; read again it is the same to 0.01 mm and 0.01 px.
/// @param remark  one line above all, without its "#"
[[nodiscard]] std::string ToYaml(const LandmarkCalibration& calibration, const std::string& remark);

/// Section `landmarks` of perception.yaml.
struct LandmarkParameters {
  LandmarkMethod mono{LandmarkMethod::kOurs}, stereo{LandmarkMethod::kOurs};
  /// Landmarks are looked for between these distances; inlets no farther than `thesis` (0.8 m) and
  /// `ours` (1 m) can tell them from dirt.
  double near_m{0.25}, far_m{1.70};
  int circle_low{30}, circle_high{90};  ///< for the single camera; thesis 4.3 gives none
  int canny_low{50}, canny_high{200};   ///< thesis 5.5 and 5.6
  int shorter_high{150},
      longer_high{250};             ///< upper thresholds of the two fits, lower one as above
  LandmarkCalibration calibration;  ///< from its own file
};

}  // namespace kantaro::perception
