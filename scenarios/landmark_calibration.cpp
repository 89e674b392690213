#include "scenarios/landmark_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "base/input_error.hpp"
#include "perception/landmark_distance.hpp"
#include "perception/thesis_landmarks.hpp"
#include "scenarios/experiments/landmark_views.hpp"
#include "scenarios/recorded_views.hpp"

namespace kantaro::scenarios {
namespace {

using perception::LandmarkClass;
using perception::LandmarkMethod;

constexpr double kStretch_m = 0.1;
constexpr double kLeastFall_px = 0.5;
constexpr std::size_t kFewestOfClass = 10;  ///< or what was learnt before is better
constexpr std::size_t kFewestOfStretch = 2, kFewestErrors = 20;
/// A circle that differs by more from where geometry puts it is not the landmark's: whoever
/// measures in the field sees that.
constexpr double kMostAstray = 0.30;

double Quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

struct WeighedSample {
  Sample mean;
  double views{};
};

void PoolLastTwo(std::vector<WeighedSample>& entries) {
  const auto [last, more] = entries.back();
  entries.pop_back();
  auto& [mean, views] = entries.back();
  const double all = views + more;
  mean = {(views * mean.distance_m + more * last.distance_m) / all,
          (views * mean.x + more * last.x) / all};
  views = all;
}

/// What one training view tells.
struct Lesson {
  LandmarkClass landmark{};
  double distance_m{};
  std::optional<double> radius_px;
  double shorter_edges{}, longer_edges{};
  std::optional<StatedError> stated;
};

std::optional<double> RadiusOf(const LandmarkView& view, const robot::Camera& camera,
                               const perception::LandmarkParameters& parameters) {
  const auto circle = perception::ThesisCircle(view.pictures.back().image, camera, parameters,
                                               view.plan.kind, view.sizes);
  if (circle.votes == 0) return {};
  const double radius_px = circle.radius_px * perception::RadiusScale(view.plan.kind, view.sizes);
  if (perception::ClassOf(view.plan.kind) == LandmarkClass::kInlet) return radius_px;
  const double expected_px =
      camera.focal_px * perception::kReferencePipe_m / 2.0 / view.plan.distance_m;
  if (std::abs(radius_px / expected_px - 1.0) > kMostAstray) return {};
  return radius_px;
}

std::optional<StatedError> Ask(perception::LandmarkDistance& distance, const LandmarkView& view) {
  for (const LandmarkPicture& picture : view.pictures)
    distance.Add({picture.image, picture.right, picture.travel_m});
  const perception::LandmarkAnswer answer = distance.Answer();
  if (answer.status != perception::LandmarkAnswer::Status::kFound) return {};
  return StatedError{view.plan.distance_m, answer.distance_m - view.plan.distance_m,
                     answer.deviation_m};
}

std::vector<Sample> SamplesOf(const std::vector<Lesson>& lessons, LandmarkClass landmark,
                              const std::function<std::optional<double>(const Lesson&)>& x) {
  std::vector<Sample> samples;
  for (const Lesson& lesson : lessons) {
    const auto value = x(lesson);
    if (lesson.landmark == landmark && value) samples.push_back({lesson.distance_m, *value});
  }
  return samples;
}

std::vector<StatedError> ErrorsOf(const std::vector<Lesson>& lessons, LandmarkClass landmark) {
  std::vector<StatedError> errors;
  for (const Lesson& lesson : lessons) {
    if (lesson.landmark == landmark && lesson.stated) errors.push_back(*lesson.stated);
  }
  return errors;
}

/// Where the Hough transform finds the landmark in too few views for a table, the one before stays,
/// or the pinhole's own geometry stands in: what a ruler held into the pipe would give.
perception::RadiusTable TableOrGeometry(const std::vector<Sample>& samples, LandmarkClass landmark,
                                        double focal_px, const perception::RadiusTable& before) {
  try {
    return FitRadiusTable(samples);
  } catch (const std::invalid_argument&) {
    if (!before.distance_radius.empty()) return before;
    const double diameter_m = landmark == LandmarkClass::kInlet ? perception::kReferenceInlet_m
                                                                : perception::kReferencePipe_m;
    perception::RadiusTable table;
    for (const double distance_m : {0.3, 0.9, 1.5})
      table.distance_radius.emplace_back(distance_m, focal_px * diameter_m / 2.0 / distance_m);
    return table;
  }
}

ViewRequest TrainingRequest(ViewSet set, ViewCameras cameras, const CalibrationOptions& options) {
  ViewRequest request{ViewPurpose::kTraining, set, cameras, {}, options.seed, options.jobs};
  const auto once = SpreadKinds(1, 1, 1);
  for (std::size_t i = 0; i < options.views; ++i) {
    request.kinds.push_back(i % 6 == 5 ? perception::LandmarkKind::kInletRight
                                       : once[i % once.size()]);
  }
  return request;
}

Lesson ThesisLesson(const LandmarkView& view, ViewCameras cameras,
                    const robot::Description& description,
                    const perception::LandmarkParameters& parameters) {
  Lesson lesson;
  lesson.landmark = perception::ClassOf(view.plan.kind);
  lesson.distance_m = view.plan.distance_m;
  if (cameras == ViewCameras::kFront) {
    lesson.radius_px = RadiusOf(view, description.front_camera, parameters);
  } else {
    const auto counts =
        perception::CountEdges(view.pictures.back().image, parameters, view.plan.kind);
    lesson.shorter_edges = counts.shorter;
    lesson.longer_edges = counts.longer;
  }
  return lesson;
}

/// What lessons with these cameras say to the thesis' method.
void FitThesis(const std::vector<Lesson>& lessons, ViewCameras cameras,
               const robot::Description& description,
               perception::LandmarkCalibration& calibration) {
  for (const LandmarkClass landmark : perception::kLandmarkClasses) {
    auto& learnt = calibration.classes[static_cast<std::size_t>(landmark)];
    const auto of = [&](const std::function<std::optional<double>(const Lesson&)>& x) {
      return SamplesOf(lessons, landmark, x);
    };
    if (cameras == ViewCameras::kFront) {
      learnt.radius = TableOrGeometry(of([](const Lesson& lesson) { return lesson.radius_px; }),
                                      landmark, description.front_camera.focal_px, learnt.radius);
    } else {
      const auto shorter = of([](const Lesson& lesson) { return lesson.shorter_edges; });
      if (shorter.empty()) continue;
      learnt.shorter = FitEdges(shorter);
      learnt.longer = FitEdges(of([](const Lesson& lesson) { return lesson.longer_edges; }));
    }
  }
}

}  // namespace

perception::RadiusTable FitRadiusTable(const std::vector<Sample>& samples) {
  std::map<int, std::vector<Sample>> stretches;
  for (const Sample& sample : samples)
    stretches[static_cast<int>(sample.distance_m / kStretch_m)].push_back(sample);
  std::vector<WeighedSample> entries;
  for (const auto& [number, stretch] : stretches) {
    if (stretch.size() < kFewestOfStretch) continue;
    // Within a stretch radii fall as distances rise: their products are what is alike.
    std::vector<double> distances_m, products;
    for (const Sample& sample : stretch) {
      distances_m.push_back(sample.distance_m);
      products.push_back(sample.distance_m * sample.x);
    }
    const double distance_m = Quantile(distances_m, 0.5);
    entries.push_back(
        {{distance_m, Quantile(products, 0.5) / distance_m}, static_cast<double>(stretch.size())});
    while (entries.size() > 1 &&
           entries.back().mean.x >= entries[entries.size() - 2].mean.x - kLeastFall_px)
      PoolLastTwo(entries);
  }
  if (entries.size() < 2)
    throw std::invalid_argument("too few training views for a radius-distance table");
  perception::RadiusTable table;
  for (const auto& [mean, views] : entries)
    table.distance_radius.emplace_back(mean.distance_m, mean.x);
  return table;
}

perception::EdgeFit FitEdges(const std::vector<Sample>& samples) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const double n = static_cast<double>(samples.size());
  for (const Sample& sample : samples) {
    x += sample.x;
    y += sample.distance_m;
    xx += sample.x * sample.x;
    xy += sample.x * sample.distance_m;
  }
  const double spread = n * xx - x * x;
  if (!(spread > 0.0)) throw std::invalid_argument("a linear fit needs different numbers of edges");
  const double slope = (n * xy - x * y) / spread;
  return {(y - slope * x) / n, slope};
}

perception::ErrorFit FitErrors(const std::vector<StatedError>& errors) {
  if (errors.size() < kFewestErrors) return {};
  std::vector<double> shares;
  for (const StatedError& one : errors)
    shares.push_back(one.error_m / (one.distance_m + one.error_m));
  perception::ErrorFit fit;
  fit.bias = Quantile(shares, 0.5);
  std::vector<double> ratios;
  for (const StatedError& one : errors) {
    const double left_m = one.error_m - fit.bias * (one.distance_m + one.error_m);
    ratios.push_back(std::abs(left_m) / one.deviation_m);
  }
  fit.factor = Quantile(ratios, 0.95) / 1.96;
  return fit;
}

perception::LandmarkCalibration CalibrateLandmarks(const robot::Description& description,
                                                   perception::LandmarkParameters parameters,
                                                   const CalibrationOptions& options) {
  parameters.calibration = {};
  parameters.mono = parameters.stereo = LandmarkMethod::kOurs;
  perception::LandmarkCalibration calibration;
  std::mutex mutex;
  std::size_t done = 0;
  for (const ViewCameras cameras : {ViewCameras::kFront, ViewCameras::kStereo}) {
    const bool front = cameras == ViewCameras::kFront;
    std::vector<Lesson> thesis(options.views), ours(2 * options.views);
    for (const ViewSet set : {ViewSet::kReproduction, ViewSet::kStress}) {
      ForEachView(description, TrainingRequest(set, cameras, options), [&](LandmarkView&& view) {
        const bool stress = set == ViewSet::kStress;
        if (!stress) thesis[view.number] = ThesisLesson(view, cameras, description, parameters);
        Lesson& lesson = ours[view.number + (stress ? options.views : 0)];
        lesson.landmark = perception::ClassOf(view.plan.kind);
        const auto make = front ? perception::MakeMonoDistance : perception::MakeStereoDistance;
        lesson.stated = Ask(*make(description, parameters, view.plan.kind, view.sizes), view);
        const std::lock_guard lock(mutex);
        options.progress(++done, 4 * options.views);
      });
    }
    for (const LandmarkClass landmark : perception::kLandmarkClasses) {
      auto& learnt = calibration.classes[static_cast<std::size_t>(landmark)];
      (front ? learnt.mono : learnt.stereo) = FitErrors(ErrorsOf(ours, landmark));
    }
    FitThesis(thesis, cameras, description, calibration);
  }
  return calibration;
}

void CalibrateThesis(const robot::Description& description,
                     const perception::LandmarkParameters& parameters, ViewSet set,
                     ViewCameras cameras, const CalibrationOptions& options,
                     perception::LandmarkCalibration& calibration) {
  ViewRequest request = TrainingRequest(set, cameras, options);
  request.pictures = 1;
  std::vector<Lesson> lessons(options.views);
  std::mutex mutex;
  std::size_t done = 0;
  ForEachView(description, request, [&](LandmarkView&& view) {
    lessons[view.number] = ThesisLesson(view, cameras, description, parameters);
    const std::lock_guard lock(mutex);
    options.progress(++done, options.views);
  });
  FitThesis(lessons, cameras, description, calibration);
}

std::array<std::size_t, perception::kLandmarkClasses.size()> CalibrateThesisFromRecording(
    const robot::Description& description, const perception::LandmarkParameters& parameters,
    const std::filesystem::path& recording, perception::LandmarkCalibration& calibration) {
  std::array<std::size_t, perception::kLandmarkClasses.size()> views{};
  for (const ViewCameras cameras : {ViewCameras::kFront, ViewCameras::kStereo}) {
    std::vector<Lesson> lessons;
    ForEachRecordedView(recording, cameras, [&](LandmarkView&& view) {
      lessons.push_back(ThesisLesson(view, cameras, description, parameters));
    });
    std::array<std::size_t, perception::kLandmarkClasses.size()> counts{};
    for (const Lesson& lesson : lessons) ++counts.at(static_cast<std::size_t>(lesson.landmark));
    std::erase_if(lessons, [&](const Lesson& lesson) {
      return counts.at(static_cast<std::size_t>(lesson.landmark)) < kFewestOfClass;
    });
    FitThesis(lessons, cameras, description, calibration);
    for (std::size_t i = 0; i < views.size(); ++i) views.at(i) += counts.at(i);
  }
  if (views == decltype(views){})
    throw InputError(recording, {}, "", "shows no landmark whose distance the robot knew");
  return views;
}

}  // namespace kantaro::scenarios
