#include "scenarios/experiments/stereo_views.hpp"

#include <algorithm>

#include "base/random.hpp"
#include "perception/brightness.hpp"
#include "robot/flat_field.hpp"
#include "robot/rectifier.hpp"
#include "scenarios/experiments/fine_drawing.hpp"
#include "sim/imager.hpp"
#include "sim/physics.hpp"
#include "sim/robot_model.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Isometry3d;

constexpr double kPipe_m = 4.0;

network::Network PipeToAManhole(double diameter_m) {
  network::Network network;
  network.name = "stereo stage";
  network.manholes.resize(2);
  network.manholes[0].name = "start";
  network.manholes[1].name = "end";
  network.manholes[1].p_WM = {kPipe_m + diameter_m + 0.5, 0.0, 0.0};  // shafts are 0.5 m wider
  network::Pipe pipe;
  pipe.name = "pipe";
  pipe.upstream = "start";
  pipe.downstream = "end";
  pipe.diameter_m = diameter_m;
  for (const double chainage_m : {0.9, 2.1, 3.3}) {
    network::Joint joint;
    joint.chainage_m = chainage_m;
    pipe.joints.push_back(joint);
  }
  network.pipes = {pipe};
  return network;
}

}  // namespace

class StereoStage::Impl {
 public:
  Impl(const robot::Description& description, double diameter_m, std::uint64_t texture_seed)
      : description_(description),
        mast_m_(description.MastHeight(diameter_m)),
        world_(sim::BuildWorld(PipeToAManhole(diameter_m), texture_seed, true)),
        renderer_(world_.scenery, FineOptions(Largest())),
        rectifier_(description_),
        flat_field_(description_) {}

  StereoView See(double distance_m, double light, std::uint64_t seed, const std::string& stream) {
    const Isometry3d X_BL = Mount(description_.stereo_left.link);
    const double length_m = world_.sewer->axes[0].length_m();
    const Isometry3d X_WB = Stand(length_m - distance_m - X_BL.translation().x());
    const sim::CameraView left = Rectified(X_WB, description_.stereo_left);
    const sim::CameraView right = Rectified(X_WB, description_.stereo_right);
    StereoView view;
    view.rectified = rectifier_.Rectify(
        {perception::Brightness(Photograph(X_WB, description_.stereo_left, light, seed, stream)),
         perception::Brightness(Photograph(X_WB, description_.stereo_right, light, seed, stream))});
    view.flat = flat_field_.Flatten(view.rectified);
    view.ideal = {perception::Brightness(FineDrawing(renderer_, left, LampsAt(X_WB))),
                  perception::Brightness(FineDrawing(renderer_, right, LampsAt(X_WB)))};
    view.depth_m = renderer_.RenderDepth(left);
    view.mouth_m = distance_m;
    view.focal_px = left.focal_px;
    view.baseline_m = robot::StereoBaseline_m(description_);
    return view;
  }

 private:
  [[nodiscard]] Isometry3d Mount(const std::string& link) const {
    return sim::MountPose(description_, link, mast_m_);
  }

  /// The base when the robot has settled.
  [[nodiscard]] Isometry3d Stand(double chainage_m) const {
    sim::PhysicsOptions options;
    options.mast_height_m = mast_m_;
    sim::Physics physics(*world_.field, description_, options);
    physics.Place(*world_.sewer, {"pipe", chainage_m, true, 0.0, 0.0});
    return physics.PoseOfBase();
  }

  /// Of a camera as it truly sits in its mount.
  [[nodiscard]] Isometry3d PoseOf(const robot::Camera& camera) const {
    Isometry3d X_BC = Mount(camera.link);
    X_BC.rotate(camera.R_LC);
    return X_BC;
  }

  [[nodiscard]] sim::RendererOptions Largest() const {
    const sim::CameraView left = sim::LensMap(description_.stereo_left).ideal();
    const sim::CameraView right = sim::LensMap(description_.stereo_right).ideal();
    return {std::max(left.width_px, right.width_px), std::max(left.height_px, right.height_px)};
  }

  /// The ideal pinhole that a picture is rectified to.
  [[nodiscard]] sim::CameraView Rectified(const Isometry3d& X_WB,
                                          const robot::Camera& camera) const {
    Isometry3d X_WR = X_WB * PoseOf(camera);
    X_WR.rotate(robot::StereoRectification(description_, camera).transpose());
    return {X_WR,
            camera.width_px,
            camera.height_px,
            camera.focal_px,
            camera.center_x_px,
            camera.center_y_px};
  }

  [[nodiscard]] sim::Lamps LampsAt(const Isometry3d& X_WB) const {
    sim::Lamps lamps;
    for (const std::string& link : description_.lights)
      lamps.p_WLamp.push_back((X_WB * Mount(link)).translation());
    lamps.direction_W = (X_WB * Mount(description_.lights.at(0))).linear().col(0);
    return lamps;
  }

  /// The robot stands: nothing blurs.
  cv::Mat Photograph(const Isometry3d& X_WB, robot::Camera camera, double light, std::uint64_t seed,
                     const std::string& stream) {
    // Dimmed here, and not at the lamps: drawn in 256 levels, the dark would show contour lines.
    camera.sensor.sensitivity_e_s *= light;
    const sim::Imager imager(camera);
    sim::CameraView view = imager.lens().ideal();
    view.X_WC = X_WB * PoseOf(camera);
    RandomStream noise(seed, stream + "." + camera.link);
    return imager.Expose(FineDrawing(renderer_, view, LampsAt(X_WB)), {}, noise, scratch_);
  }

  const robot::Description description_;
  const double mast_m_;
  const sim::World world_;
  sim::Renderer renderer_;
  sim::Imager::Scratch scratch_;
  const robot::StereoRectifier rectifier_;
  const robot::StereoFlatField flat_field_;
};

StereoStage::StereoStage(const robot::Description& description, double diameter_m,
                         std::uint64_t texture_seed)
    : impl_(std::make_unique<Impl>(description, diameter_m, texture_seed)) {}
StereoStage::~StereoStage() = default;

StereoView StereoStage::See(double distance_m, double light, std::uint64_t seed,
                            const std::string& stream) {
  return impl_->See(distance_m, light, seed, stream);
}

}  // namespace kantaro::scenarios
