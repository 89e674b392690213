#include "perception/landmark_distance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "perception/brightness.hpp"
#include "perception/our_landmarks.hpp"
#include "perception/thesis_landmarks.hpp"
#include "robot/rectifier.hpp"

namespace kantaro::perception {
namespace {

using Status = LandmarkAnswer::Status;

constexpr double kLeastSpread = 1.0;  ///< grey levels; noise alone has less after averaging
constexpr double kBright = 250.0;

void CheckSizes(LandmarkKind kind, const KnownSizes& sizes) {
  const auto positive = [](double value_m) { return std::isfinite(value_m) && value_m > 0.0; };
  if (!positive(sizes.pipe_diameter_m))
    throw std::invalid_argument("landmark distance: the pipe's diameter must be above 0");
  if (sizes.shaft_diameter_m != 0.0 &&
      !(positive(sizes.shaft_diameter_m) && sizes.shaft_diameter_m > sizes.pipe_diameter_m)) {
    throw std::invalid_argument("landmark distance: the shaft must be wider than the pipe, or 0");
  }
  if (ClassOf(kind) != LandmarkClass::kInlet) return;
  if (!positive(sizes.inlet_diameter_m) || sizes.inlet_diameter_m >= sizes.pipe_diameter_m) {
    throw std::invalid_argument(
        "landmark distance: the inlet's diameter must be above 0 and below the pipe's");
  }
}

void CheckImage(const cv::Mat& image, const robot::Camera& camera, const char* what) {
  RequireBrightness(image, what);
  if (image.size() != cv::Size(camera.width_px, camera.height_px)) {
    throw std::invalid_argument(fmt::format("{}: the image is {} x {}, the camera's are {} x {}",
                                            what, image.cols, image.rows, camera.width_px,
                                            camera.height_px));
  }
}

/// Whether a picture shows anything at all; nothing if it does.
std::optional<Status> Unusable(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  if (deviation[0] >= kLeastSpread) return {};
  return mean[0] >= kBright ? Status::kSaturated : Status::kBlank;
}

/// Refuses what is no picture, and passes on what can be seen in.
class CheckedDistance : public LandmarkDistance {
 public:
  CheckedDistance(const robot::Camera& camera, bool pair) : camera_(camera), pair_(pair) {}

  void Add(const LandmarkLook& look) final {
    CheckImage(look.image, camera_, "landmark distance");
    if (pair_) CheckImage(look.right, camera_, "landmark distance, right image");
    if (!std::isfinite(look.travel_m))
      throw std::invalid_argument("landmark distance: the travel must be a number");
    unusable_ = Unusable(look.image);
    if (!unusable_ && pair_) unusable_ = Unusable(look.right);
    if (!unusable_) Keep(look);
  }

  LandmarkAnswer Answer() final { return unusable_ ? LandmarkAnswer{*unusable_} : See(); }

 protected:
  [[nodiscard]] const robot::Camera& camera() const { return camera_; }

 private:
  virtual void Keep(const LandmarkLook& look) = 0;
  virtual LandmarkAnswer See() = 0;

  robot::Camera camera_;
  bool pair_;
  std::optional<Status> unusable_{Status::kNotSeen};  ///< the last look, or none yet
};

/// Thesis 4.3.
class ThesisMono : public CheckedDistance {
 public:
  ThesisMono(const robot::Description& description, const LandmarkParameters& parameters,
             LandmarkKind kind, const KnownSizes& sizes)
      : CheckedDistance(description.front_camera, false),
        parameters_(parameters),
        kind_(kind),
        sizes_(sizes) {}

 private:
  void Keep(const LandmarkLook& look) override { look.image.copyTo(image_); }

  LandmarkAnswer See() override {
    const HoughCircle circle = ThesisCircle(image_, camera(), parameters_, kind_, sizes_);
    if (circle.votes == 0) return {};
    const double radius_px = circle.radius_px * RadiusScale(kind_, sizes_);
    return {Status::kFound,
            std::clamp(parameters_.calibration.Of(kind_).radius.DistanceAt(radius_px),
                       parameters_.near_m, parameters_.far_m)};
  }

  LandmarkParameters parameters_;
  LandmarkKind kind_;
  KnownSizes sizes_;
  cv::Mat image_;
};

/// Thesis 5.5.
class ThesisStereo : public CheckedDistance {
 public:
  ThesisStereo(const robot::Description& description, const LandmarkParameters& parameters,
               LandmarkKind kind)
      : CheckedDistance(description.stereo_left, true),
        parameters_(parameters),
        kind_(kind),
        baseline_m_(robot::StereoBaseline_m(description)) {}

 private:
  void Keep(const LandmarkLook& look) override {
    look.image.copyTo(image_);
    look.right.copyTo(right_);
  }

  LandmarkAnswer See() override {
    const StereoSight sight =
        SeeByStereo(image_, right_, camera().focal_px * baseline_m_, parameters_, kind_);
    if (sight.distances_m.empty()) return {};
    return {Status::kFound, RefineDistances(sight.distances_m, sight.tau1_m, sight.tau2_m)};
  }

  LandmarkParameters parameters_;
  LandmarkKind kind_;
  double baseline_m_;
  cv::Mat image_, right_;
};

LandmarkAnswer Calibrated(const RangedLandmark& ranged, const ErrorFit& fit) {
  return {Status::kFound, ranged.distance_m * (1.0 - fit.bias), ranged.deviation_m * fit.factor};
}

class OurMono : public CheckedDistance {
 public:
  OurMono(const robot::Description& description, const LandmarkParameters& parameters,
          LandmarkKind kind, const KnownSizes& sizes)
      : CheckedDistance(description.front_camera, false),
        fit_(parameters.calibration.Of(kind).mono),
        tracker_(description, description.front_camera, 0.0, parameters, kind, sizes) {}

 private:
  void Keep(const LandmarkLook& look) override { tracker_.Add(look.image, {}, look.travel_m); }

  LandmarkAnswer See() override { return Calibrated(tracker_.Answer(), fit_); }

  ErrorFit fit_;
  LandmarkTracker tracker_;
};

/// The rings of both cameras' pictures together: a known circle's size tells its distance more
/// surely than its disparity does (a pixel is 3 cm at 1.5 m, against 7 cm). The disparity of the
/// wall's texture tells how the pipe lies and by how much the right camera is turned.
class OurStereo : public CheckedDistance {
 public:
  OurStereo(const robot::Description& description, const LandmarkParameters& parameters,
            LandmarkKind kind, const KnownSizes& sizes)
      : CheckedDistance(description.stereo_left, true),
        fit_(parameters.calibration.Of(kind).stereo),
        tracker_(description, description.stereo_left, robot::StereoBaseline_m(description),
                 parameters, kind, sizes) {}

 private:
  void Keep(const LandmarkLook& look) override {
    tracker_.Add(look.image, look.right, look.travel_m);
  }

  LandmarkAnswer See() override { return Calibrated(tracker_.Answer(), fit_); }

  ErrorFit fit_;
  LandmarkTracker tracker_;
};

}  // namespace

const char* ToString(LandmarkAnswer::Status status) {
  switch (status) {
    case Status::kFound:
      return "found";
    case Status::kNotSeen:
      return "not seen";
    case Status::kBlank:
      return "blank picture";
    case Status::kSaturated:
      return "saturated picture";
  }
  throw std::invalid_argument("no such status");
}

std::unique_ptr<LandmarkDistance> MakeMonoDistance(const robot::Description& description,
                                                   const LandmarkParameters& parameters,
                                                   LandmarkKind kind, const KnownSizes& sizes) {
  CheckSizes(kind, sizes);
  if (parameters.mono == LandmarkMethod::kOurs)
    return std::make_unique<OurMono>(description, parameters, kind, sizes);
  return std::make_unique<ThesisMono>(description, parameters, kind, sizes);
}

std::unique_ptr<LandmarkDistance> MakeStereoDistance(const robot::Description& description,
                                                     const LandmarkParameters& parameters,
                                                     LandmarkKind kind, const KnownSizes& sizes) {
  CheckSizes(kind, sizes);
  if (parameters.stereo == LandmarkMethod::kOurs)
    return std::make_unique<OurStereo>(description, parameters, kind, sizes);
  return std::make_unique<ThesisStereo>(description, parameters, kind);
}

}  // namespace kantaro::perception
