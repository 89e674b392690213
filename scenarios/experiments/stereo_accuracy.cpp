#include "scenarios/experiments/stereo_accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "base/files.hpp"
#include "base/random.hpp"
#include "perception/parameters.hpp"
#include "perception/stereo/linear_computation.hpp"
#include "scenarios/experiments/bar_plot.hpp"
#include "scenarios/experiments/stereo_methods.hpp"
#include "scenarios/experiments/stereo_views.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using perception::stereo::CornerDisparity;
using perception::stereo::FunctionValueConstraint;
using perception::stereo::Method;
using perception::stereo::Parameters;

constexpr std::size_t kViews = 10;  ///< of each light and pipe
constexpr double kNearest_m = 0.35, kFarthest_m = 1.5;
constexpr double kAtMouth_m = 0.05;
constexpr int kMinDisparity = 16, kDisparities = 112;  ///< 0.26 to 2.1 m
constexpr int kBorder = 11;                            ///< half of StereoBM's window, the largest
constexpr int kSquares = 60, kSquare_px = 8;
constexpr double kMostCubic_m = 0.02, kUpTo_m = 1.0;
constexpr const char* kNear = "up to 1.0 m";
constexpr const char* kBias = "leans by";
constexpr const char* kRivalAnswers = "where stereobm answers";

const std::vector<std::pair<std::string, double>> kLights{{"bright", 1.0}, {"dimmed", 0.3}};
const std::vector<double> kDiameters_m{0.250, 0.300};

/// What of the pixels of a group was measured.
struct Errors {
  std::size_t pixels{}, answered{}, within_2cm{}, within_5cm{};
  double sum_m{};
  std::vector<float> errors_px;  ///< of those answered, positive where read too near

  void Add(float disparity_px, double scale, double depth_m) {
    ++pixels;
    if (std::isnan(disparity_px)) return;
    ++answered;
    const double error_m = std::abs(scale / disparity_px - depth_m);
    within_2cm += error_m <= 0.02 ? 1 : 0;
    within_5cm += error_m <= 0.05 ? 1 : 0;
    sum_m += error_m;
    errors_px.push_back(static_cast<float>(disparity_px - scale / depth_m));
  }
  [[nodiscard]] double MedianError_px() const {
    std::vector<float> errors = errors_px;
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  }
};

/// A pixel to be measured.
struct Sample {
  int x{}, y{};
  bool feature{};
};

/// The methods as the parameters have them, and the readings that the thesis leaves open.
std::vector<StereoMethod> Contestants(Parameters parameters, const std::vector<std::string>& only) {
  parameters.min_disparity_px = kMinDisparity;
  parameters.disparities = kDisparities;
  std::vector<StereoMethod> methods = StereoMethods(parameters);
  const auto add = [&](Method method, const std::string& variant, auto change) {
    Parameters changed = parameters;
    change(changed);
    methods.push_back(OneStereoMethod(changed, method, variant));
  };
  const auto unchecked = [](Parameters& p) { p.corner_support = 0; };
  add(Method::kCooperative, "constraint off",
      [](Parameters& p) { p.function_value_constraint = FunctionValueConstraint::kOff; });
  add(Method::kCooperative, "constraint inverted",
      [](Parameters& p) { p.function_value_constraint = FunctionValueConstraint::kInverted; });
  for (const Method method : {Method::kFastNearest, Method::kFastLinear, Method::kFastCubic})
    add(method, "all corners", unchecked);
  add(Method::kFastCubic, "sub-pixel", [](Parameters& p) { p.subpixel = true; });
  add(Method::kFastCubic, "average",
      [](Parameters& p) { p.corner_disparity = CornerDisparity::kAverage; });
  using Pictures = StereoMethod::Pictures;
  for (const auto& [pictures, name] :
       {std::pair<Pictures, std::string>(Pictures::kFalloff, "falloff left in"),
        std::pair<Pictures, std::string>(Pictures::kIdeal, "ideal pictures")}) {
    const std::size_t given = methods.size();
    for (const Method method : {Method::kSsd, Method::kNcc, Method::kFastCubic, Method::kOurs})
      add(method, name, [](Parameters&) {});
    for (const Method method : {Method::kFastNearest, Method::kFastLinear, Method::kFastCubic})
      add(method, "all corners, " + name, unchecked);
    for (std::size_t m = given; m < methods.size(); ++m) methods[m].pictures = pictures;
  }
  return ChosenMethods(methods, only);
}

const robot::StereoPair& PicturesFor(const StereoMethod& method, const StereoView& view) {
  switch (method.pictures) {
    case StereoMethod::Pictures::kFlat:
      return view.flat;
    case StereoMethod::Pictures::kFalloff:
      return view.rectified;
    case StereoMethod::Pictures::kIdeal:
      return view.ideal;
  }
  throw std::invalid_argument("no such pictures");
}

/// Squares drawn by chance on the wall at the mouth, where every method could answer.
std::vector<Sample> Samples(const StereoView& view, const Parameters& parameters,
                            RandomStream& random) {
  // Before smoothing: after it, no pixel of these views differs from its neighbour by T0.
  const cv::Mat features =
      perception::stereo::FeaturePixels(view.rectified.left, parameters.feature_threshold);
  const auto at_mouth = [&](int x, int y) {
    return std::abs(view.depth_m.at<float>(y, x) - view.mouth_m) <= kAtMouth_m;
  };
  const int first = kMinDisparity + kDisparities + kBorder;
  std::vector<cv::Point> corners;
  for (int y = kBorder; y < view.depth_m.rows - kBorder - kSquare_px; ++y) {
    for (int x = first; x < view.depth_m.cols - kBorder - kSquare_px; ++x) {
      if (at_mouth(x, y)) corners.emplace_back(x, y);
    }
  }
  std::vector<Sample> samples;
  for (int i = 0; i < kSquares && !corners.empty(); ++i) {
    const cv::Point corner = corners[random.Index(corners.size())];
    for (int y = corner.y; y < corner.y + kSquare_px; ++y) {
      for (int x = corner.x; x < corner.x + kSquare_px; ++x) {
        if (at_mouth(x, y)) samples.push_back({x, y, features.at<std::uint8_t>(y, x) != 0});
      }
    }
  }
  return samples;
}

/// Groups of one method, by landmark and condition; the pooled one is ("all", "all").
using Groups = std::map<std::pair<std::string, std::string>, Errors>;

/// @param rival  StereoBM's disparities, or empty: it answers on few pixels, and a mean over those
///        alone says little beside a mean over nearly all.
void Measure(const StereoView& view, const std::vector<Sample>& samples, const cv::Mat& disparity,
             const cv::Mat& rival, const std::string& light, Groups& groups) {
  const double scale = view.focal_px * view.baseline_m;
  for (const Sample& sample : samples) {
    const auto add = [&](const std::string& landmark, const std::string& condition) {
      groups[{landmark, condition}].Add(disparity.at<float>(sample.y, sample.x), scale,
                                        view.depth_m.at<float>(sample.y, sample.x));
    };
    add("all", "all");
    add("manhole", light + (sample.feature ? ", feature" : ", non-feature"));
    if (view.mouth_m <= kUpTo_m) {
      add("manhole", kNear);
      if (sample.feature) add("manhole", "up to 1.0 m, feature");
    }
    if (!rival.empty() && !std::isnan(rival.at<float>(sample.y, sample.x)))
      add("manhole", kRivalAnswers);
  }
}

Json ToJson(const StereoMethod& method, const std::pair<std::string, std::string>& group,
            const Errors& errors, std::size_t views) {
  const auto share = [&](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(errors.pixels);
  };
  Json row{{"set", "reproduction"},
           {"method", method.name},
           {"variant", method.variant},
           {"landmark", group.first},
           {"condition", group.second},
           {"views", views},
           {"pixels", errors.pixels},
           {"answered", share(errors.answered)},
           {"within_2cm", share(errors.within_2cm)},
           {"within_5cm", share(errors.within_5cm)},
           {"mean_error_m", nullptr},
           {"median_error_px", nullptr}};
  if (errors.answered > 0) {
    row["mean_error_m"] = errors.sum_m / static_cast<double>(errors.answered);
    row["median_error_px"] = errors.MedianError_px();
  }
  return row;
}

/// What is required of a row's mean error, if anything: see kMostCubic_m, and less than StereoBM's
/// where that answers.
std::optional<double> Limit_m(const Json& row, const Json& rows) {
  if (row.at("method") != "fast-cubic" || row.at("variant") != "") return {};
  if (row.at("condition") == kNear) return kMostCubic_m;
  if (row.at("condition") != kRivalAnswers) return {};
  const auto rival = std::find_if(rows.begin(), rows.end(), [](const Json& other) {
    return other.at("method") == "stereobm" && other.at("condition") == kRivalAnswers;
  });
  return rival == rows.end() ? std::optional<double>() : rival->at("mean_error_m");
}

bool Fails(const Json& row, const Json& rows) {
  const std::optional<double> limit_m = Limit_m(row, rows);
  const Json& error_m = row.at("mean_error_m");
  return limit_m && !(error_m.is_number() && error_m.get<double>() <= *limit_m);
}

Json Thesis() {
  const auto claim = [](const char* section, const char* words) {
    return Json{{"section", section}, {"claim", words}, {"figure", nullptr}};
  };
  return {
      claim("fig 5.10", "in feature pixels LC errs significantly less than gradient"),
      claim("fig 5.11",
            "in non-feature pixels SSD with constraints errs significantly less "
            "than SSD"),
      claim("fig 5.20", "fast stereo errs significantly less than SSD and cross-correlation"),
      claim("Table 5.2, fig 5.21", "mean errors: nearest 14.7 cm, linear 7.4 cm, cubic 5.3 cm")};
}

cv::Mat OfStereoBm(const std::vector<StereoMethod>& methods,
                   const std::vector<cv::Mat>& disparities) {
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (methods[m].name == "stereobm") return disparities[m];
  }
  return {};
}

std::string NameOf(const Json& row) {
  const auto variant = row.at("variant").get<std::string>();
  return row.at("method").get<std::string>() + (variant.empty() ? "" : ", " + variant);
}

/// Fig 5.20 and 5.21: mean errors up to 1.0 m.
std::string Plot(const Json& rows) {
  constexpr double kLongest_m = 0.12;
  std::vector<Bar> bars;
  for (const Json& row : rows) {
    if (row.at("condition") != kNear || row.at("mean_error_m").is_null()) continue;
    const double error_m = row.at("mean_error_m");
    bars.push_back({NameOf(row),
                    fmt::format("{:.1f} cm on {:.0f} % of the pixels", 100.0 * error_m,
                                100.0 * row.at("answered").get<double>()),
                    error_m / kLongest_m,
                    row.at("method") == "fast-cubic" && row.at("variant") == ""});
  }
  return PlotBars("Mean error of stereo distances up to 1.0 m", bars, kMostCubic_m / kLongest_m,
                  "2 cm");
}

Json Run(const ExperimentOptions& options) {
  const robot::Description description = robot::ReadDescription(options.robot_folder);
  const Parameters parameters =
      perception::ReadParameters(options.robot_folder / "perception.yaml").stereo;
  const auto methods = Contestants(parameters, options.only);
  const std::size_t count = options.count == 0 ? kViews : options.count;
  const std::size_t all = count * kDiameters_m.size() * kLights.size();
  std::vector<Groups> groups(methods.size());
  std::size_t done = 0;
  for (const double diameter_m : kDiameters_m) {
    StereoStage stage(description, diameter_m, options.seed);
    for (const auto& [light, brightness] : kLights) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::string stream =
            fmt::format("stereo-accuracy.{:.0f}.{}.{}", 1000.0 * diameter_m, light, i);
        RandomStream random(options.seed, stream);
        const double distance_m = random.Uniform(kNearest_m, kFarthest_m);
        const StereoView view = stage.See(distance_m, brightness, options.seed, stream);
        const std::vector<Sample> samples = Samples(view, parameters, random);
        std::vector<cv::Mat> disparities(methods.size());
        ForEachInParallel(methods.size(), options.jobs, [&](std::size_t m) {
          const robot::StereoPair& pair = PicturesFor(methods[m], view);
          disparities[m] = methods[m].match(pair.left, pair.right);
        });
        const cv::Mat rival = OfStereoBm(methods, disparities);
        for (std::size_t m = 0; m < methods.size(); ++m)
          Measure(view, samples, disparities[m], rival, light, groups[m]);
        options.progress(++done, all);
      }
    }
  }
  Json rows = Json::array();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    for (const auto& [group, errors] : groups[m])
      rows.push_back(ToJson(methods[m], group, errors, all));
  }
  const bool passed =
      std::none_of(rows.begin(), rows.end(), [&](const Json& row) { return Fails(row, rows); });
  if (!options.out.empty()) WriteFileAtomically(options.out / "stereo-accuracy.svg", Plot(rows));
  return {{"experiment", "stereo-accuracy"},
          {"seed", options.seed},
          {"passed", passed},
          {"rows", rows},
          {"thesis", Thesis()}};
}

std::string Centimetres(const Json& row) {
  return row.at("mean_error_m").is_null()
             ? "none"
             : fmt::format("{:.1f} cm", 100.0 * row.at("mean_error_m").get<double>());
}

/// Positive where half of the pixels or more are read too near.
std::string Pixels(const Json& row) {
  return row.at("median_error_px").is_null()
             ? "none"
             : fmt::format("{:+.2f} px", row.at("median_error_px").get<double>());
}

std::string Table(const Json& result) {
  std::string text =
      fmt::format("{:<41}  {:<22}  {:>8}  {:>10}  {:>9}  {:>9}  {:>9}\n", "method", "condition",
                  "answered", "mean error", "in 2 cm", "in 5 cm", "median");
  for (const Json& row : result.at("rows")) {
    text += fmt::format("{:<41}  {:<22}  {:>6.1f} %  {:>10}  {:>7.1f} %  {:>7.1f} %  {:>9}{}\n",
                        NameOf(row), row.at("condition").get<std::string>(),
                        100.0 * row.at("answered").get<double>(), Centimetres(row),
                        100.0 * row.at("within_2cm").get<double>(),
                        100.0 * row.at("within_5cm").get<double>(), Pixels(row),
                        Fails(row, result.at("rows")) ? "  FAIL" : "");
  }
  return text + fmt::format("stereo-accuracy seed {}: {}\n", result.at("seed").get<std::uint64_t>(),
                            result.at("passed") ? "passed" : "FAILED");
}

/// One line for each method: mean error and answers by condition, and how it leans.
std::string Matrix(const Json& result) {
  std::vector<std::string> conditions, methods;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  const auto note = [](std::vector<std::string>& list, const std::string& name) {
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  };
  for (const Json& row : result.at("rows")) {
    const auto condition = row.at("condition").get<std::string>();
    note(conditions, condition);
    note(methods, NameOf(row));
    cells[{NameOf(row), condition}] =
        fmt::format("{}, {:.0f} %", Centimetres(row), 100.0 * row.at("answered").get<double>());
    if (condition == kNear) cells[{NameOf(row), kBias}] = Pixels(row);
  }
  conditions.push_back(kBias);
  std::string text = "| method |", rule = "|---|";
  for (const std::string& condition : conditions) {
    text += " " + condition + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const std::string& method : methods) {
    text += "| `" + method + "` |";
    for (const std::string& condition : conditions) text += " " + cells[{method, condition}] + " |";
    text += "\n";
  }
  return text;
}

std::string Chapter(const Json& result) {
  std::string text = fmt::format(
      "## Stereo: distance error\n\nMean error of the distance, and the share of pixels that got "
      "one, on squares of 8 x 8 pixels drawn by chance on the wall within {:.0f} mm of a manhole's "
      "mouth, {:.2f} to {:.2f} m ahead, in dry plastic pipes of 250 and 300 mm. Feature pixels are "
      "those of eq. 5.1 before smoothing; after it there are none. Dimmed is {:.0f} % of the "
      "light. The last column is the median error of the disparity up to 1.0 m, positive where "
      "read "
      "too near. Seed {}.\n\n",
      1000.0 * kAtMouth_m, kNearest_m, kFarthest_m, 100.0 * kLights[1].second,
      result.at("seed").get<std::uint64_t>());
  text += Matrix(result) + "\nThe thesis says:\n\n";
  for (const Json& claim : result.at("thesis")) {
    text += fmt::format("- {}: {}\n", claim.at("section").get<std::string>(),
                        claim.at("claim").get<std::string>());
  }
  return text;
}

}  // namespace

Experiment StereoAccuracyExperiment() {
  return {"stereo-accuracy", "figs 5.10, 5.11, 5.20, 5.21, Table 5.2: how far stereo distances err",
          Run, Table, Chapter};
}

}  // namespace kantaro::scenarios
