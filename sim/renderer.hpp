#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/scenery.hpp"

namespace kantaro::sim {

/// A pinhole camera in the world. Pixel (0, 0) has its middle at image coordinates (0, 0), as in
/// OpenCV.
struct CameraView {
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< C optical: x right, y down, z forward
  int width_px{640};
  int height_px{480};
  double focal_px{554.0};
  double center_x_px{319.5};
  double center_y_px{239.5};
};

/// The robot's own lights: all there is in a sewer.
struct Lamps {
  std::vector<Eigen::Vector3d> p_WLamp;  ///< at most kMaxLamps
  Eigen::Vector3d direction_W{
      Eigen::Vector3d::UnitX()};  ///< unit; they shine widest and brightest that way
  double brightness{1.0};         ///< of all of them together, 0 … 1
};
inline constexpr int kMaxLamps = 8;

struct RendererOptions {
  int max_width_px{704};
  int max_height_px{576};
};

/// Draws a scenery as cameras see it. Lit per pixel: each lamp falls off with the square of its
/// distance, on walls that scatter evenly and shine where they are wet. Images depend on the
/// arguments alone, to the bit.
///
/// Owns an OpenGL context. Any thread may use it, one at a time; renderers draw one after the
/// other. llvmpipe fills the pixels with a crew of threads, as many as there are cores (environment
/// variable LP_NUM_THREADS; with 0 the caller fills them). The pixels are the same.
class Renderer {
 public:
  /// @throws RenderingUnavailable, MujocoError
  explicit Renderer(std::shared_ptr<const Scenery> scenery, const RendererOptions& options = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// @returns 8-bit BGR, height x width.
  /// @throws std::invalid_argument if the view is empty or larger than the options allow, or of too
  /// many lamps.
  [[nodiscard]] cv::Mat Render(const CameraView& view, const Lamps& lamps);

  /// Ground truth. @returns CV_32F, depth along the optical axis [m], 0 where nothing is in reach.
  /// Water counts as a surface: what lies under it has no depth.
  [[nodiscard]] cv::Mat RenderDepth(const CameraView& view);

  /// Walls farther than this from the camera are not drawn [m]; the light has faded to nothing by
  /// then.
  static constexpr double kReach_m = 6.0;
  /// Radiance that damp air and a dirty lens send back from everywhere when the lamps are at full
  /// brightness: photographs from sewers are nowhere black.
  static constexpr double kVeil = 0.007;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The response of camera and exposure to light: 0 … 1 of the 8-bit range for radiance >= 0 (1 is
/// about what a clean white wall 0.3 m away sends back). Soft towards white, never quite black.
[[nodiscard]] double Response(double radiance);

}  // namespace kantaro::sim
