#include "scenarios/experiments/stereo_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/input_error.hpp"
#include "perception/parameters.hpp"
#include "scenarios/experiments/stereo_methods.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

/// A pair as it lies on disk: disparity = value / scale, 0 is unknown.
struct Source {
  const char* name;
  const char *left, *right, *left_disparity, *right_disparity;
  double scale;
  int disparities;  ///< the whole range of drange.txt
};
constexpr std::array<Source, 2> kSources{
    {{"cone", "im2.png", "im6.png", "disp2.png", "disp6.png", 4.0, 64},
     {"Reindeer", "view1.png", "view5.png", "disp1.png", "disp5.png", 2.0, 128}}};

struct RealPair {
  cv::Mat left, right;                      ///< 8-bit
  cv::Mat left_disparity, right_disparity;  ///< CV_32F, NaN: unknown
};

std::filesystem::path DataFolder(const ExperimentOptions& options) {
  const char* given = std::getenv("KANTARO_DATA");
  const std::filesystem::path data =
      given != nullptr ? given : options.robot_folder / "../../../shared/data";
  return data / "stereo";
}

cv::Mat ReadGrey(const std::filesystem::path& file) {
  cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw InputError(file, {}, "", "is no picture that can be read");
  return image;
}

cv::Mat ReadDisparity(const std::filesystem::path& file, double scale) {
  const cv::Mat values = ReadGrey(file);
  cv::Mat disparity;
  values.convertTo(disparity, CV_32F, 1.0 / scale);
  disparity.setTo(std::numeric_limits<float>::quiet_NaN(), values == 0);
  return disparity;
}

RealPair Read(const std::filesystem::path& folder, const Source& source) {
  const RealPair pair{ReadGrey(folder / source.left), ReadGrey(folder / source.right),
                      ReadDisparity(folder / source.left_disparity, source.scale),
                      ReadDisparity(folder / source.right_disparity, source.scale)};
  for (const cv::Mat* other : {&pair.right, &pair.left_disparity, &pair.right_disparity}) {
    if (other->size() != pair.left.size())
      throw InputError(folder, {}, "", "its pictures are not of one size");
  }
  return pair;
}

/// 255 where every method could answer and the right camera sees the point too: the right image's
/// disparity leads back to within a pixel.
cv::Mat Judged(const RealPair& pair, int disparities) {
  constexpr int kBorder = 11;  // half of StereoBM's window, the largest
  cv::Mat judged(pair.left.size(), CV_8U, cv::Scalar(0));
  for (int y = kBorder; y < judged.rows - kBorder; ++y) {
    for (int x = disparities + kBorder; x < judged.cols - kBorder; ++x) {
      const float there = pair.left_disparity.at<float>(y, x);
      if (std::isnan(there)) continue;
      const float back =
          pair.right_disparity.at<float>(y, x - static_cast<int>(std::lround(there)));
      judged.at<std::uint8_t>(y, x) = std::abs(there - back) <= 1.0F ? 255 : 0;
    }
  }
  return judged;
}

Json ToJson(const Source& source, const StereoMethod& method, const BadPixels& bad) {
  const auto share = [&](std::size_t count) {
    return bad.pixels == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(bad.pixels);
  };
  return {{"set", "middlebury"},           {"method", method.name},
          {"variant", method.variant},     {"landmark", "all"},
          {"condition", source.name},      {"views", 1},
          {"pixels", bad.pixels},          {"answered", share(bad.answered)},
          {"bad_1px", share(bad.off_1px)}, {"bad_2px", share(bad.off_2px)},
          {"mean_error_px", bad.error_px}};
}

/// What is required: on no pair is `ours` worse than StereoBM.
bool Passes(const Json& rows) {
  std::map<std::pair<std::string, std::string>, double> bad;
  for (const Json& row : rows) bad[{row.at("condition"), row.at("method")}] = row.at("bad_1px");
  return std::all_of(bad.begin(), bad.end(), [&](const auto& entry) {
    const auto rival = bad.find({entry.first.first, "stereobm"});
    return entry.first.second != "ours" || rival == bad.end() || entry.second <= rival->second;
  });
}

/// The methods as the thesis has them, and what is known to change their result.
std::vector<StereoMethod> Contestants(perception::stereo::Parameters parameters, int disparities,
                                      const std::vector<std::string>& only) {
  using perception::stereo::FunctionValueConstraint;
  using perception::stereo::Method;
  parameters.min_disparity_px = 0;
  parameters.disparities = disparities;
  const auto as_given = parameters;
  std::vector<StereoMethod> methods = StereoMethods(parameters);
  parameters.function_value_constraint = FunctionValueConstraint::kOff;
  methods.push_back(OneStereoMethod(parameters, Method::kCooperative, "constraint off"));
  parameters.function_value_constraint = FunctionValueConstraint::kInverted;
  methods.push_back(OneStereoMethod(parameters, Method::kCooperative, "constraint inverted"));
  parameters.gaussian_window_px = 1;
  methods.push_back(OneStereoMethod(parameters, Method::kSsd, "no smoothing"));
  methods.push_back(OneStereoMethod(parameters, Method::kNcc, "no smoothing"));
  parameters = as_given;
  parameters.corner_support = 0;
  methods.push_back(OneStereoMethod(parameters, Method::kFastCubic, "all corners"));
  return ChosenMethods(methods, only);
}

Json Run(const ExperimentOptions& options) {
  const perception::Parameters parameters =
      perception::ReadParameters(options.robot_folder / "perception.yaml");
  const std::filesystem::path folder = DataFolder(options);
  Json result{{"experiment", "stereo-pairs"},
              {"seed", options.seed},
              {"passed", true},
              {"rows", Json::array()},
              {"thesis", Json::array()}};
  std::size_t done = 0;
  for (const Source& source : kSources) {
    if (!std::filesystem::exists(folder / source.name)) {
      result["skipped"] =
          "The photographs are not here: they may not ship. Set KANTARO_DATA to a folder that "
          "holds stereo/cone and stereo/Reindeer.";
      continue;
    }
    const RealPair pair = Read(folder / source.name, source);
    const cv::Mat judged = Judged(pair, source.disparities);
    const auto methods = Contestants(parameters.stereo, source.disparities, options.only);
    for (const StereoMethod& method : methods) {
      result["rows"].push_back(
          ToJson(source, method,
                 CountBadPixels(method.match(pair.left, pair.right), pair.left_disparity, judged)));
      options.progress(++done, kSources.size() * methods.size());
    }
  }
  result["passed"] = Passes(result["rows"]);
  return result;
}

std::string NameOf(const Json& row) {
  const auto variant = row.at("variant").get<std::string>();
  return row.at("method").get<std::string>() + (variant.empty() ? "" : ", " + variant);
}

std::string Table(const Json& result) {
  if (result.contains("skipped")) return result.at("skipped").get<std::string>() + "\n";
  std::string text = fmt::format("{:<10}  {:<33}  {:>8}  {:>7}  {:>7}  {:>10}\n", "pair", "method",
                                 "answered", "bad 1px", "bad 2px", "mean error");
  for (const Json& row : result.at("rows")) {
    text += fmt::format(
        "{:<10}  {:<33}  {:>6.1f} %  {:>5.1f} %  {:>5.1f} %  {:>7.2f} px\n",
        row.at("condition").get<std::string>(), NameOf(row),
        100.0 * row.at("answered").get<double>(), 100.0 * row.at("bad_1px").get<double>(),
        100.0 * row.at("bad_2px").get<double>(), row.at("mean_error_px").get<double>());
  }
  return text + fmt::format("stereo-pairs: {}\n", result.at("passed") ? "passed" : "FAILED");
}

std::string Chapter(const Json& result) {
  std::string text =
      "## Stereo on photographs\n\nThe matchers on two pairs of the Middlebury benchmark (D. "
      "Scharstein and R. Szeliski, 2003 and 2006), which the thesis does not use: its methods are "
      "made for pipes. Bad is a pixel off by more than 1 or 2 px *or without an answer*, among "
      "those that both cameras see and every method could match.\n\n";
  if (result.contains("skipped")) return text + result.at("skipped").get<std::string>() + "\n";
  text +=
      "| pair | method | answered | bad 1 px | bad 2 px | mean error "
      "|\n|---|---|---|---|---|---|\n";
  for (const Json& row : result.at("rows")) {
    text += fmt::format(
        "| {} | `{}` | {:.1f} % | {:.1f} % | {:.1f} % | {:.2f} px |\n",
        row.at("condition").get<std::string>(), NameOf(row),
        100.0 * row.at("answered").get<double>(), 100.0 * row.at("bad_1px").get<double>(),
        100.0 * row.at("bad_2px").get<double>(), row.at("mean_error_px").get<double>());
  }
  return text;
}

}  // namespace

Experiment StereoPairsExperiment() {
  return {"stereo-pairs", "chapter 5's matchers on photographs, beside OpenCV's", Run, Table,
          Chapter};
}

}  // namespace kantaro::scenarios
