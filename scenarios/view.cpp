#include "scenarios/view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/input_error.hpp"
#include "network/pipe_axis.hpp"
#include "robot/description.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/twin_conditions.hpp"
#include "sim/pixel_truth.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

std::string Png(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  return {bytes.begin(), bytes.end()};
}

/// Metres to 16-bit millimetres.
cv::Mat Millimetres(const cv::Mat& depth_m) {
  cv::Mat depth_mm;
  depth_m.convertTo(depth_mm, CV_16U, 1000.0);
  return depth_mm;
}

/// For people: near is yellow, 3 m and more dark blue; what is out of reach is black.
cv::Mat ColouredDepth(const cv::Mat& depth_m) {
  constexpr double kNearest_m = 0.1, kFarthest_m = 3.0;
  cv::Mat logarithm, levels, colours;
  cv::log(cv::max(depth_m, kNearest_m), logarithm);
  const double steps = 255.0 / std::log(kFarthest_m / kNearest_m);
  logarithm.convertTo(levels, CV_8U, -steps, steps * std::log(kFarthest_m));
  cv::applyColorMap(levels, colours, cv::COLORMAP_CIVIDIS);
  colours.setTo(cv::Scalar::all(0), depth_m <= 0.0F);
  return colours;
}

/// For people: a hue for each identity, far from those of its neighbours in number.
cv::Mat ColouredIdentity(const cv::Mat& identity) {
  cv::Mat colours(identity.size(), CV_8UC3);
  for (int row = 0; row < identity.rows; ++row) {
    for (int col = 0; col < identity.cols; ++col) {
      const unsigned id = identity.at<std::uint16_t>(row, col);
      const auto hue = static_cast<std::uint8_t>(id * 77U % 180U);
      colours.at<cv::Vec3b>(row, col) =
          id == 0 ? cv::Vec3b(0, 0, 0)
                  : cv::Vec3b(hue, static_cast<std::uint8_t>(120U + id * 53U % 120U), 220);
    }
  }
  cv::cvtColor(colours, colours, cv::COLOR_HSV2BGR);
  return colours;
}

/// Landmarks of a picture, with how many pixels show each.
Json LandmarksIn(const cv::Mat& identity, const std::vector<sim::Landmark>& landmarks) {
  std::vector<int> pixels(landmarks.size());
  for (int row = 0; row < identity.rows; ++row) {
    for (int col = 0; col < identity.cols; ++col) ++pixels[identity.at<std::uint16_t>(row, col)];
  }
  Json table = Json::array();
  for (std::size_t id = 1; id < landmarks.size(); ++id) {
    if (pixels[id] == 0) continue;
    const sim::Landmark& landmark = landmarks[id];
    Json row{{"id", id}, {"kind", ToString(landmark.kind)}, {"name", landmark.name}};
    if (!landmark.pipe.empty()) row["pipe"] = landmark.pipe;
    if (landmark.number > 0) {
      row["number"] = landmark.number;
      row["chainage_m"] = landmark.chainage_m;
    }
    row["pixels"] = pixels[id];
    table.push_back(row);
  }
  return table;
}

/// What the robot's code knows of a camera, in the words of sensor_msgs/CameraInfo.
Json CameraInfo(const robot::Camera& camera, const Eigen::Matrix3d& R_RC, double baseline_m) {
  const robot::Lens lens = robot::LensOf(camera);
  const double f = camera.focal_px;
  Json R = Json::array();
  for (int i = 0; i < 9; ++i) R.push_back(R_RC(i / 3, i % 3));
  return {
      {"width", camera.width_px},
      {"height", camera.height_px},
      {"distortion_model", "plumb_bob"},
      {"D", {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}},
      {"K", {lens.focal_x_px, 0, lens.center_x_px, 0, lens.focal_y_px, lens.center_y_px, 0, 0, 1}},
      {"R", R},
      {"P", {f, 0, camera.center_x_px, -f * baseline_m, 0, f, camera.center_y_px, 0, 0, 0, 1, 0}}};
}

Json ToJson(const Eigen::Isometry3d& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({pose.matrix()(row, 0), pose.matrix()(row, 1), pose.matrix()(row, 2),
                    pose.matrix()(row, 3)});
  }
  return rows;
}

void CheckPlace(const network::Network& network, const std::string& name, double chainage_m) {
  const auto index = network.FindPipe(name);
  if (!index)
    throw InputError("--pipe", {}, "", fmt::format("the network has no pipe \"{}\"", name));
  const network::Pipe& pipe = network.pipes[*index];
  if (!network::IsEnterable(pipe)) {
    throw InputError("--pipe", {}, "",
                     fmt::format("KANTARO cannot enter pipe \"{}\" of {:.0f} mm", name,
                                 1000.0 * pipe.diameter_m));
  }
  const double length_m = network::PipeAxis(network, pipe).length_m();
  if (!(chainage_m >= 0.0 && chainage_m <= length_m)) {
    throw InputError("--chainage", {}, "",
                     fmt::format("{} m is outside pipe \"{}\", which is {:.2f} m long", chainage_m,
                                 name, length_m));
  }
}

/// Lets the standing robot look until each camera has delivered.
std::pair<robot::FrontImage, robot::StereoPair> Look(sim::Twin& twin) {
  std::optional<robot::FrontImage> front;
  std::optional<robot::StereoPair> stereo;
  while (!front || !stereo) {
    std::optional<robot::Reading> reading = twin.Read();
    if (!reading) throw std::runtime_error("the cameras delivered nothing");
    if (auto* image = std::get_if<robot::FrontImage>(&reading->value)) front = std::move(*image);
    if (auto* pair = std::get_if<robot::StereoPair>(&reading->value)) stereo = std::move(*pair);
  }
  return {*front, *stereo};
}

}  // namespace

FolderFiles RenderView(const Scenario& scenario, const std::string& pipe, double chainage_m,
                       std::uint64_t seed) {
  CheckPlace(scenario.network, pipe, chainage_m);
  const Conditions conditions = DrawConditions(scenario, seed);
  const robot::Description description = robot::ReadDescription(scenario.robot_folder);
  const auto route = PlannedRoute(scenario);
  const auto leg =
      std::find_if(route.begin(), route.end(), [&](const auto& l) { return l.pipe == pipe; });
  // The world around the place, which need not lie on the route.
  const network::Pipe& there = scenario.network.PipeNamed(pipe);
  const sim::World world = sim::BuildWorld(
      network::Neighbourhood(scenario.network, {there.upstream, there.downstream}, 10.0),
      conditions.texture, true, sim::ReadGripTable(scenario.materials_file));
  sim::Conditions twin_conditions = TwinConditions(scenario, conditions);
  twin_conditions.start = {pipe, chainage_m, leg == route.end() || leg->downstream, 0.0, 0.0};
  twin_conditions.cameras.dropped_share = 0.0;
  sim::Twin twin(world, description, twin_conditions);
  const auto [front, stereo] = Look(twin);
  const Eigen::Isometry3d X_WB = twin.Truth().X_WB;

  const sim::LandmarkTruth landmarks(world.sewer, world.rays);
  Json truth{{"pipe", pipe},
             {"chainage_m", chainage_m},
             {"seed", seed},
             {"stereo_yaw_error_deg", conditions.stereo_yaw_error_rad * 180.0 / std::numbers::pi},
             {"X_WB", ToJson(X_WB)},
             {"cameras", Json::object()}};
  FolderFiles files{{"truth.json", ""}};
  const auto add = [&](const std::string& name, const robot::Camera& camera,
                       const Eigen::Matrix3d& R_RC, const cv::Mat& image, double baseline_m) {
    sim::CameraView view{X_WB * twin.TruePoseOf(camera),
                         camera.width_px,
                         camera.height_px,
                         camera.focal_px,
                         camera.center_x_px,
                         camera.center_y_px};
    Json& about = truth["cameras"][name] = {{"X_WC", ToJson(view.X_WC)}};
    view.X_WC.rotate(R_RC.transpose());
    const sim::PixelTruth pixels = landmarks.Look(view);
    about.update({{"X_WR", ToJson(view.X_WC)},
                  {"width_px", view.width_px},
                  {"height_px", view.height_px},
                  {"focal_px", view.focal_px},
                  {"center_x_px", view.center_x_px},
                  {"center_y_px", view.center_y_px},
                  {"camera_info", CameraInfo(camera, R_RC, baseline_m)},
                  {"landmarks", LandmarksIn(pixels.identity, landmarks.landmarks())}});
    files.emplace_back(name + ".png", Png(image));
    files.emplace_back(name + "_rectified.png", Png(robot::Rectifier(camera, R_RC).Rectify(image)));
    files.emplace_back(name + "_depth.png", Png(Millimetres(pixels.depth_m)));
    files.emplace_back(name + "_depth_colours.png", Png(ColouredDepth(pixels.depth_m)));
    files.emplace_back(name + "_identity.png", Png(pixels.identity));
    files.emplace_back(name + "_identity_colours.png", Png(ColouredIdentity(pixels.identity)));
  };
  add("front", description.front_camera, robot::FrontRectification(description), front.image, 0.0);
  const auto add_stereo = [&](const char* name, const robot::Camera& camera, const cv::Mat& image,
                              double baseline_m) {
    add(name, camera, robot::StereoRectification(description, camera), image, baseline_m);
  };
  add_stereo("stereo_left", description.stereo_left, stereo.left, 0.0);
  add_stereo("stereo_right", description.stereo_right, stereo.right,
             robot::StereoBaseline_m(description));
  files.front().second = truth.dump(2) + "\n";
  return files;
}

}  // namespace kantaro::scenarios
