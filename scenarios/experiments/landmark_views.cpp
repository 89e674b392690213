#include "scenarios/experiments/landmark_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "perception/brightness.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/experiments/fine_drawing.hpp"
#include "sim/imager.hpp"
#include "sim/physics.hpp"
#include "sim/robot_model.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using perception::LandmarkKind;

constexpr double kPipe_m = 8.0;
/// Longer than the farthest view: no nearer joint is then ahead. Below 2 m, as the thesis says.
constexpr double kShortestLength_m = 1.60, kLongestLength_m = 1.95;
constexpr double kDimmed = 1.0 / 8.0;  ///< as scenarios have it
/// To either side: rms 1.8 degrees of roll and 0.9 of heading on a metre, where missions on
/// straight pipes of route 1 have 1.5 and 0.6.
constexpr double kMostSwing_deg = 2.0, kMostHeading_deg = 1.0;
constexpr double kShortestWave_m = 2.0, kLongestWave_m = 4.0, kSwingArm_m = 0.08;
constexpr double kLongestExposure_s = 1.001 / 60.0;  ///< a field of NTSC video

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

network::Manhole ManholeAt(const char* name, double x_m, double y_m) {
  network::Manhole manhole;
  manhole.name = name;
  manhole.p_WM = {x_m, y_m, 0.0};
  return manhole;
}

/// The first one so far in that the whole of any approach to it is inside the pipe.
void AddJoints(network::Pipe& pipe, RandomStream& random) {
  const double length_m = random.Uniform(kShortestLength_m, kLongestLength_m);
  for (double at_m = random.Uniform(2.1, 2.7); at_m < kPipe_m - 0.3; at_m += length_m) {
    network::Joint joint;
    joint.chainage_m = at_m;
    joint.gap_m = random.Uniform(0.006, 0.012);
    joint.depth_m = random.Uniform(0.005, 0.008);
    pipe.joints.push_back(joint);
  }
}

/// One to either side of each length, clear of joints, the mouth and each other.
void AddInlets(network::Pipe& pipe, RandomStream& random) {
  constexpr double kClear_m = 0.20;
  std::vector<double> ends;
  for (const network::Joint& joint : pipe.joints) ends.push_back(joint.chainage_m);
  ends.push_back(kPipe_m);
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double middle_m = (ends[i] + ends[i + 1]) / 2.0;
    if (ends[i + 1] - ends[i] < 6.0 * kClear_m) continue;
    const bool left_first = random.Index(2) == 0;
    for (int side = 0; side < 2; ++side) {
      network::Inlet inlet;
      inlet.name = fmt::format("inlet {}", pipe.inlets.size() + 1);
      inlet.chainage_m = side == 0
                             ? random.Uniform(ends[i] + kClear_m, middle_m - kClear_m / 2.0)
                             : random.Uniform(middle_m + kClear_m / 2.0, ends[i + 1] - kClear_m);
      inlet.diameter_m = pipe.diameter_m * random.Uniform(0.40, 0.55);
      const double clock_h = random.Uniform(2.2, 3.2);
      inlet.clock_h = (side == 0) == left_first ? 12.0 - clock_h : clock_h;
      pipe.inlets.push_back(inlet);
    }
  }
}

/// Where the pipe goes on beyond its manhole: three types.
void AddBeyond(network::Network& network, std::size_t type) {
  const network::Pipe& main = network.pipes.front();
  const double end_m = network.manholes[1].p_WM.x();
  const auto go_on = [&](const char* name, double dx_m, double dy_m) {
    network.manholes.push_back(ManholeAt(name, end_m + dx_m, dy_m));
    network::Pipe pipe;
    pipe.name = std::string("to ") + name;
    pipe.upstream = "end";
    pipe.downstream = name;
    pipe.diameter_m = main.diameter_m;
    pipe.material = main.material;
    pipe.condition = main.condition;
    pipe.water_m = main.water_m;
    network.pipes.push_back(pipe);
  };
  if (type == 0) go_on("straight on", 3.0, 0.0);
  if (type == 1) go_on("round the turn", 0.0, 3.0);
}

struct Extremes {
  double off_m, tilt_rad, roll_rad, yaw_error_rad;
};

/// In the test field the robot drives along the invert; it still sways a little.
Extremes ExtremesOf(ViewSet set) {
  if (set == ViewSet::kField) return {};
  if (set == ViewSet::kReproduction) return {0.003, Radians(0.5), Radians(1.0), 0.0};
  return {0.020, Radians(4.0), Radians(4.0), Radians(0.05)};
}

double ChainageOf(const LandmarkSewer& sewer, const ViewPlan& plan, double pipe_end_m) {
  if (plan.kind == LandmarkKind::kManhole) return pipe_end_m;
  if (plan.kind == LandmarkKind::kJoint) return sewer.pipe().joints.at(plan.landmark).chainage_m;
  return sewer.pipe().inlets.at(plan.landmark).chainage_m;
}

/// How it lay when the travel to the last picture was still ahead.
ViewPlan Before(ViewPlan plan, double travel_m) {
  const auto swing = [&](double most_rad, double phase_rad) {
    const double wave_rad = 2.0 * std::numbers::pi * travel_m / plan.weave.length_m;
    return most_rad * (std::sin(phase_rad + wave_rad) - std::sin(phase_rad));
  };
  const double roll_rad = swing(plan.weave.roll_rad, plan.weave.roll_phase_rad);
  plan.roll_rad += roll_rad;
  plan.off_y_m += kSwingArm_m * roll_rad;  // up the wall to the left, it leans to the right
  plan.yaw_rad += swing(plan.weave.yaw_rad, plan.weave.yaw_phase_rad);
  return plan;
}

/// Those of the pipe's joints or inlets that a view may be of.
std::vector<std::size_t> Candidates(const network::Pipe& pipe, LandmarkKind kind) {
  std::vector<std::size_t> which;
  if (kind == LandmarkKind::kManhole) return {0};
  const std::size_t all = kind == LandmarkKind::kJoint ? pipe.joints.size() : pipe.inlets.size();
  for (std::size_t i = 0; i < all; ++i) {
    if (kind != LandmarkKind::kJoint &&
        (pipe.inlets[i].clock_h > 6.0) != (kind == LandmarkKind::kInletLeft))
      continue;
    which.push_back(i);
  }
  return which;
}

}  // namespace

const char* ToString(ViewSet set) {
  return set == ViewSet::kReproduction ? "reproduction"
         : set == ViewSet::kStress     ? "stress"
                                       : "field";
}

std::string StreamOf(ViewPurpose purpose, ViewSet set, std::size_t sewer) {
  return fmt::format("localisation.{}.{}.{}",
                     purpose == ViewPurpose::kTraining ? "training" : "test", ToString(set), sewer);
}

LandmarkSewer DrawSewer(ViewPurpose purpose, ViewSet set, std::uint64_t seed, std::size_t sewer) {
  if (set == ViewSet::kField) {
    sewer %= 3;  // thesis 4.4: three pipes, three types of manholes
    purpose = ViewPurpose::kTraining;
  }
  RandomStream random(seed, StreamOf(purpose, set, sewer));
  network::Network network;
  network.name = "landmarks";
  network::Pipe pipe;
  pipe.name = "pipe";
  pipe.upstream = "start";
  pipe.downstream = "end";
  if (set != ViewSet::kStress) {
    pipe.diameter_m = std::array{0.250, 0.300}[sewer % 2];
  } else {
    pipe.diameter_m = std::array{0.200, 0.250, 0.300, 0.350}[random.Index(4)];
    pipe.material = std::array{network::Material::kPvc, network::Material::kClay,
                               network::Material::kConcrete, network::Material::kLined}[sewer % 4];
    pipe.condition = network::WallCondition::kWet;
    pipe.water_m = pipe.diameter_m * random.Uniform(0.0, 0.10);
  }
  AddJoints(pipe, random);
  AddInlets(pipe, random);
  const double half_shaft_m = pipe.diameter_m / 2.0 + 0.25;
  network.manholes = {ManholeAt("start", -half_shaft_m, 0.0),
                      ManholeAt("end", kPipe_m + half_shaft_m, 0.0)};
  network.pipes = {pipe};
  AddBeyond(network, sewer % 3);
  return {network, random.Index(std::uint64_t{1} << 62U), set == ViewSet::kStress ? kDimmed : 1.0};
}

robot::ImageSensor AutomaticExposure(robot::ImageSensor sensor, double light) {
  const double bright_s = sensor.exposure_s;
  sensor.exposure_s = std::min(bright_s / light, std::max(bright_s, kLongestExposure_s));
  sensor.gain *= bright_s / (light * sensor.exposure_s);
  return sensor;
}

ViewPlan DrawView(const LandmarkSewer& sewer, ViewPurpose purpose, ViewSet set, std::uint64_t seed,
                  std::size_t sewer_number, std::size_t view, LandmarkKind kind) {
  RandomStream random(seed, fmt::format("{}.view.{}", StreamOf(purpose, set, sewer_number), view));
  const Extremes most = ExtremesOf(set);
  const bool inlet = kind == LandmarkKind::kInletLeft || kind == LandmarkKind::kInletRight;
  ViewPlan plan;
  plan.kind = kind;
  const std::vector<std::size_t> which = Candidates(sewer.pipe(), kind);
  plan.landmark = which[random.Index(which.size())];
  plan.distance_m = random.Uniform(
      kNearestView_m, inlet || set == ViewSet::kField ? kFarthestInlet_m : kFarthestRing_m);
  const double off_m = random.Uniform(0.0, most.off_m), tilt_rad = random.Uniform(0, most.tilt_rad);
  const double off_to_rad = random.Uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt_to_rad = random.Uniform(-std::numbers::pi, std::numbers::pi);
  plan.off_y_m = off_m * std::cos(off_to_rad);
  plan.off_z_m = off_m * std::sin(off_to_rad);
  plan.pitch_rad = tilt_rad * std::cos(tilt_to_rad);
  plan.yaw_rad = tilt_rad * std::sin(tilt_to_rad);
  plan.roll_rad = random.Uniform(-most.roll_rad, most.roll_rad);
  plan.yaw_error_rad = random.Uniform(-most.yaw_error_rad, most.yaw_error_rad);
  plan.speed_m_s = random.Uniform(0.0, 0.15);  // thesis 5.6: up to 15 cm/s
  plan.odometry_error = random.Normal(0.01);
  plan.between_m = random.Uniform(0.06, 0.12);  // two to four pictures at 15 cm/s and 5 Hz
  if (set == ViewSet::kField) return plan;
  plan.weave.length_m = random.Uniform(kShortestWave_m, kLongestWave_m);
  plan.weave.roll_rad = random.Uniform(0.0, Radians(kMostSwing_deg));
  plan.weave.roll_phase_rad = random.Uniform(-std::numbers::pi, std::numbers::pi);
  plan.weave.yaw_rad = random.Uniform(0.0, Radians(kMostHeading_deg));
  plan.weave.yaw_phase_rad = random.Uniform(-std::numbers::pi, std::numbers::pi);
  return plan;
}

bool SeesOnlyItsRing(const LandmarkSewer& sewer, const ViewPlan& plan) {
  const double at_m = ChainageOf(sewer, plan, kPipe_m);
  return std::ranges::none_of(sewer.pipe().joints, [&](const network::Joint& joint) {
    return joint.chainage_m > at_m - plan.distance_m && joint.chainage_m < at_m - 1e-6;
  });
}

class LandmarkStage::Impl {
 public:
  Impl(const robot::Description& description, LandmarkSewer sewer)
      : description_(description),
        sewer_(std::move(sewer)),
        mast_m_(description.MastHeight(sewer_.pipe().diameter_m)),
        world_(sim::BuildWorld(sewer_.network, sewer_.texture_seed, true)),
        front_(Make(description.front_camera)),
        left_(Make(description.stereo_left)),
        right_(Make(description.stereo_right)),
        renderer_(world_.scenery, Largest()),
        X_PB_(Settle()),
        front_rectifier_(description.front_camera, robot::FrontRectification(description)),
        stereo_rectifier_(description) {}

  std::vector<LandmarkPicture> Approach(const ViewPlan& plan, ViewCameras cameras,
                                        std::uint64_t seed, const std::string& stream, int count) {
    const double end_m = world_.sewer->axes.front().length_m();
    const double at_m = ChainageOf(sewer_, plan, end_m) - plan.distance_m;
    std::vector<LandmarkPicture> pictures;
    for (int before = count - 1; before >= 0; --before) {
      const double travel_m = -before * plan.between_m;
      const std::string noise = fmt::format("{}.picture.{}", stream, before);
      const ViewPlan then = Before(plan, travel_m);
      LandmarkPicture picture;
      picture.travel_m = travel_m * (1.0 + plan.odometry_error);
      if (cameras == ViewCameras::kFront) {
        const cv::Mat raw = Shoot(front_, then, at_m + travel_m, seed, noise);
        picture.image = front_rectifier_.Rectify(perception::Brightness(raw));
      } else {
        const robot::StereoPair pair = stereo_rectifier_.Rectify(
            {perception::Brightness(Shoot(left_, then, at_m + travel_m, seed, noise)),
             perception::Brightness(Shoot(right_, then, at_m + travel_m, seed, noise))});
        picture.image = pair.left;
        picture.right = pair.right;
      }
      pictures.push_back(std::move(picture));
    }
    return pictures;
  }

 private:
  struct Mounted {
    std::string link;
    Isometry3d X_BC{Isometry3d::Identity()};
    sim::Imager imager;
  };

  [[nodiscard]] Isometry3d Mount(const std::string& link) const {
    return sim::MountPose(description_, link, mast_m_);
  }

  [[nodiscard]] Mounted Make(robot::Camera camera) const {
    camera.sensor = AutomaticExposure(camera.sensor, sewer_.light);
    // Dimmed here, and not at the lamps: drawn in 256 levels, the dark would show contour lines.
    camera.sensor.sensitivity_e_s *= sewer_.light;
    Isometry3d X_BC = Mount(camera.link);
    X_BC.rotate(camera.R_LC);
    return {camera.link, X_BC, sim::Imager(camera)};
  }

  [[nodiscard]] sim::RendererOptions Largest() const {
    sim::RendererOptions options{1, 1};
    for (const Mounted* camera : {&front_, &left_, &right_}) {
      const sim::CameraView& ideal = camera->imager.lens().ideal();
      options.max_width_px = std::max(options.max_width_px, ideal.width_px);
      options.max_height_px = std::max(options.max_height_px, ideal.height_px);
    }
    return FineOptions(options);
  }

  /// The base against the pipe's frame at its own chainage, when the robot has settled.
  [[nodiscard]] Isometry3d Settle() const {
    sim::PhysicsOptions options;
    options.mast_height_m = mast_m_;
    sim::Physics physics(*world_.field, description_, options);
    constexpr double kSomewhere_m = 1.0;
    physics.Place(*world_.sewer, {"pipe", kSomewhere_m, true, 0.0, 0.0});
    return world_.sewer->axes.front().PoseAt(kSomewhere_m).inverse() * physics.PoseOfBase();
  }

  /// The base such that the camera is at this chainage.
  [[nodiscard]] Isometry3d Stand(const ViewPlan& plan, const Isometry3d& X_BC,
                                 double camera_at_m) const {
    const auto turned = AngleAxisd(plan.yaw_rad, Vector3d::UnitZ()) *
                        AngleAxisd(plan.pitch_rad, Vector3d::UnitY()) *
                        AngleAxisd(plan.roll_rad, Vector3d::UnitX());
    // About the front camera's place, so that the tilt does not carry it off the axis.
    const Vector3d p_BF = front_.X_BC.translation();
    const Isometry3d X_PB = Translation3d(0.0, plan.off_y_m, plan.off_z_m) * X_PB_ *
                            Translation3d(p_BF) * turned * Translation3d(-p_BF);
    const double ahead_m = (X_PB * X_BC.translation()).x();
    return world_.sewer->axes.front().PoseAt(camera_at_m) * Translation3d(-ahead_m, 0.0, 0.0) *
           X_PB;
  }

  cv::Mat Shoot(const Mounted& camera, const ViewPlan& plan, double at_m, std::uint64_t seed,
                const std::string& stream) {
    // A pair stands where its left camera does.
    const bool right = camera.link == right_.link;
    const Isometry3d X_WB = Stand(plan, right ? left_.X_BC : camera.X_BC, at_m);
    Isometry3d X_BC = camera.X_BC;
    if (right) X_BC.rotate(AngleAxisd(plan.yaw_error_rad, Vector3d::UnitY()));
    sim::CameraView view = camera.imager.lens().ideal();
    view.X_WC = X_WB * X_BC;
    sim::Lamps lamps;
    for (const std::string& link : description_.lights)
      lamps.p_WLamp.push_back((X_WB * Mount(link)).translation());
    lamps.direction_W = (X_WB * Mount(description_.lights.at(0))).linear().col(0);
    const Vector3d along_W = world_.sewer->axes.front().PoseAt(at_m).linear().col(0);
    sim::CameraMotion motion;
    motion.velocity_C = plan.speed_m_s * (view.X_WC.linear().transpose() * along_W);
    const sim::MotionField field(camera.imager.lens(), *world_.rays, view.X_WC, motion);
    RandomStream noise(seed, stream + "." + camera.link);
    return camera.imager.Expose(FineDrawing(renderer_, view, lamps), field, noise, scratch_);
  }

  const robot::Description description_;
  const LandmarkSewer sewer_;
  const double mast_m_;
  const sim::World world_;
  const Mounted front_, left_, right_;
  sim::Renderer renderer_;
  sim::Imager::Scratch scratch_;
  const Isometry3d X_PB_;
  const robot::Rectifier front_rectifier_;
  const robot::StereoRectifier stereo_rectifier_;
};

LandmarkStage::LandmarkStage(const robot::Description& description, LandmarkSewer sewer)
    : impl_(std::make_unique<Impl>(description, std::move(sewer))) {}
LandmarkStage::~LandmarkStage() = default;

std::vector<LandmarkPicture> LandmarkStage::Approach(const ViewPlan& plan, ViewCameras cameras,
                                                     std::uint64_t seed, const std::string& stream,
                                                     int count) {
  return impl_->Approach(plan, cameras, seed, stream, count);
}

void ForEachView(const robot::Description& description, const ViewRequest& request,
                 const std::function<void(LandmarkView&&)>& use) {
  const std::size_t sewers = (request.kinds.size() + kViewsPerSewer - 1) / kViewsPerSewer;
  ForEachInParallel(sewers, request.jobs, [&](std::size_t number) {
    const LandmarkSewer sewer = DrawSewer(request.purpose, request.set, request.seed, number);
    LandmarkStage stage(description, sewer);
    const std::size_t end = std::min((number + 1) * kViewsPerSewer, request.kinds.size());
    for (std::size_t i = number * kViewsPerSewer; i < end; ++i) {
      LandmarkView view;
      view.number = i;
      view.plan =
          DrawView(sewer, request.purpose, request.set, request.seed, number, i, request.kinds[i]);
      view.condition = sewer.pipe().condition;
      view.material = sewer.pipe().material;
      view.light = sewer.light;
      view.clear = SeesOnlyItsRing(sewer, view.plan);
      view.sizes.pipe_diameter_m = sewer.pipe().diameter_m;
      if (perception::ClassOf(view.plan.kind) == perception::LandmarkClass::kInlet)
        view.sizes.inlet_diameter_m = sewer.pipe().inlets.at(view.plan.landmark).diameter_m;
      view.pictures = stage.Approach(
          view.plan, request.cameras, request.seed,
          fmt::format("{}.noise.{}", StreamOf(request.purpose, request.set, number), i),
          request.pictures);
      use(std::move(view));
    }
  });
}

std::vector<LandmarkKind> SpreadKinds(std::size_t manholes, std::size_t joints,
                                      std::size_t inlets) {
  const std::array<std::size_t, 3> counts{manholes, joints, inlets};
  const double all = static_cast<double>(manholes + joints + inlets);
  std::array<std::size_t, 3> given{};
  std::vector<LandmarkKind> kinds;
  while (kinds.size() < manholes + joints + inlets) {
    std::size_t most = 0;
    double largest = -HUGE_VAL;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const double due =
          static_cast<double>(counts[k]) * static_cast<double>(kinds.size() + 1) / all;
      const double lacks = due - static_cast<double>(given[k]);
      if (lacks <= largest) continue;
      largest = lacks;
      most = k;
    }
    kinds.push_back(most == 0           ? LandmarkKind::kManhole
                    : most == 1         ? LandmarkKind::kJoint
                    : given[2] % 2 == 0 ? LandmarkKind::kInletLeft
                                        : LandmarkKind::kInletRight);
    ++given[most];
  }
  return kinds;
}

}  // namespace kantaro::scenarios
