#include "scenarios/view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/input_error.hpp"
#include "network/pipe_axis.hpp"
#include "robot/description.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/twin_conditions.hpp"
#include "sim/renderer.hpp"
#include "sim/robot_model.hpp"
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
std::string DepthPng(const cv::Mat& depth_m) {
  cv::Mat depth_mm;
  depth_m.convertTo(depth_mm, CV_16U, 1000.0);
  return Png(depth_mm);
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
  sim::Twin twin(world, description, twin_conditions);
  const auto [front, stereo] = Look(twin);
  const Eigen::Isometry3d X_WB = twin.Truth().X_WB;

  sim::Renderer renderer(world.scenery);
  Json truth{{"pipe", pipe},
             {"chainage_m", chainage_m},
             {"seed", seed},
             {"X_WB", ToJson(X_WB)},
             {"cameras", Json::object()}};
  FolderFiles files{{"truth.json", ""}};
  const auto add = [&](const std::string& name, const robot::Camera& camera, const cv::Mat& image) {
    const double mast_m = description.MastHeight(twin_conditions.mast_diameter_m);
    const sim::CameraView view{X_WB * sim::MountPose(description, camera.link, mast_m),
                               camera.width_px,
                               camera.height_px,
                               camera.focal_px,
                               camera.center_x_px,
                               camera.center_y_px};
    truth["cameras"][name] = {{"X_WC", ToJson(view.X_WC)},       {"width_px", view.width_px},
                              {"height_px", view.height_px},     {"focal_px", view.focal_px},
                              {"center_x_px", view.center_x_px}, {"center_y_px", view.center_y_px}};
    files.emplace_back(name + ".png", Png(image));
    files.emplace_back(name + "_depth.png", DepthPng(renderer.RenderDepth(view)));
  };
  add("front", description.front_camera, front.image);
  add("stereo_left", description.stereo_left, stereo.left);
  add("stereo_right", description.stereo_right, stereo.right);
  files.front().second = truth.dump(2) + "\n";
  return files;
}

}  // namespace kantaro::scenarios
