#include "robot/description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/files.hpp"
#include "base/yaml.hpp"
#include "robot/urdf.hpp"

namespace kantaro::robot {
namespace {

constexpr double kFastestMirror_rpm = 1800.0;  // thesis Table 5.1

const Joint* FindJoint(const Description& robot, const std::string& name) {
  const auto found = std::find_if(robot.joints.begin(), robot.joints.end(),
                                  [&](const Joint& joint) { return joint.name == name; });
  return found == robot.joints.end() ? nullptr : &*found;
}

std::string LinkName(const YamlNode& node, const Description& robot) {
  const std::string name = node.Text();
  const bool known = std::any_of(robot.links.begin(), robot.links.end(),
                                 [&](const Link& link) { return link.name == name; });
  if (!known) throw node.Error(fmt::format("the URDF has no link \"{:.60}\"", name));
  return name;
}

std::string JointName(const YamlNode& node, const Description& robot, JointType type) {
  const std::string name = node.Text();
  const Joint* joint = FindJoint(robot, name);
  if (joint == nullptr) throw node.Error(fmt::format("the URDF has no joint \"{:.60}\"", name));
  if (joint->type != type) {
    throw node.Error(fmt::format("the joint \"{}\" of the URDF is not {}", name,
                                 type == JointType::kPrismatic ? "prismatic" : "continuous"));
  }
  return name;
}

/// A list of {joints: [...], ...}, each joint of `wanted` in exactly one.
template <typename Part, typename ReadPart>
std::map<std::string, Part> ReadParts(const YamlNode& list, const Description& robot,
                                      JointType type, const std::vector<std::string>& wanted,
                                      ReadPart read) {
  std::map<std::string, Part> parts;
  for (const YamlNode& group : list.Elements()) {
    const Part part = read(group);
    for (const YamlNode& joint : group["joints"].Elements()) {
      const std::string name = JointName(joint, robot, type);
      if (std::find(wanted.begin(), wanted.end(), name) == wanted.end()) {
        throw joint.Error(fmt::format("the joint \"{}\" does not belong here", name));
      }
      if (!parts.emplace(name, part).second) {
        throw joint.Error(fmt::format("the joint \"{}\" stands here twice", name));
      }
    }
  }
  for (const std::string& name : wanted) {
    if (!parts.contains(name)) {
      throw list.Error(fmt::format("nothing is said about the joint \"{}\" of the URDF", name));
    }
  }
  return parts;
}

Suspension ReadSuspension(const YamlNode& node) {
  node.AllowOnly({"joints", "stiffness_N_m", "damping_Ns_m", "rest_position_mm"});
  return {node["stiffness_N_m"].Positive(), node["damping_Ns_m"].Number(0.0, 1e6),
          node["rest_position_mm"].Number(-1000.0, 1000.0) / 1000.0};
}

Tyre ReadTyre(const YamlNode& node) {
  node.AllowOnly({"joints", "radius_mm", "tread_radius_mm"});
  const Tyre tyre{node["radius_mm"].Positive() / 1000.0,
                  node["tread_radius_mm"].Positive() / 1000.0};
  if (tyre.tread_radius_m >= tyre.radius_m) {
    throw node["tread_radius_mm"].Error("the tread's rounding must be below the tyre's radius");
  }
  return tyre;
}

Motor ReadMotor(const YamlNode& node) {
  node.AllowOnly(
      {"joints", "torque_limit_Nm", "speed_limit_rad_s", "speed_gain_Nm_s", "rotor_inertia_kg_m2"});
  return {node["torque_limit_Nm"].Positive(), node["speed_limit_rad_s"].Positive(),
          node["speed_gain_Nm_s"].Positive(), node["rotor_inertia_kg_m2"].Number(0.0, 1e3)};
}

std::vector<std::string> ReadWheels(const YamlNode& order, const Description& robot) {
  std::vector<std::string> wheels;
  for (const YamlNode& joint : order.Elements()) {
    wheels.push_back(JointName(joint, robot, JointType::kContinuous));
    if (std::count(wheels.begin(), wheels.end(), wheels.back()) > 1) {
      throw joint.Error("the wheel stands here twice");
    }
  }
  const auto turning =
      std::count_if(robot.joints.begin(), robot.joints.end(),
                    [](const Joint& joint) { return joint.type == JointType::kContinuous; });
  if (wheels.size() != 4 || turning != 4) {
    throw order.Error(fmt::format("four wheels are wanted; {} stand here, the URDF has {}",
                                  wheels.size(), turning));
  }
  return wheels;
}

std::map<double, double> ReadMastHeights(const YamlNode& node, const Joint& mast) {
  std::map<double, double> heights;
  for (const auto& [key, value] : node.Entries()) {
    double diameter_mm = 0.0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), diameter_mm);
    if (error != std::errc() || end != key.data() + key.size() || !(diameter_mm > 0.0) ||
        diameter_mm > 1e5) {
      throw value.Error(fmt::format("\"{:.40}\" is not a pipe diameter in mm", key));
    }
    const double height_m = value.Number(1000.0 * mast.lower, 1000.0 * mast.upper) / 1000.0;
    if (!heights.emplace(diameter_mm / 1000.0, height_m).second) {
      throw value.Error("this diameter stands here twice");
    }
  }
  if (heights.empty()) throw node.Error("at least one pipe diameter is wanted");
  return heights;
}

Laser ReadLaser(const YamlNode& node, const Description& robot) {
  node.AllowOnly({"link", "speed_rpm", "samples_Hz", "mirror_counts", "range_min_mm",
                  "range_max_mm", "accuracy_mm", "beam_radius_mm", "latency_s", "mast"});
  Laser laser;
  laser.link = LinkName(node["link"], robot);
  laser.speed_rpm = node["speed_rpm"].Number(0.0, kFastestMirror_rpm);
  laser.samples_Hz = node["samples_Hz"].Number(1e3, 1e6);
  laser.mirror_counts = static_cast<std::uint32_t>(node["mirror_counts"].Integer(4, 1 << 24));
  laser.range_min_m = node["range_min_mm"].Number(0.0, 1e5) / 1000.0;
  laser.range_max_m = node["range_max_mm"].Number(0.0, 1e5) / 1000.0;
  if (laser.range_max_m <= laser.range_min_m) {
    throw node["range_max_mm"].Error("the largest range must be above the smallest");
  }
  laser.accuracy_m = node["accuracy_mm"].Number(0.0, 1e3) / 1000.0;
  laser.beam_radius_m = node["beam_radius_mm"].Number(0.0, 100.0) / 1000.0;
  laser.latency_s = node["latency_s"].Number(0.0, 10.0);
  const YamlNode mast = node["mast"];
  mast.AllowOnly({"joint", "heights_mm"});
  laser.mast = JointName(mast["joint"], robot, JointType::kPrismatic);
  const Joint& joint = *FindJoint(robot, laser.mast);
  if (joint.child != laser.link)
    throw mast["joint"].Error("this joint does not carry the laser's link");
  laser.mast_height_m = ReadMastHeights(mast["heights_mm"], joint);
  return laser;
}

void ReadInfrared(const YamlNode& node, Description& robot) {
  node.AllowOnly(
      {"up", "left", "right", "half_range_mm", "cone_half_angle_deg", "noise", "rate_Hz"});
  const auto sensor = [&](const char* key) {
    return Infrared{LinkName(node[key], robot), node["half_range_mm"].Positive() / 1000.0,
                    node["cone_half_angle_deg"].Number(0.0, 60.0) * std::numbers::pi / 180.0,
                    node["noise"].Number(0.0, 1.0)};
  };
  robot.ir_up = sensor("up");
  robot.ir_left = sensor("left");
  robot.ir_right = sensor("right");
  robot.infrared_rate_Hz = node["rate_Hz"].Number(0.1, 1000.0);
}

Lens ReadLens(const YamlNode& node, const Camera& camera) {
  node.AllowOnly({"focal_x_px", "focal_y_px", "center_x_px", "center_y_px", "distortion"});
  Lens lens;
  lens.focal_x_px = node["focal_x_px"].Number(1.0, 1e6);
  lens.focal_y_px = node["focal_y_px"].Number(1.0, 1e6);
  lens.center_x_px = node["center_x_px"].Number(0.0, camera.width_px - 1.0);
  lens.center_y_px = node["center_y_px"].Number(0.0, camera.height_px - 1.0);
  // What the rectified picture's corners ask for, and a little more for the raw one's.
  const double corner = 1.1 * std::hypot(camera.width_px, camera.height_px) /
                        std::min({lens.focal_x_px, lens.focal_y_px, camera.focal_px}) / 2.0;
  const std::vector<double> k = node["distortion"].Numbers(5);
  std::tie(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3) = std::tie(k[0], k[1], k[2], k[3], k[4]);
  if (std::abs(lens.p1) > 0.1 || std::abs(lens.p2) > 0.1 || Folds(lens, corner)) {
    throw node["distortion"].Error(
        "such a lens would fold the picture: k1, k2, p1, p2, k3 of a usual one are wanted");
  }
  return lens;
}

ImageSensor ReadSensor(const YamlNode& node) {
  node.AllowOnly({"exposure_ms", "gain_dB", "sensitivity_e_s", "full_well_e", "read_noise_e",
                  "vignetting", "interlaced"});
  ImageSensor sensor;
  sensor.exposure_s = node["exposure_ms"].Number(0.001, 1000.0) / 1000.0;
  sensor.gain = std::pow(10.0, node["gain_dB"].Number(-60.0, 60.0) / 20.0);
  sensor.sensitivity_e_s = node["sensitivity_e_s"].Number(1.0, 1e12);
  sensor.full_well_e = node["full_well_e"].Number(10.0, 1e9);
  sensor.read_noise_e = node["read_noise_e"].Number(0.0, 1e6);
  sensor.interlaced = node["interlaced"].Boolean();
  const YamlNode vignetting = node["vignetting"];
  if (vignetting.IsSequence()) {
    const std::vector<double> a = vignetting.Numbers(3);
    for (int i = 0; i <= 100; ++i) {
      const double r2 = 1e-4 * i * i;
      const double share = 1.0 + r2 * (a[0] + r2 * (a[1] + r2 * a[2]));
      if (!(share > 0.05 && share <= 1.5)) {
        throw vignetting.Error("between 0.05 and 1.5 of the light must arrive everywhere");
      }
    }
    sensor.vignetting = {a[0], a[1], a[2]};
  } else if (vignetting.Text() != "cos4") {
    throw vignetting.Error("cos4 is wanted, or [a, b, c] of 1 + a r^2 + b r^4 + c r^6");
  }
  return sensor;
}

Camera ReadCamera(const YamlNode& node, const Description& robot) {
  node.AllowOnly({"link", "width_px", "height_px", "rate_Hz", "latency_s", "focal_px",
                  "center_x_px", "center_y_px", "lens", "sensor"});
  Camera camera;
  camera.link = LinkName(node["link"], robot);
  camera.width_px = static_cast<int>(node["width_px"].Integer(1, 8192));
  camera.height_px = static_cast<int>(node["height_px"].Integer(1, 8192));
  camera.focal_px = node["focal_px"].Number(1.0, 1e6);
  camera.center_x_px = node["center_x_px"].Number(0.0, camera.width_px - 1.0);
  camera.center_y_px = node["center_y_px"].Number(0.0, camera.height_px - 1.0);
  camera.rate_Hz = node["rate_Hz"].Number(0.1, 1000.0);
  camera.latency_s = node["latency_s"].Number(0.0, 10.0);
  camera.lens = ReadLens(node["lens"], camera);
  camera.sensor = ReadSensor(node["sensor"]);
  if (camera.latency_s < 0.5 * camera.sensor.exposure_s) {
    throw node["latency_s"].Error("a picture cannot arrive before it is exposed");
  }
  return camera;
}

/// About x, y and z in turn, each a small angle.
Eigen::Matrix3d ReadRotation(const YamlNode& node) {
  constexpr double kMost_deg = 10.0;
  const std::vector<double> deg = node.Numbers(3);
  if (std::ranges::any_of(deg, [](double angle) { return std::abs(angle) > kMost_deg; })) {
    throw node.Error("each angle must be from -10 to 10 degrees");
  }
  constexpr double kDegree = std::numbers::pi / 180.0;
  return (Eigen::AngleAxisd(deg[2] * kDegree, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(deg[1] * kDegree, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(deg[0] * kDegree, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

void ReadCameras(const YamlNode& root, Description& robot) {
  root.AllowOnly({"front", "stereo_left", "stereo_right", "stereo"});
  robot.front_camera = ReadCamera(root["front"], robot);
  robot.stereo_left = ReadCamera(root["stereo_left"], robot);
  robot.stereo_right = ReadCamera(root["stereo_right"], robot);
  const Camera& left = robot.stereo_left;
  const Camera& right = robot.stereo_right;
  if (std::pair(left.width_px, left.height_px) != std::pair(right.width_px, right.height_px) ||
      std::pair(left.rate_Hz, left.latency_s) != std::pair(right.rate_Hz, right.latency_s)) {
    throw root["stereo_right"].Error(
        "size, rate and latency must equal the left camera's: one exposure");
  }
  if (std::tuple(left.focal_px, left.center_x_px, left.center_y_px) !=
      std::tuple(right.focal_px, right.center_x_px, right.center_y_px)) {
    throw root["stereo_right"].Error(
        "focal_px, center_x_px and center_y_px must equal the left camera's: rectified pictures "
        "share them");
  }
  if (left.sensor.exposure_s != right.sensor.exposure_s) {
    throw root["stereo_right"]["sensor"]["exposure_ms"].Error("must equal the left camera's");
  }
  root["stereo"].AllowOnly({"right_rotation_deg"});
  robot.stereo_right.R_LC = ReadRotation(root["stereo"]["right_rotation_deg"]);
}

void ReadCompanion(const YamlNode& root, Description& robot) {
  root.AllowOnly({"upper_box", "wheels", "suspensions", "tyres", "motors", "lights", "laser",
                  "infrared", "encoders", "inertial", "inclinometer", "compass", "battery"});
  robot.upper_box = LinkName(root["upper_box"], robot);
  const YamlNode wheels = root["wheels"];
  wheels.AllowOnly({"order"});
  robot.wheels = ReadWheels(wheels["order"], robot);
  robot.laser = ReadLaser(root["laser"], robot);

  std::vector<std::string> sprung;
  for (const Joint& joint : robot.joints) {
    if (joint.type == JointType::kPrismatic && joint.name != robot.laser.mast) {
      sprung.push_back(joint.name);
    }
  }
  robot.suspensions = ReadParts<Suspension>(root["suspensions"], robot, JointType::kPrismatic,
                                            sprung, ReadSuspension);
  robot.tyres =
      ReadParts<Tyre>(root["tyres"], robot, JointType::kContinuous, robot.wheels, ReadTyre);
  robot.motors =
      ReadParts<Motor>(root["motors"], robot, JointType::kContinuous, robot.wheels, ReadMotor);
  for (const YamlNode& light : root["lights"].Elements()) {
    robot.lights.push_back(LinkName(light, robot));
  }
  ReadInfrared(root["infrared"], robot);

  const YamlNode encoders = root["encoders"];
  encoders.AllowOnly({"resolution_rad", "rate_Hz"});
  robot.encoder_resolution_rad = encoders["resolution_rad"].Number(1e-6, 1.0);
  robot.encoder_rate_Hz = encoders["rate_Hz"].Number(0.1, 1000.0);
  robot.inertial = ReadInertialUnit(root["inertial"]);
  robot.inclinometer = ReadInclinometer(root["inclinometer"]);
  robot.compass = ReadCompass(root["compass"]);
  robot.battery = ReadBattery(root["battery"]);
}

}  // namespace

Lens LensOf(const Camera& camera) {
  return camera.lens.value_or(Lens{.focal_x_px = camera.focal_px,
                                   .focal_y_px = camera.focal_px,
                                   .center_x_px = camera.center_x_px,
                                   .center_y_px = camera.center_y_px});
}

const Link& Description::LinkNamed(const std::string& link) const {
  const auto found = std::find_if(links.begin(), links.end(),
                                  [&](const Link& candidate) { return candidate.name == link; });
  if (found == links.end()) throw std::out_of_range("no link " + link);
  return *found;
}

Eigen::Isometry3d Description::PoseInBase(const std::string& link) const {
  Eigen::Isometry3d X_PL = Eigen::Isometry3d::Identity();
  std::string below = LinkNamed(link).name;
  while (below != links.front().name) {
    const auto joint = std::find_if(joints.begin(), joints.end(), [&](const Joint& candidate) {
      return candidate.child == below;
    });
    X_PL = joint->X_PJ * X_PL;
    below = joint->parent;
  }
  return X_PL;
}

double Description::TotalMass_kg() const {
  double mass_kg = 0.0;
  for (const Link& link : links) mass_kg += link.inertial ? link.inertial->mass_kg : 0.0;
  return mass_kg;
}

double Description::SpeedLimit_rad_s() const {
  double limit_rad_s = std::numeric_limits<double>::infinity();
  for (const auto& [wheel, motor] : motors)
    limit_rad_s = std::min(limit_rad_s, motor.speed_limit_rad_s);
  return limit_rad_s;
}

double Description::MastHeight(double diameter_m) const {
  constexpr double kTolerance_m = 1e-6;
  const auto above = laser.mast_height_m.upper_bound(diameter_m + kTolerance_m);
  if (above == laser.mast_height_m.begin()) {
    throw std::out_of_range(fmt::format("no mast height is known for a pipe of {} m", diameter_m));
  }
  return std::prev(above)->second;
}

Description ParseDescription(const SourceText& urdf, const SourceText& companion,
                             const SourceText& cameras) {
  UrdfBody body = ParseUrdf(urdf);
  Description robot;
  robot.name = std::move(body.name);
  robot.links = std::move(body.links);
  robot.joints = std::move(body.joints);
  ReadCompanion(YamlNode::Parse(companion.text, companion.file), robot);
  ReadCameras(YamlNode::Parse(cameras.text, cameras.file), robot);
  return robot;
}

Description ReadDescription(const std::filesystem::path& folder) {
  const auto read = [&](const char* name) {
    return SourceText{folder / name, ReadInputFile(folder / name)};
  };
  return ParseDescription(read("kantaro.urdf"), read("kantaro.yaml"), read("cameras.yaml"));
}

}  // namespace kantaro::robot
