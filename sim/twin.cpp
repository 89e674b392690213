#include "sim/twin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "base/random.hpp"
#include "sim/battery_pack.hpp"
#include "sim/camera_rig.hpp"
#include "sim/compass_sensor.hpp"
#include "sim/inertial_sensors.hpp"
#include "sim/range_sensors.hpp"
#include "sim/surface_mesh.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using robot::Reading;
using robot::RunTime;
using robot::Seconds;

constexpr RunTime kStep = std::chrono::milliseconds(2);

/// Between what cameras see and the walls, whose facets reach as far into them as out: half a pixel
/// of a wall 0.3 m away. Rays have finer ones; a picture's cost goes by its triangles.
constexpr double kSeenTolerance_m = 0.5e-3;

RunTime FromSeconds(double seconds) { return RunTime(std::llround(seconds * 1e9)); }

/// How many physics steps lie between two readings.
std::int64_t StepsPer(double rate_Hz, const char* sensor) {
  const double steps = 1.0 / (rate_Hz * Seconds(kStep));
  const auto whole = std::llround(steps);
  if (whole < 1 || std::abs(steps - static_cast<double>(whole)) > 1e-6) {
    throw std::invalid_argument(
        fmt::format("the rate of the {} is no whole number of 2 ms steps", sensor));
  }
  return whole;
}

}  // namespace

World BuildWorld(const network::Network& network, std::uint64_t texture_seed, bool cameras,
                 const std::optional<GripTable>& grips) {
  World world;
  const auto sewer = std::make_shared<const Sewer>(BuildSewer(network));
  const SurfaceMesh mesh = Tessellate(sewer->voids, sewer->solids);
  world.field = std::make_shared<const VoidField>(sewer->voids, sewer->solids);
  world.rays = std::make_shared<const RayCaster>(mesh);
  if (cameras) {
    SceneryOptions options;
    options.seed = texture_seed;
    const SurfaceMesh seen =
        Tessellate(sewer->voids, sewer->solids, {.tolerance_m = kSeenTolerance_m});
    world.scenery = std::make_shared<const Scenery>(*sewer, seen, options);
  }
  if (grips) world.ground = std::make_shared<const SewerGround>(*sewer, *world.field, *grips);
  world.sewer = sewer;
  return world;
}

class Twin::Impl {
 public:
  Impl(World world, const robot::Description& description, const Conditions& conditions)
      : world_(std::move(world)),
        description_(description),
        conditions_(conditions),
        ground_(world_.ground ? GroundAt(std::cref(*world_.ground)) : GroundAt()),
        physics_(*world_.field, description_, MakePhysicsOptions(), ground_),
        laser_(description_.laser, *world_.rays, RandomStream(conditions.seed, "sensor.laser")),
        infrared_noise_(conditions.seed, "sensor.infrared"),
        inertial_(description_.inertial, conditions.seed),
        inclinometer_(description_.inclinometer, conditions.seed),
        compass_(description_.compass, conditions.seed),
        magnetic_field_(*world_.sewer, description_.compass),
        battery_(description_.battery, conditions.battery_charge),
        encoder_steps_(StepsPer(description_.encoder_rate_Hz, "encoders")),
        infrared_steps_(StepsPer(description_.infrared_rate_Hz, "IR sensors")),
        inertial_steps_(StepsPer(description_.inertial.rate_Hz, "inertial unit")),
        inclinometer_steps_(StepsPer(description_.inclinometer.rate_Hz, "inclinometer")),
        compass_steps_(StepsPer(description_.compass.rate_Hz, "compass")),
        battery_steps_(StepsPer(description_.battery.rate_Hz, "battery")),
        front_steps_(StepsPer(description_.front_camera.rate_Hz, "front camera")),
        stereo_steps_(StepsPer(description_.stereo_left.rate_Hz, "stereo cameras")) {
    for (const std::string& link : description_.lights) lamp_mounts_.push_back(Mount(link));
    if (world_.scenery) MountCameras();
    physics_.Place(*world_.sewer, conditions_.start);
  }

  std::optional<Reading> Read() {
    while (pending_.empty() || pending_.begin()->first.first > Time()) {
      const bool silent = battery_.off() && pending_.empty();
      if (silent || Seconds(Time()) >= conditions_.time_limit_s) return std::nullopt;
      Step();
    }
    Pending next = std::move(pending_.begin()->second);
    pending_.erase(pending_.begin());
    if (auto* front = std::get_if<robot::FrontImage>(&next.reading.value)) {
      front->image = next.images[0].get();
    } else if (auto* stereo = std::get_if<robot::StereoPair>(&next.reading.value)) {
      stereo->left = next.images[0].get();
      stereo->right = next.images[1].get();
    }
    now_ = next.reading.arrived_at;
    return std::move(next.reading);
  }

  robot::CommandOutcome Apply(const robot::Command& command) {
    robot::CheckCommand(command);
    if (stopped_ || battery_.off()) return robot::CommandOutcome::kRefused;
    lights_ = command.lights;
    physics_.Drive(command.left_rad_s * (1.0 + conditions_.left_right_mismatch),
                   command.right_rad_s * (1.0 - conditions_.left_right_mismatch));
    const double fastest = std::max(std::abs(command.left_rad_s), std::abs(command.right_rad_s));
    return fastest > description_.SpeedLimit_rad_s() ? robot::CommandOutcome::kLimited
                                                     : robot::CommandOutcome::kHonoured;
  }

  void Stop() {
    stopped_ = true;
    physics_.Drive(0.0, 0.0);
  }

  RunTime Now() const { return now_; }

  GroundTruth Truth() {
    GroundTruth truth;
    truth.X_WB = physics_.PoseOfBase();
    truth.upper_box_touched = std::exchange(upper_box_touched_, false);
    Locate(truth);
    Vector3d forward = truth.X_WB.linear().col(0);
    if (truth.pipe) {
      const Vector3d along =
          world_.sewer->axes[*truth.pipe].PoseAt(truth.chainage_m).linear().col(0);
      forward = along.dot(forward) < 0.0 ? Vector3d(-along) : along;
    }
    truth.speed_m_s = physics_.VelocityOfBase().dot(forward);
    return truth;
  }

  Isometry3d TruePoseOf(const robot::Camera& camera) const {
    Isometry3d X_BC = Mount(camera.link);
    X_BC.rotate(camera.R_LC);
    if (camera.link == description_.stereo_right.link)
      X_BC.rotate(Eigen::AngleAxisd(conditions_.cameras.stereo_yaw_error_rad, Vector3d::UnitY()));
    return X_BC;
  }

 private:
  struct Pending {
    Reading reading;
    std::vector<std::future<cv::Mat>> images;
  };

  PhysicsOptions MakePhysicsOptions() const {
    PhysicsOptions options;
    options.timestep_s = Seconds(kStep);
    options.wheel_friction = conditions_.wheel_friction;
    options.friction_factor = conditions_.friction_factor;
    options.mast_height_m = description_.MastHeight(conditions_.mast_diameter_m);
    return options;
  }

  Isometry3d Mount(const std::string& link) const {
    return MountPose(description_, link, description_.MastHeight(conditions_.mast_diameter_m));
  }

  RunTime Time() const { return steps_ * kStep; }

  void Step() {
    const Isometry3d X_WL_before = physics_.PoseOfBase() * laser_mount_;
    physics_.Step();
    const double from_s = Seconds(Time());
    ++steps_;
    const Isometry3d X_WB = physics_.PoseOfBase();
    upper_box_touched_ = upper_box_touched_ || physics_.Touches(description_.upper_box);
    if (battery_.off()) return;
    DrawPower();
    if (battery_.off()) return SwitchOff();

    for (auto& [time_s, revolution] :
         laser_.Scan(from_s, Seconds(Time()), X_WL_before, X_WB * laser_mount_)) {
      Queue(FromSeconds(time_s), description_.laser.latency_s, std::move(revolution));
    }
    if (steps_ % encoder_steps_ == 0) Queue(Time(), 0.0, ReadEncoders());
    if (steps_ % inertial_steps_ == 0) {
      Queue(Time(), 0.0, inertial_.Measure(physics_.AngularVelocity(), physics_.SpecificForce()));
    }
    inclinometer_.Follow(physics_.SpecificForce(), Seconds(kStep));
    if (steps_ % inclinometer_steps_ == 0) Queue(Time(), 0.0, inclinometer_.Measure());
    if (steps_ % compass_steps_ == 0) Queue(Time(), 0.0, ReadCompass(X_WB));
    if (steps_ % battery_steps_ == 0) Queue(Time(), 0.0, robot::BatteryState(battery_.state()));
    if (steps_ % infrared_steps_ == 0) Queue(Time(), 0.0, ReadInfrared(X_WB));
    if (!cameras_) return;
    if (steps_ % front_steps_ == 0)
      Photograph(robot::FrontImage{}, robot::Sensor::kFrontCamera, {&*front_});
    if (steps_ % stereo_steps_ == 0)
      Photograph(robot::StereoPair{}, robot::Sensor::kStereoCameras, {&*left_, &*right_});
  }

  /// Readings of one instant keep the order in which they were queued.
  template <typename Value>
  Pending& Queue(RunTime captured_at, double latency_s, Value&& value) {
    const RunTime arrived_at = captured_at + FromSeconds(latency_s);
    Pending& pending = pending_[{arrived_at, queued_++}];
    pending.reading = {captured_at, arrived_at, std::forward<Value>(value)};
    return pending;
  }

  robot::WheelEncoders ReadEncoders() const {
    robot::WheelEncoders encoders{physics_.WheelAngles()};
    for (double& angle : encoders.angle_rad) {
      angle = std::floor(angle / description_.encoder_resolution_rad) *
              description_.encoder_resolution_rad;
    }
    return encoders;
  }

  double MotorsPower_W() const {
    const std::array<double, 4> torques = physics_.MotorTorques();
    const std::array<double, 4> speeds = physics_.WheelSpeeds();
    double power_W = 0.0;
    for (std::size_t i = 0; i < torques.size(); ++i)
      power_W += MotorPower_W(description_.battery, torques[i], speeds[i]);
    return power_W;
  }

  void DrawPower() {
    const robot::Battery& battery = description_.battery;
    motors_W_ = MotorsPower_W();
    const double laser_W = description_.laser.speed_rpm > 0.0 ? battery.laser_W : 0.0;
    battery_.Draw(motors_W_ + battery.electronics_W + laser_W + lights_ * battery.lights_W,
                  Seconds(kStep));
  }

  /// What was on its way is lost with all the rest.
  void SwitchOff() {
    physics_.Drive(0.0, 0.0);
    lights_ = 0.0;
    pending_.clear();
    // The battery's own first: it is why.
    for (std::size_t i = robot::kSensorCount; i-- > 0;)
      Queue(Time(), 0.0, robot::Loss{static_cast<robot::Sensor>(i), 1, true});
  }

  robot::CompassHeading ReadCompass(const Isometry3d& X_WB) {
    GroundTruth here;
    here.X_WB = X_WB;
    Locate(here);
    const Eigen::Vector3d field_T =
        magnetic_field_.At(X_WB.translation(), here.pipe, here.chainage_m);
    return compass_.Measure(X_WB.linear(), field_T, motors_W_ / battery_.state().voltage_V);
  }

  robot::IrRanges ReadInfrared(const Isometry3d& X_WB) {
    const auto measure = [&](const robot::Infrared& sensor) {
      return MeasureInfrared(sensor, *world_.rays, ground_, X_WB * Mount(sensor.link),
                             infrared_noise_);
    };
    robot::IrRanges ranges;
    ranges.up = measure(description_.ir_up);
    ranges.left = measure(description_.ir_left);
    ranges.right = measure(description_.ir_right);
    return ranges;
  }

  /// A camera as it truly is.
  struct MountedCamera {
    std::string link;
    double latency_s{};
    Isometry3d X_BC{Isometry3d::Identity()};
    std::shared_ptr<const Imager> imager;
  };

  void MountCameras() {
    front_ = MountCamera(description_.front_camera);
    left_ = MountCamera(description_.stereo_left);
    right_ = MountCamera(description_.stereo_right);
    cv::Size largest;
    for (const auto* camera : {&front_, &left_, &right_}) {
      const CameraView& ideal = (*camera)->imager->lens().ideal();
      largest = {std::max(largest.width, ideal.width_px),
                 std::max(largest.height, ideal.height_px)};
    }
    cameras_.emplace(world_.scenery, world_.rays, largest, conditions_.render_threads);
  }

  MountedCamera MountCamera(robot::Camera camera) const {
    camera.sensor.exposure_s *= conditions_.cameras.exposure_factor;
    camera.sensor.gain *= conditions_.cameras.gain_factor;
    RandomStream random(conditions_.seed, "lens." + camera.link);
    return {camera.link, camera.latency_s, TruePoseOf(camera),
            std::make_shared<const Imager>(
                camera, ScatterDrops(conditions_.cameras.drops_on_lens, camera, random))};
  }

  /// Exposes cameras together; their images wait in one reading, or are lost together.
  template <typename Images>
  void Photograph(Images&& images, robot::Sensor sensor,
                  std::initializer_list<const MountedCamera*> cameras) {
    const MountedCamera& first = **cameras.begin();
    RandomStream fate(conditions_.seed, fmt::format("frame.{}.{}", first.link, steps_));
    if (fate.Uniform(0.0, 1.0) < conditions_.cameras.dropped_share) {
      Queue(Time(), first.latency_s, robot::Loss{sensor, 1, false});
      return;
    }
    Pending& pending = Queue(Time(), first.latency_s, std::forward<Images>(images));
    for (const MountedCamera* camera : cameras) pending.images.push_back(Expose(*camera));
  }

  std::future<cv::Mat> Expose(const MountedCamera& camera) {
    const Isometry3d X_WB = physics_.PoseOfBase();
    Shot shot;
    shot.imager = camera.imager;
    shot.X_WC = X_WB * camera.X_BC;
    shot.seed = conditions_.seed;
    shot.noise_stream = fmt::format("sensor.{}.{}", camera.link, steps_);
    const Eigen::Matrix3d R_CB = camera.X_BC.linear().transpose();
    const Vector3d w_B = physics_.AngularVelocity();
    shot.motion.angular_velocity_C = R_CB * w_B;
    shot.motion.velocity_C = R_CB * (X_WB.linear().transpose() * physics_.VelocityOfBase() +
                                     w_B.cross(camera.X_BC.translation()));
    for (const Isometry3d& X_BLamp : lamp_mounts_)
      shot.lamps.p_WLamp.push_back((X_WB * X_BLamp).translation());
    if (!lamp_mounts_.empty())
      shot.lamps.direction_W = (X_WB * lamp_mounts_.front()).linear().col(0);
    shot.lamps.brightness = std::min(1.0, lights_ * conditions_.light);
    return cameras_->Capture(std::move(shot));
  }

  void Locate(GroundTruth& truth) const {
    const Vector3d p_WB = truth.X_WB.translation();
    const Nearby nearby = world_.field->Around(p_WB, 0.05);
    for (const VoidPrimitive* primitive : nearby.voids()) {
      const Part& part = world_.sewer->parts[primitive->part];
      if (part.kind == Part::Kind::kManhole) {
        truth.manhole = part.index;
        continue;
      }
      const network::PipePosition position = world_.sewer->axes[part.index].Locate(p_WB);
      if (position.chainage_m < 0.0 ||
          position.chainage_m > world_.sewer->axes[part.index].length_m())
        continue;
      truth.pipe = part.index;
      truth.chainage_m = position.chainage_m;
    }
    if (truth.pipe) truth.manhole.reset();
  }

  World world_;
  robot::Description description_;
  Conditions conditions_;
  GroundAt ground_;
  Physics physics_;
  LaserScanner laser_;
  RandomStream infrared_noise_;
  InertialSensor inertial_;
  InclinationSensor inclinometer_;
  CompassSensor compass_;
  MagneticField magnetic_field_;
  BatteryPack battery_;
  std::int64_t encoder_steps_, infrared_steps_, inertial_steps_, inclinometer_steps_,
      compass_steps_, battery_steps_, front_steps_, stereo_steps_;
  Isometry3d laser_mount_{Mount(description_.laser.link)};
  std::vector<Isometry3d> lamp_mounts_;
  std::optional<MountedCamera> front_, left_, right_;
  std::optional<CameraRig> cameras_;

  std::int64_t steps_{};
  std::uint64_t queued_{};
  std::map<std::pair<RunTime, std::uint64_t>, Pending> pending_;
  RunTime now_{};
  double lights_{1.0};
  double motors_W_{};  ///< what they draw now
  bool stopped_{};
  bool upper_box_touched_{};
};

Twin::Twin(World world, const robot::Description& description, const Conditions& conditions)
    : impl_(std::make_unique<Impl>(std::move(world), description, conditions)) {}
Twin::~Twin() = default;

std::optional<Reading> Twin::Read() { return impl_->Read(); }
robot::CommandOutcome Twin::Apply(const robot::Command& command) { return impl_->Apply(command); }
void Twin::Stop() { impl_->Stop(); }
RunTime Twin::Now() const { return impl_->Now(); }
GroundTruth Twin::Truth() { return impl_->Truth(); }
Eigen::Isometry3d Twin::TruePoseOf(const robot::Camera& camera) const {
  return impl_->TruePoseOf(camera);
}

}  // namespace kantaro::sim
