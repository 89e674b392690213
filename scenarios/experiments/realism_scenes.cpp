#include "scenarios/experiments/realism_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "sim/renderer.hpp"
#include "sim/robot_model.hpp"
#include "sim/sensor_noise.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using network::Material;
using network::WallCondition;

constexpr double kLength_m = 9.0;

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

network::Manhole ManholeAt(const char* name, double x_m) {
  network::Manhole manhole;
  manhole.name = name;
  manhole.p_WM = {x_m, 0.0, 0.0};
  return manhole;
}

void AddJoints(network::Pipe& pipe, RandomStream& random) {
  const double length_m = random.Uniform(0.8, 2.0);
  for (double at_m = random.Uniform(0.3, length_m); at_m < kLength_m - 1.0; at_m += length_m) {
    network::Joint joint;
    joint.chainage_m = at_m;
    joint.gap_m = random.Uniform(0.004, 0.014);
    joint.depth_m = random.Uniform(0.004, 0.008);
    if (random.Uniform(0.0, 1.0) < 0.4) {
      joint.offset_m = random.Uniform(0.001, 0.005);
      joint.offset_clock_h = random.Uniform(0.1, 12.0);
    }
    pipe.joints.push_back(joint);
  }
}

void AddObstacles(network::Pipe& pipe, double from_m, RandomStream& random) {
  if (random.Uniform(0.0, 1.0) < 0.2) {
    network::Obstacle bed{"bed", network::ObstacleKind::kSediment, kLength_m / 2.0, 6.0};
    bed.height_m = pipe.diameter_m * random.Uniform(0.04, 0.12);
    bed.length_m = kLength_m - 2.5;
    pipe.obstacles.push_back(bed);
    return;
  }
  for (std::size_t i = random.Index(3); i > 0; --i) {
    network::Obstacle stone{fmt::format("stone {}", i), network::ObstacleKind::kStone,
                            from_m + random.Uniform(0.45, 1.5) + 0.2 * static_cast<double>(i),
                            random.Uniform(5.4, 6.6)};
    stone.width_m = pipe.diameter_m * random.Uniform(0.10, 0.28);
    stone.length_m = stone.width_m;
    stone.height_m = stone.width_m * random.Uniform(0.35, 0.6);
    pipe.obstacles.push_back(stone);
  }
}

network::Network DrawNetwork(double from_m, RandomStream& random) {
  constexpr double kDiameters_m[] = {0.200, 0.250, 0.300, 0.350};
  network::Network network;
  network.name = "realism";
  network::Pipe pipe;
  pipe.name = "pipe";
  pipe.diameter_m = kDiameters_m[random.Index(4)];
  const double material = random.Uniform(0.0, 34.0);
  pipe.material = material < 22.0   ? Material::kConcrete
                  : material < 30.0 ? Material::kClay
                  : material < 32.0 ? Material::kLined
                                    : Material::kPvc;
  const double condition = random.Uniform(0.0, 1.0);
  pipe.condition = condition < 0.25  ? WallCondition::kDry
                   : condition < 0.8 ? WallCondition::kWet
                                     : WallCondition::kSlimy;
  if (random.Uniform(0.0, 1.0) < 0.6) pipe.water_m = pipe.diameter_m * random.Uniform(0.02, 0.14);
  AddJoints(pipe, random);
  AddObstacles(pipe, from_m, random);
  const double half_m = kLength_m / 2.0 + (pipe.diameter_m / 2.0 + 0.25);
  network.manholes = {ManholeAt("up", -half_m), ManholeAt("down", half_m)};
  pipe.upstream = network.manholes[0].name;
  pipe.downstream = network.manholes[1].name;
  network.pipes = {pipe};
  return network;
}

/// Boxes around the joints ahead that are wholly in view.
std::vector<cv::Rect2d> BoxesOfJoints(const sim::Sewer& sewer, const sim::CameraView& view) {
  constexpr int kPoints = 72;
  const network::Pipe& pipe = sewer.network.pipes.front();
  const Isometry3d X_CW = view.X_WC.inverse();
  std::vector<cv::Rect2d> boxes;
  for (const network::Joint& joint : pipe.joints) {
    Eigen::AlignedBox2d box;
    bool ahead = true;
    for (int i = 0; i < kPoints; ++i) {
      const Vector3d p_C =
          X_CW * (sewer.axes.front().PoseAt(joint.chainage_m) *
                  (pipe.diameter_m / 2.0 * network::ClockDirection(12.0 * (i + 1) / kPoints)));
      ahead = ahead && p_C.z() > 0.1;
      box.extend(Eigen::Vector2d(view.center_x_px + view.focal_px * p_C.x() / p_C.z(),
                                 view.center_y_px + view.focal_px * p_C.y() / p_C.z()));
    }
    if (ahead) boxes.emplace_back(box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
  }
  return boxes;
}

}  // namespace

LabelledImage TwinFrame(const robot::Description& robot, std::uint64_t seed, std::size_t index) {
  RandomStream random(seed, fmt::format("realism {}", index));
  const double from_m = random.Uniform(0.8, 3.0);
  const network::Network network = DrawNetwork(from_m, random);
  const sim::World world = sim::BuildWorld(network, seed + index, true);
  const sim::Sewer& sewer = *world.sewer;
  const double diameter_m = network.pipes.front().diameter_m;
  const double scale = static_cast<double>(kStatisticsSize.width) / robot.front_camera.width_px;

  // The camera at the axis, as an inspection sets it, and the lamps where the robot has them.
  const double mast_m = robot.MastHeight(diameter_m);
  const Isometry3d X_BCamera = sim::MountPose(robot, robot.front_camera.link, mast_m);
  Isometry3d X_WP = sewer.axes.front().PoseAt(from_m);
  X_WP.translate(Vector3d(0.0, random.Normal(0.03) * diameter_m, random.Normal(0.05) * diameter_m));
  X_WP.rotate(Eigen::AngleAxisd(Radians(random.Normal(3.0)), Vector3d::UnitZ()) *
              Eigen::AngleAxisd(Radians(random.Normal(2.5)), Vector3d::UnitY()) *
              Eigen::AngleAxisd(Radians(random.Normal(3.0)), Vector3d::UnitX()));
  const Isometry3d X_WB = X_WP * Eigen::Translation3d(-X_BCamera.translation());
  sim::CameraView view;
  view.X_WC = X_WB * X_BCamera;
  view.width_px = kStatisticsSize.width;
  view.height_px = kStatisticsSize.height;
  view.focal_px = scale * robot.front_camera.focal_px;
  view.center_x_px = (view.width_px - 1) / 2.0;
  view.center_y_px = (view.height_px - 1) / 2.0;
  sim::Lamps lamps;
  for (const std::string& link : robot.lights)
    lamps.p_WLamp.push_back((X_WB * sim::MountPose(robot, link, mast_m)).translation());
  lamps.direction_W = X_WB.linear().col(0);

  sim::Renderer renderer(world.scenery);
  LabelledImage frame{renderer.Render(view, lamps), BoxesOfJoints(sewer, view)};
  sim::AddSensorNoise(frame.image, random);
  return frame;
}

}  // namespace kantaro::scenarios
