#include "scenarios/experiments/ring_photographs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "perception/parameters.hpp"
#include "perception/ring_finder.hpp"
#include "perception/thesis_landmarks.hpp"
#include "scenarios/experiments/wilson.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using perception::LandmarkKind;

/// Neither the camera nor the pipe is known, so distances mean nothing: this camera in this pipe
/// only bounds the radii that are looked for, which are those from 18 to 150 px, as labelled.
constexpr double kFocal_px = 300.0, kPipe_m = 0.300, kNearest_m = 0.30, kFarthest_m = 2.50;
constexpr int kCenterSearch_px = 40;  ///< the photographs' cameras look about
constexpr double kLeastShared = 0.5;

struct Photograph {
  cv::Mat brightness;
  std::vector<cv::Rect2d> joints;
};
struct Circle {
  cv::Point2d center;
  double radius_px{};
};
using Circles = std::vector<Circle>;

/// The boxes of class 0 in lines "class cx cy w h", as shares of the picture.
std::vector<cv::Rect2d> ReadJoints(const std::filesystem::path& file, cv::Size size) {
  std::vector<cv::Rect2d> joints;
  std::istringstream lines(ReadInputFile(file));
  int line = 0;
  for (std::string text; std::getline(lines, text);) {
    ++line;
    std::istringstream words(text);
    int label = 0;
    double x = 0.0, y = 0.0, width = 0.0, height = 0.0;
    if (!(words >> label >> x >> y >> width >> height))
      throw InputError(file, line, "", "a label is \"class cx cy w h\"");
    if (label == 0) {
      joints.emplace_back((x - width / 2.0) * size.width, (y - height / 2.0) * size.height,
                          width * size.width, height * size.height);
    }
  }
  return joints;
}

std::vector<Photograph> ReadPhotographs(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return {};
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  std::vector<Photograph> photographs;
  for (const std::filesystem::path& file : files) {
    Photograph photograph{cv::imread(file.string(), cv::IMREAD_GRAYSCALE), {}};
    if (photograph.brightness.empty())
      throw InputError(file, {}, "", "is no picture that can be read");
    photograph.joints = ReadJoints(std::filesystem::path(file).replace_extension(".txt"),
                                   photograph.brightness.size());
    photographs.push_back(std::move(photograph));
  }
  return photographs;
}

robot::Camera CameraOf(const cv::Mat& image) {
  robot::Camera camera;
  camera.width_px = image.cols;
  camera.height_px = image.rows;
  camera.focal_px = kFocal_px;
  camera.center_x_px = (image.cols - 1) / 2.0;
  camera.center_y_px = (image.rows - 1) / 2.0;
  return camera;
}

/// The rings that missions use: any number of them.
Circles OurRings(const cv::Mat& image, const perception::Parameters& parameters) {
  perception::RingParameters rings = parameters.rings;
  rings.near_m = kNearest_m;
  rings.far_m = kFarthest_m;
  rings.center_search_px = kCenterSearch_px;
  Circles circles;
  for (const auto& ring : perception::FindRings(image, CameraOf(image), kPipe_m / 2.0, rings))
    circles.push_back({{ring.center_x_px, ring.center_y_px}, ring.radius_px});
  return circles;
}

/// Thesis 4.3: the strongest circle.
Circles ThesisRing(const cv::Mat& image, const perception::Parameters& parameters) {
  perception::LandmarkParameters landmarks = parameters.landmarks;
  landmarks.near_m = kNearest_m;
  landmarks.far_m = kFarthest_m;
  const auto circle = perception::ThesisCircle(image, CameraOf(image), landmarks,
                                               LandmarkKind::kJoint, {kPipe_m, 0.0});
  if (circle.votes == 0) return {};
  return {{circle.center, circle.radius_px}};
}

Json RowOf(const char* method, const std::vector<Photograph>& photographs,
           const std::vector<Circles>& found) {
  std::size_t labelled = 0, seen = 0, circles = 0, right = 0, pictures = 0;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    const Photograph& photograph = photographs[i];
    const auto is = [&](const Circle& circle, const cv::Rect2d& joint) {
      return IsLabelled(circle.center, circle.radius_px, joint, photograph.brightness.size());
    };
    const auto seen_here = std::ranges::count_if(photograph.joints, [&](const cv::Rect2d& joint) {
      return std::ranges::any_of(found[i], [&](const Circle& circle) { return is(circle, joint); });
    });
    right += std::ranges::count_if(found[i], [&](const Circle& circle) {
      return std::ranges::any_of(photograph.joints,
                                 [&](const cv::Rect2d& joint) { return is(circle, joint); });
    });
    labelled += photograph.joints.size();
    seen += static_cast<std::size_t>(seen_here);
    circles += found[i].size();
    pictures += seen_here > 0 ? 1 : 0;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? Json(nullptr)
                      : Json(static_cast<double>(part) / static_cast<double>(whole));
  };
  const Rate joints = WilsonRate(seen, labelled);
  return {{"set", "photographs"},
          {"method", method},
          {"landmark", "joint"},
          {"condition", "all"},
          {"views", photographs.size()},
          {"labelled", labelled},
          {"found", share(seen, labelled)},
          {"found_interval", {joints.low, joints.high}},
          {"circles", circles},
          {"circles_on_label", share(right, circles)},
          {"views_with_one_found", pictures}};
}

Json Run(const ExperimentOptions& options) {
  const auto parameters = perception::ReadParameters(options.robot_folder / "perception.yaml");
  Json result{{"experiment", "ring-photographs"},
              {"seed", options.seed},
              {"passed", true},
              {"rows", Json::array()},
              {"thesis", Json::array()}};
  const std::vector<Photograph> photographs = ReadPhotographs(options.photos);
  if (photographs.empty()) {
    result["skipped"] =
        "no photographs: they are not part of this project; --photos names their folder";
    return result;
  }
  std::vector<Circles> ours(photographs.size()), thesis(photographs.size());
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    ours[i] = OurRings(photographs[i].brightness, parameters);
    thesis[i] = ThesisRing(photographs[i].brightness, parameters);
    options.progress(i + 1, photographs.size());
  }
  result["rows"].push_back(RowOf("ours", photographs, ours));
  result["rows"].push_back(RowOf("thesis", photographs, thesis));
  return result;
}

std::string LineOf(const Json& row) {
  const auto percent = [&](const char* key) {
    return row.at(key).is_null() ? 0.0 : 100.0 * row.at(key).get<double>();
  };
  const Json& interval = row.at("found_interval");
  return fmt::format(
      "`{}`: {:.1f} % ({:.1f} to {:.1f}) of {} labelled joints in {} photographs, at least one in "
      "{} "
      "of them; {} circles in all, {:.1f} % of them on a label",
      row.at("method").get<std::string>(), percent("found"), 100.0 * interval[0].get<double>(),
      100.0 * interval[1].get<double>(), row.at("labelled").get<std::size_t>(),
      row.at("views").get<std::size_t>(), row.at("views_with_one_found").get<std::size_t>(),
      row.at("circles").get<std::size_t>(), percent("circles_on_label"));
}

std::string Lines(const Json& result, const char* before) {
  if (result.contains("skipped")) return result.at("skipped").get<std::string>() + "\n";
  std::string text;
  for (const Json& row : result.at("rows")) text += before + LineOf(row) + "\n";
  return text;
}

std::string Table(const Json& result) { return Lines(result, ""); }

std::string Chapter(const Json& result) {
  return "## Rings in photographs\n\nPhotographs of real sewers with labelled joints, which the "
         "thesis does not use. Neither camera nor pipe is known: what counts is whether a circle's "
         "box shares half with a label's. Not every joint that can be seen is labelled.\n\n" +
         Lines(result, "- ");
}

}  // namespace

bool IsLabelled(cv::Point2d center, double radius_px, const cv::Rect2d& label, cv::Size picture) {
  const cv::Rect2d whole(0.0, 0.0, picture.width, picture.height);
  const cv::Rect2d box =
      cv::Rect2d(center.x - radius_px, center.y - radius_px, 2.0 * radius_px, 2.0 * radius_px) &
      whole;
  const double shared = (box & label).area();
  return shared >= kLeastShared * (box.area() + label.area() - shared);
}

Experiment RingPhotographsExperiment() {
  return {"ring-photographs",
          "the ring finders on photographs of sewers (--photos)",
          Run,
          Table,
          Chapter,
          true};
}

}  // namespace kantaro::scenarios
