#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "robot/lens.hpp"
#include "robot/sensor_parameters.hpp"

namespace kantaro::robot {

struct Box {
  Eigen::Vector3d size_m{Eigen::Vector3d::Zero()};  ///< full edge lengths
};
struct Cylinder {
  double radius_m{}, length_m{};  ///< along its frame's z
};
struct Sphere {
  double radius_m{};
};

/// A body shape G fixed to link L.
struct Shape {
  Eigen::Isometry3d X_LG{Eigen::Isometry3d::Identity()};
  std::variant<Box, Cylinder, Sphere> geometry;
};

struct Inertial {
  double mass_kg{};                                    ///< > 0
  Eigen::Vector3d p_LoLcm_L{Eigen::Vector3d::Zero()};  ///< centre of mass in the link frame
  /// About the centre of mass, in link axes [kg m²].
  Eigen::Matrix3d I_LLcm_L{Eigen::Matrix3d::Zero()};
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;  ///< absent for pure frames (sensors)
  std::vector<Shape> collisions;
  std::vector<Shape> visuals;
};

enum class JointType { kFixed, kContinuous, kPrismatic };

/// Joint J fixed to parent link P; the child link's frame coincides with J at position zero.
struct Joint {
  std::string name;
  JointType type{JointType::kFixed};
  std::string parent, child;
  Eigen::Isometry3d X_PJ{Eigen::Isometry3d::Identity()};
  Eigen::Vector3d axis_J{Eigen::Vector3d::UnitX()};  ///< unit
  double lower{}, upper{};                           ///< prismatic travel [m]
};

/// A spring-damper along a prismatic joint (companion file, keyed by joint).
struct Suspension {
  double stiffness_N_m{};
  double damping_Ns_m{};
  double rest_position_m{};  ///< joint position at which the spring carries nothing
};

/// A rounded wheel: a torus about the joint axis (companion file, keyed by wheel joint).
struct Tyre {
  double radius_m{};        ///< outer, hub to tread
  double tread_radius_m{};  ///< rounding of the tread, < radius
};

/// A wheel's drive (companion file, keyed by wheel joint): torque = gain * (commanded − actual
/// speed), limited.
struct Motor {
  double torque_limit_Nm{};
  double speed_limit_rad_s{};
  double speed_gain_Nm_s{};
  double rotor_inertia_kg_m2{};  ///< seen at the wheel
};

/// What lies behind a lens. Light is counted in radiances: 1 is about what a clean white wall 0.3 m
/// ahead of the robot's own lights sends back.
struct ImageSensor {
  double exposure_s{};
  double gain{1.0};          ///< of the amplifier; at 1 a full well is all but white
  double sensitivity_e_s{};  ///< electrons per second that radiance 1 brings, on the axis
  double full_well_e{};      ///< electrons that a pixel holds
  double read_noise_e{};     ///< standard deviation [electrons]
  /// Light that arrives off the axis, as a share: 1 + a ρ² + b ρ⁴ + c ρ⁶, with ρ the distance from
  /// the lens' centre in halves of the picture's diagonal. Absent: the fourth power of the cosine.
  std::optional<std::array<double, 3>> vignetting;
  bool interlaced{};  ///< odd rows were exposed one field, 1/59.94 s, before the even ones
};

/// A camera at its link's frame L. Its pictures, as they come, are seen through `lens`; robot::
/// Rectifier makes of them those of an ideal pinhole, of which perception speaks.
struct Camera {
  std::string link;
  int width_px{}, height_px{};
  double focal_px{};                    ///< of the rectified picture, both axes
  double center_x_px{}, center_y_px{};  ///< of the rectified picture; pixel centres lie at whole
                                        ///< numbers, its middle is (size − 1) / 2
  double rate_Hz{};
  double latency_s{};
  std::optional<Lens> lens;  ///< as calibrated; absent: the ideal pinhole itself
  /// From the optical frame C (x right, y down, z forward) to the link's, as calibrated: by how
  /// much the camera sits askew in its mount.
  Eigen::Matrix3d R_LC{Eigen::Matrix3d::Identity()};
  ImageSensor sensor;
};

/// The camera's lens, that of the ideal pinhole if it has no other.
[[nodiscard]] Lens LensOf(const Camera& camera);

/// The laser scanner (thesis Table 5.1), at its link's frame L (x forward, y left, z up at zero
/// mast height).
struct Laser {
  std::string link;
  double speed_rpm{};             ///< of the mirror, 0 to 1800; at 0 there are no revolutions
  double samples_Hz{};            ///< at least 10 kHz
  std::uint32_t mirror_counts{};  ///< of the mirror's encoder to a turn (robot/mirror_angle.hpp)
  double range_min_m{}, range_max_m{};
  double accuracy_m{};     ///< ± bound of the error
  double beam_radius_m{};  ///< the same all along
  double latency_s{};
  std::string mast;  ///< prismatic joint that carries the laser; set by hand, fixed while driving
  /// Mast joint position for each pipe diameter [m -> m]; in between the next smaller one holds.
  std::map<double, double> mast_height_m;
};

/// An IR sensor, beam along its link's +x. Light comes back as 1 / range², summed over the beam's
/// cone: value = s / (1 + s) with s the mean of (half_range / range)².
struct Infrared {
  std::string link;
  double half_range_m{};         ///< range at which the value is 0.5
  double cone_half_angle_rad{};  ///< of the beam
  double noise{};                ///< standard deviation of the value
};

/// Everything known about the robot's body: the URDF and its companion, joined. Nothing stands in
/// both files.
struct Description {
  std::string name;
  std::vector<Link> links;    ///< parents before children; the first is the base, B
  std::vector<Joint> joints;  ///< joints[i] moves links[i + 1]
  std::map<std::string, Suspension> suspensions;  ///< by prismatic joint
  std::map<std::string, Tyre> tyres;              ///< by wheel joint
  std::map<std::string, Motor> motors;            ///< by wheel joint
  std::vector<std::string> wheels;  ///< joints: front left, front right, rear left, rear right
  std::vector<std::string> lights;  ///< links of the LEDs, shining along +x
  std::string upper_box;            ///< link whose contact the judge counts as a collision
  Camera front_camera, stereo_left, stereo_right;
  Laser laser;
  Infrared ir_up, ir_left, ir_right;
  double encoder_rate_Hz{}, infrared_rate_Hz{};
  double encoder_resolution_rad{};
  InertialUnit inertial;
  Inclinometer inclinometer;
  Compass compass;
  Battery battery;

  [[nodiscard]] const Link& LinkNamed(
      const std::string& link) const;  ///< @throws std::out_of_range
  /// Pose of a link in the base at joint positions zero.
  [[nodiscard]] Eigen::Isometry3d PoseInBase(const std::string& link) const;
  [[nodiscard]] double TotalMass_kg() const;
  /// Fastest that all wheels can turn.
  [[nodiscard]] double SpeedLimit_rad_s() const;
  /// Mast height set for a pipe of this diameter [m]. @throws std::out_of_range below the smallest
  /// listed.
  [[nodiscard]] double MastHeight(double diameter_m) const;
};

/// Text of one input file, and the name that complaints about it carry.
struct SourceText {
  std::filesystem::path file;
  std::string text;
};

/// Joins the three files of a robot: the URDF (through urdfdom, after checking what urdfdom lets
/// pass: numbers, masses, inertias, unknown elements, the tree), its companion and the cameras'
/// calibration.
/// @throws InputError
[[nodiscard]] Description ParseDescription(const SourceText& urdf, const SourceText& companion,
                                           const SourceText& cameras);

/// Reads `kantaro.urdf`, `kantaro.yaml` and `cameras.yaml` from one folder. @throws InputError
[[nodiscard]] Description ReadDescription(const std::filesystem::path& folder);

}  // namespace kantaro::robot
