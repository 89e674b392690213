#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "network/network.hpp"
#include "perception/landmark_distance.hpp"
#include "robot/description.hpp"

namespace kantaro::scenarios {

/// Which views: as in the thesis' dry test field, or far worse: wet, dimmed, of any material, off
/// the axis, leaning, and the right camera turned.
/// The field is the thesis' own case at its mildest: three pipes in which the method was also
/// calibrated, the robot standing straight, nothing farther than 0.8 m.
enum class ViewSet { kReproduction, kStress, kField };
/// How far landmarks are ahead.
inline constexpr double kNearestView_m = 0.3, kFarthestRing_m = 1.5, kFarthestInlet_m = 0.8;

/// Calibration sees training views, experiments test views; no pose or noise is in both, and but
/// for the field no sewer and texture.
enum class ViewPurpose { kTraining, kTest };
enum class ViewCameras { kFront, kStereo };

[[nodiscard]] const char* ToString(ViewSet set);

/// Names the random streams of one sewer and all views in it.
[[nodiscard]] std::string StreamOf(ViewPurpose purpose, ViewSet set, std::size_t sewer);

/// How a robot sways as it drives: its wheels climb the wall to one side and the other, and its
/// heading swings.
struct Weave {
  double length_m{1.0};  ///< of travel, from one swing to the next of the same side
  double roll_rad{}, roll_phase_rad{};
  double yaw_rad{}, yaw_phase_rad{};
};

/// What is ahead, and how the robot looks at it: all that is drawn for one view. How it lies is
/// meant for the last picture.
struct ViewPlan {
  perception::LandmarkKind kind{};
  std::size_t landmark{};       ///< among the joints or inlets of the pipe
  double distance_m{};          ///< from the camera along the pipe when the last picture is taken
  double off_y_m{}, off_z_m{};  ///< from where the robot stands when it has settled
  double roll_rad{}, pitch_rad{}, yaw_rad{};  ///< likewise
  double yaw_error_rad{};                     ///< of the right camera, against its calibration
  double speed_m_s{};                         ///< blurs the picture
  double odometry_error{};                    ///< share by which odometry counts too much
  double between_m{};                         ///< travel from one picture to the next
  Weave weave;
};

/// A sewer made for views, as a function of these alone: a pipe with joints and inlets to either
/// side that ends in a manhole (round the turn there, straight on, or the last one).
struct LandmarkSewer {
  network::Network network;
  std::uint64_t texture_seed{};
  double light{1.0};  ///< of the lamps
  [[nodiscard]] const network::Pipe& pipe() const { return network.pipes.front(); }
};
[[nodiscard]] LandmarkSewer DrawSewer(ViewPurpose purpose, ViewSet set, std::uint64_t seed,
                                      std::size_t sewer);
/// @param view  of this sewer
[[nodiscard]] ViewPlan DrawView(const LandmarkSewer& sewer, ViewPurpose purpose, ViewSet set,
                                std::uint64_t seed, std::size_t sewer_number, std::size_t view,
                                perception::LandmarkKind kind);

/// What a video camera does in this share of the light that it is set for: it opens its shutter as
/// long as a field lasts, then raises its gain, until the picture is as bright. Noise and motion
/// blur are what is left.
[[nodiscard]] robot::ImageSensor AutomaticExposure(robot::ImageSensor sensor, double light);

/// Whether no other joint lies between the camera and the landmark.
[[nodiscard]] bool SeesOnlyItsRing(const LandmarkSewer& sewer, const ViewPlan& plan);

/// One picture, or pair, of an approach, as the robot's code gets it: rectified brightness.
struct LandmarkPicture {
  cv::Mat image, right;
  double travel_m{};  ///< as odometry counts it
};

/// Photographs one sewer.
class LandmarkStage {
 public:
  /// @throws RenderingUnavailable
  LandmarkStage(const robot::Description& description, LandmarkSewer sewer);
  ~LandmarkStage();

  /// @param count  the last so many pictures, the very last at the plan's distance; a picture is
  /// the same with or without those before
  [[nodiscard]] std::vector<LandmarkPicture> Approach(const ViewPlan& plan, ViewCameras cameras,
                                                      std::uint64_t seed, const std::string& stream,
                                                      int count = perception::kPicturesOfApproach);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// One view: what is ahead, and all pictures of it.
struct LandmarkView {
  std::size_t number{};  ///< among all
  ViewPlan plan;
  network::WallCondition condition{};
  network::Material material{};
  double light{1.0};  ///< of the lamps
  bool clear{};       ///< SeesOnlyItsRing
  perception::KnownSizes sizes;
  std::vector<LandmarkPicture> pictures;
};

/// What is to be photographed.
struct ViewRequest {
  ViewPurpose purpose{ViewPurpose::kTest};
  ViewSet set{ViewSet::kReproduction};
  ViewCameras cameras{ViewCameras::kFront};
  std::vector<perception::LandmarkKind> kinds;  ///< of each view
  std::uint64_t seed{1};
  unsigned jobs{1};                               ///< threads; changes no view
  int pictures{perception::kPicturesOfApproach};  ///< of each approach, its last ones
};

/// So many views are taken in one sewer: three sewers for the thesis' 74 or 70.
inline constexpr std::size_t kViewsPerSewer = 25;

/// Takes all views and hands each over, from several threads at once and in any order.
void ForEachView(const robot::Description& description, const ViewRequest& request,
                 const std::function<void(LandmarkView&&)>& use);

/// Kinds of views 0, 1, 2 … so that any stretch holds them in these proportions, inlets to the
/// left and right in turn.
[[nodiscard]] std::vector<perception::LandmarkKind> SpreadKinds(std::size_t manholes,
                                                                std::size_t joints,
                                                                std::size_t inlets);

}  // namespace kantaro::scenarios
