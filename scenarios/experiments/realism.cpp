#include "scenarios/experiments/realism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "base/random.hpp"
#include "scenarios/experiments/image_statistics.hpp"
#include "scenarios/experiments/pipe_scan.hpp"
#include "scenarios/experiments/realism_scenes.hpp"
#include "sim/renderer.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kFrames = 68;

// ---------------------------------------------------------------- pictures

/// Files of a folder that end so, by name; none if there is no such folder.
std::vector<std::filesystem::path> FilesIn(const std::filesystem::path& folder,
                                           const std::string& ending) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// A photograph and, from the text file of its name, the boxes of class 0, the joints.
LabelledImage ReadPhotograph(const std::filesystem::path& file) {
  LabelledImage photograph{cv::imread(file.string(), cv::IMREAD_COLOR), {}};
  if (photograph.image.size() != kStatisticsSize) {
    throw InputError(file, {}, "",
                     fmt::format("not a picture of {} x {} pixels", kStatisticsSize.width,
                                 kStatisticsSize.height));
  }
  const std::filesystem::path labels = std::filesystem::path(file).replace_extension(".txt");
  if (!std::filesystem::exists(labels)) return photograph;
  std::istringstream lines(ReadInputFile(labels));
  int kind = 0;
  for (double x{}, y{}, w{}, h{}; lines >> kind >> x >> y >> w >> h;) {
    if (kind != 0) continue;
    photograph.joints.emplace_back((x - w / 2.0) * kStatisticsSize.width,
                                   (y - h / 2.0) * kStatisticsSize.height,
                                   w * kStatisticsSize.width, h * kStatisticsSize.height);
  }
  return photograph;
}

std::vector<ImageStatistics> StatisticsOfAll(const std::vector<LabelledImage>& images) {
  std::vector<ImageStatistics> statistics;
  for (const LabelledImage& image : images) statistics.push_back(StatisticsOf(image));
  return statistics;
}

/// The mean distance between two halves of the photographs, over random ways to halve them: what
/// is left between sets that differ by chance alone.
double Yardstick(const Measure& measure, std::vector<ImageStatistics> photographs,
                 RandomStream random) {
  constexpr int kWays = 40;
  const auto half = static_cast<std::ptrdiff_t>(photographs.size() / 2);
  double sum = 0.0;
  for (int way = 0; way < kWays; ++way) {
    for (std::size_t i = photographs.size() - 1; i > 0; --i)
      std::swap(photographs[i], photographs[random.Index(i + 1)]);
    const std::span<const ImageStatistics> all = photographs;
    sum += measure.distance(MeanOf(all.first(static_cast<std::size_t>(half))),
                            MeanOf(all.subspan(static_cast<std::size_t>(half))));
  }
  return sum / kWays;
}

/// Pictures in pairs, the twin's on the left.
void WriteSheet(const std::filesystem::path& file, const std::vector<LabelledImage>& twin,
                const std::vector<LabelledImage>& photographs) {
  constexpr int kPairs = 3, kRows = 11, kRim_px = 4;
  const cv::Size cell(kStatisticsSize.width + kRim_px, kStatisticsSize.height + kRim_px);
  cv::Mat sheet(kRows * cell.height, 2 * kPairs * cell.width, CV_8UC3, cv::Scalar::all(255));
  const auto put = [&](const std::vector<LabelledImage>& images, int pair, int column) {
    if (pair >= static_cast<int>(images.size())) return;
    const cv::Point corner((2 * (pair % kPairs) + column) * cell.width,
                           pair / kPairs * cell.height);
    images[static_cast<std::size_t>(pair)].image.copyTo(sheet(cv::Rect(corner, kStatisticsSize)));
  };
  for (int pair = 0; pair < kPairs * kRows; ++pair) {
    put(twin, pair, 0);
    put(photographs, pair, 1);
  }
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", sheet, bytes, {cv::IMWRITE_JPEG_QUALITY, 92});
  WriteFileAtomically(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Json ToJson(const ImageStatistics& s) {
  const auto mean = [](const std::vector<double>& histogram, double low, double step) {
    double sum = 0.0;
    for (std::size_t i = 0; i < histogram.size(); ++i)
      sum += histogram[i] * (low + step * (static_cast<double>(i) + 0.5));
    return sum;
  };
  return {{"radial_levels", s.radial},
          {"gradient_levels_px", mean(s.gradient, 0.0, kGradientStep)},
          {"saturation", mean(s.saturation, 0.0, 1.0 / 32.0)},
          {"lightness", mean(s.lightness, 0.0, 2.0)},
          {"lab_a", mean(s.lab_a, -64.0, kLabStep)},
          {"lab_b", mean(s.lab_b, -64.0, kLabStep)},
          {"joint_contrast", mean(s.joint, -20.5 * kJointStep, kJointStep)},
          {"bright_joints",
           [&] {
             double share = 0.0;
             for (std::size_t i = 21; i < s.joint.size(); ++i) share += s.joint[i];
             return share;
           }()},
          {"spectrum_dB", s.spectrum_dB}};
}

void ComparePictures(const ExperimentOptions& options, const robot::Description& robot,
                     Json& result) {
  const std::size_t count = options.count == 0 ? kFrames : options.count;
  std::vector<LabelledImage> twin(count);
  std::mutex mutex;
  std::size_t done = 0;
  ForEachInParallel(count, options.jobs, [&](std::size_t i) {
    twin[i] = TwinFrame(robot, options.seed, i);
    const std::lock_guard lock(mutex);
    options.progress(++done, count);
  });
  std::vector<LabelledImage> photographs;
  for (const std::filesystem::path& file : FilesIn(options.photos, ".png"))
    photographs.push_back(ReadPhotograph(file));
  if (!options.out.empty()) WriteSheet(options.out / "realism.jpg", twin, photographs);

  const std::vector<ImageStatistics> twins = StatisticsOfAll(twin);
  result["twin"] = ToJson(MeanOf(twins));
  result["twin"]["frames"] = count;
  if (photographs.size() < 4) return;
  const std::vector<ImageStatistics> real = StatisticsOfAll(photographs);
  result["photographs"] = ToJson(MeanOf(real));
  result["photographs"]["frames"] = real.size();
  for (const Measure& measure : Measures()) {
    const double distance = measure.distance(MeanOf(twins), MeanOf(real));
    const double yardstick = Yardstick(measure, real, RandomStream(options.seed, "halves"));
    result["rows"].push_back({{"measure", measure.name},
                              {"unit", measure.unit},
                              {"distance", distance},
                              {"photographs_halves", yardstick},
                              {"ratio", distance / yardstick}});
  }
}

// ---------------------------------------------------------------- scans

struct ScanFile {
  const char* name;
  double nominal_m;
};
constexpr ScanFile kScans[] = {{"180mm_light.ply", 0.180},
                               {"pvc_200mm_840x480_light_cloud13.ply", 0.200},
                               {"pvc_200mm_840x480_nolight_cloud15.ply", 0.200},
                               {"340mm_light.ply", 0.340}};

/// The twin's depth in a straight pipe of the scan's radius, with the camera where the scan's was.
cv::Mat TwinDepth(const PipeScan& scan, const sim::CameraView& camera) {
  network::Network network;
  network.name = "scan";
  for (const double x_m : {-3.0, 3.0}) {
    network::Manhole manhole;
    manhole.name = x_m < 0.0 ? "up" : "down";
    manhole.p_WM = {x_m, 0.0, 0.0};
    network.manholes.push_back(manhole);
  }
  network::Pipe pipe;
  pipe.name = "pipe";
  pipe.upstream = "up";
  pipe.downstream = "down";
  pipe.diameter_m = 2.0 * scan.radius_m;
  network.pipes.push_back(pipe);
  const sim::World world = sim::BuildWorld(network, 1, true);
  sim::RendererOptions options;
  options.max_width_px = camera.width_px;
  options.max_height_px = camera.height_px;
  sim::Renderer renderer(world.scenery, options);
  // From the scan's axes (y up, z back) to the twin's optical ones.
  const Eigen::Isometry3d X_DC(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  sim::CameraView view = camera;
  view.X_WC = world.sewer->axes.front().PoseAt(2.0) * scan.X_DP.inverse() * X_DC;
  return renderer.RenderDepth(view);
}

/// What separates the scan from the twin along each of the scan's rays.
struct DepthErrors {
  std::vector<double> near_m, far_m;  ///< scan less twin, nearer and farther than 0.25 m
};

sim::CameraView ScansCamera() {
  sim::CameraView camera;  // a pinhole that holds the scans' whole view
  camera.width_px = 848;
  camera.height_px = 480;
  camera.focal_px = 424.0;
  camera.center_x_px = 423.5;
  camera.center_y_px = 239.5;
  return camera;
}

Eigen::Vector2d PixelOf(const sim::CameraView& camera, const Eigen::Vector3d& p_D) {
  return {camera.center_x_px + camera.focal_px * p_D.x() / -p_D.z(),
          camera.center_y_px + camera.focal_px * p_D.y() / p_D.z()};
}

DepthErrors Compare(const PipeScan& scan, const cv::Mat& depth_m, const sim::CameraView& camera) {
  DepthErrors errors;
  for (const Eigen::Vector3d& p : scan.inliers) {
    const Eigen::Vector2d at = PixelOf(camera, p);
    const cv::Point pixel(cvRound(at.x()), cvRound(at.y()));
    if (!cv::Rect({0, 0}, depth_m.size()).contains(pixel)) continue;
    const double twin_m = depth_m.at<float>(pixel);
    if (twin_m <= 0.0) continue;
    (twin_m < 0.25 ? errors.near_m : errors.far_m).push_back(-p.z() - twin_m);
  }
  return errors;
}

/// The twin's depth as points at the scan's pixels.
std::vector<Eigen::Vector3d> PointsOf(const cv::Mat& depth_m, const sim::CameraView& camera) {
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < depth_m.rows; row += 2) {
    for (int col = 0; col < depth_m.cols; col += 2) {
      const double z = depth_m.at<float>(row, col);
      points.emplace_back((col - camera.center_x_px) * z / camera.focal_px,
                          -(row - camera.center_y_px) * z / camera.focal_px, -z);
    }
  }
  return points;
}

void CompareScans(const ExperimentOptions& options, Json& result) {
  for (const ScanFile& file : kScans) {
    const std::filesystem::path path = options.scans / file.name;
    if (!std::filesystem::exists(path)) continue;
    const PipeScan scan = FitPipe(ReadPly(path), options.seed);
    const sim::CameraView camera = ScansCamera();
    const cv::Mat depth_m = TwinDepth(scan, camera);
    const PipeScan twin = FitPipe(PointsOf(depth_m, camera), options.seed);
    const DepthErrors errors = Compare(scan, depth_m, camera);
    result["scans"].push_back({{"scan", file.name},
                               {"nominal_mm", 1000.0 * file.nominal_m},
                               {"fitted_mm", 2000.0 * scan.radius_m},
                               {"twin_fitted_mm", 2000.0 * twin.radius_m},
                               {"points", scan.points},
                               {"inlier_share", scan.inlier_share},
                               {"residual_mm", 1000.0 * scan.residual_m},
                               {"twin_residual_mm", 1000.0 * twin.residual_m},
                               {"roughness_mm", 1000.0 * scan.roughness_m},
                               {"twin_roughness_mm", 1000.0 * twin.roughness_m},
                               {"depth_noise_near_mm", 1000.0 * RobustDeviation(errors.near_m)},
                               {"depth_noise_far_mm", 1000.0 * RobustDeviation(errors.far_m)}});
  }
}

Json Run(const ExperimentOptions& options) {
  Json result{{"experiment", "realism"}, {"seed", options.seed},    {"passed", true},
              {"rows", Json::array()},   {"thesis", Json::array()}, {"scans", Json::array()}};
  ComparePictures(options, robot::ReadDescription(options.robot_folder), result);
  CompareScans(options, result);
  return result;
}

// ---------------------------------------------------------------- for people

const char* const kNoPhotographs =
    "no photographs: they are not part of this project; --photos names their folder\n";
const char* const kNoScans = "no scans: --scans names their folder\n";

std::string Table(const Json& result) {
  std::string text;
  for (const Json& row : result.at("rows")) {
    if (text.empty())
      text = fmt::format("{:<18}  {:>9}  {:>17}  {:>6}\n", "measure", "distance",
                         "photographs' own", "ratio");
    text += fmt::format("{:<18}  {:>9.3f}  {:>17.3f}  {:>6.2f}  {}\n",
                        row.at("measure").get<std::string>(), row.at("distance").get<double>(),
                        row.at("photographs_halves").get<double>(), row.at("ratio").get<double>(),
                        row.at("unit").get<std::string>());
  }
  if (text.empty()) text = kNoPhotographs;
  const Json& scans = result.at("scans");
  if (scans.empty()) return text + kNoScans;
  for (const Json& scan : scans) {
    text += fmt::format(
        "{:<38}  {:.1f} mm (twin {:.1f}), off the cylinder {:.2f} mm (twin {:.2f}), rough {:.2f} "
        "mm "
        "(twin {:.2f}), depth noise {:.1f} mm near, {:.1f} mm far\n",
        scan.at("scan").get<std::string>(), scan.at("fitted_mm").get<double>(),
        scan.at("twin_fitted_mm").get<double>(), scan.at("residual_mm").get<double>(),
        scan.at("twin_residual_mm").get<double>(), scan.at("roughness_mm").get<double>(),
        scan.at("twin_roughness_mm").get<double>(), scan.at("depth_noise_near_mm").get<double>(),
        scan.at("depth_noise_far_mm").get<double>());
  }
  return text;
}

std::string RadialRow(const char* who, const Json& statistics) {
  std::string row = fmt::format("| {} |", who);
  for (std::size_t k = 0; k < 20; k += 2)
    row += fmt::format(" {:.0f} |", statistics.at("radial_levels").at(k).get<double>());
  return row + "\n";
}

std::string MeansRow(const char* who, const Json& s) {
  return fmt::format(
      "| {} | {} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {:+.3f} | {:.0f} % |\n", who,
      s.at("frames").get<int>(), s.at("gradient_levels_px").get<double>(),
      s.at("saturation").get<double>(), s.at("lightness").get<double>(),
      s.at("lab_a").get<double>(), s.at("lab_b").get<double>(),
      s.at("joint_contrast").get<double>(), 100.0 * s.at("bright_joints").get<double>());
}

std::string SpectrumRow(const char* who, const Json& s) {
  std::string row = fmt::format("| {} |", who);
  for (std::size_t k = 1; k < kSpectrumBins; k += 3)
    row += fmt::format(" {:.1f} |", s.at("spectrum_dB").at(k).get<double>());
  return row + "\n";
}

std::string Chapter(const Json& result) {
  std::string page = "## Statistics\n\n";
  page +=
      fmt::format("{} frames of the twin, seed {}.\n\n", result.at("twin").at("frames").get<int>(),
                  result.at("seed").get<std::uint64_t>());
  const bool real = result.contains("photographs");
  if (real) {
    page += "| measure | distance | photographs' own halves | ratio |\n|---|---|---|---|\n";
    for (const Json& row : result.at("rows")) {
      const std::string unit = row.at("unit");
      page +=
          fmt::format("| {}{} | {:.3f} | {:.3f} | {:.2f} |\n", row.at("measure").get<std::string>(),
                      unit.empty() ? "" : ", " + unit, row.at("distance").get<double>(),
                      row.at("photographs_halves").get<double>(), row.at("ratio").get<double>());
    }
    page += "\n";
  } else {
    page += kNoPhotographs + std::string("\n");
  }
  page +=
      "| mean of | frames | gradient, levels/px | saturation | L* | a* | b* | joint contrast | "
      "bright "
      "joints |\n|---|---|---|---|---|---|---|---|---|\n" +
      MeansRow("twin", result.at("twin"));
  if (real) page += MeansRow("photographs", result.at("photographs"));
  page += "\nGrey level by distance from the dark end:\n\n| px |";
  for (int k = 0; k < 20; k += 2) page += fmt::format(" {} |", 8 * k + 4);
  page +=
      "\n|---|---|---|---|---|---|---|---|---|---|---|\n" + RadialRow("twin", result.at("twin"));
  if (real) page += RadialRow("photographs", result.at("photographs"));
  page += "\nPower in dB by frequency:\n\n| cycles/px |";
  for (int k = 1; k < kSpectrumBins; k += 3)
    page += fmt::format(" {:.2f} |", 0.5 * (k + 0.5) / kSpectrumBins);
  page += "\n|---|---|---|---|---|---|---|---|---|\n" + SpectrumRow("twin", result.at("twin"));
  if (real) page += SpectrumRow("photographs", result.at("photographs"));
  page += "\n## Depth\n\n";
  if (result.at("scans").empty()) return page + kNoScans;
  page +=
      "| scan | nominal, mm | fitted, mm | twin's depth fitted, mm | on the cylinder | off it, mm "
      "(twin) | rough, mm (twin) | depth noise within 0.25 m, mm | beyond, mm "
      "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const Json& scan : result.at("scans")) {
    const auto number = [&](const char* key) { return scan.at(key).get<double>(); };
    page += fmt::format(
        "| `{}` | {:.0f} | {:.1f} | {:.1f} | {:.0f} % | {:.2f} ({:.2f}) | {:.2f} ({:.2f}) | {:.1f} "
        "| "
        "{:.1f} |\n",
        scan.at("scan").get<std::string>(), number("nominal_mm"), number("fitted_mm"),
        number("twin_fitted_mm"), 100.0 * number("inlier_share"), number("residual_mm"),
        number("twin_residual_mm"), number("roughness_mm"), number("twin_roughness_mm"),
        number("depth_noise_near_mm"), number("depth_noise_far_mm"));
  }
  return page;
}

}  // namespace

Experiment RealismExperiment() {
  return {"realism",
          "the twin's pictures beside photographs (--photos), its depth beside scans (--scans)",
          Run,
          Table,
          Chapter,
          true};
}

}  // namespace kantaro::scenarios
