#include "sim/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "sim/gl_calls.hpp"
#include "sim/mujoco_error.hpp"
#include "sim/offscreen_context.hpp"
#include "sim/shaders.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kNear_m = 0.02;
/// One lamp in the middle of lamps no farther than this from it lights a wall 0.2 m away by 1 %
/// more or less than they do.
constexpr double kTogether_m = 0.025;
/// Sent back where nothing at all shines, as a share of full scale: the sensor's black level.
constexpr double kBlack = 0.03;
constexpr std::array<double, 3> kVeilColour{1.35, 0.85, 1.10};  ///< blue, green, red

/// What a view sees: a pyramid of planes through the camera, cut off at the reach.
class Pyramid {
 public:
  explicit Pyramid(const CameraView& view) : X_CW_(view.X_WC.inverse()) {
    const double left = -(view.center_x_px + 0.5), right = view.width_px - 0.5 - view.center_x_px;
    const double top = -(view.center_y_px + 0.5), bottom = view.height_px - 0.5 - view.center_y_px;
    const double f = view.focal_px;
    inward_C_ = {Vector3d(f, 0, -left).normalized(), Vector3d(-f, 0, right).normalized(),
                 Vector3d(0, f, -top).normalized(), Vector3d(0, -f, bottom).normalized()};
  }

  [[nodiscard]] bool Meets(const Vector3d& p_WCentre, double radius_m) const {
    const Vector3d p_C = X_CW_ * p_WCentre;
    if (p_C.norm() > Renderer::kReach_m + radius_m || p_C.z() < -radius_m) return false;
    return std::ranges::all_of(inward_C_,
                               [&](const Vector3d& inward) { return inward.dot(p_C) > -radius_m; });
  }

 private:
  Eigen::Isometry3d X_CW_;
  std::array<Vector3d, 4> inward_C_;
};

/// From the shader's output to the camera's, blue, green and red: the air's veil, and room for the
/// black level. Done here, so that pixels that nothing fills agree with unlit ones.
std::array<cv::Vec3b, 256> ToneTable(double brightness) {
  std::array<cv::Vec3b, 256> tone{};
  for (std::size_t i = 0; i < tone.size(); ++i) {
    const double shown = static_cast<double>(i) / 255.0;
    const double radiance = -std::log1p(-std::min(shown * shown, 1.0 - 1e-6));
    for (int channel = 0; channel < 3; ++channel) {
      const double veil = Renderer::kVeil * kVeilColour[static_cast<std::size_t>(channel)];
      tone[i][channel] =
          cv::saturate_cast<std::uint8_t>(255.0 * Response(radiance + brightness * veil));
    }
  }
  return tone;
}

/// Lamps that are as good as one become one.
Lamps Merged(const Lamps& lamps) {
  if (lamps.p_WLamp.empty()) return lamps;
  Vector3d p_WMiddle = Vector3d::Zero();
  for (const Vector3d& p_WLamp : lamps.p_WLamp)
    p_WMiddle += p_WLamp / static_cast<double>(lamps.p_WLamp.size());
  const bool together = std::ranges::all_of(lamps.p_WLamp, [&](const Vector3d& p_WLamp) {
    return (p_WLamp - p_WMiddle).norm() < kTogether_m;
  });
  return together ? Lamps{{p_WMiddle}, lamps.direction_W, lamps.brightness} : lamps;
}

/// Through the tone table, the right way up, and blurred by (1, 6, 1) / 8 each way: no lens is
/// sharper than a pixel, and without it edges would be jagged.
/// @param pixels  BGRA, the lowest row first.
cv::Mat Develop(const cv::Mat& pixels, const std::array<cv::Vec3b, 256>& tone) {
  const int rows = pixels.rows, width = 3 * pixels.cols;
  cv::Mat image(rows, pixels.cols, CV_8UC3);
  // Three rows as they are, and one blurred downward with a pixel more on both sides.
  std::array<std::vector<std::uint8_t>, 3> sharp;
  for (auto& row : sharp) row.resize(static_cast<std::size_t>(width));
  std::vector<std::uint16_t> down(static_cast<std::size_t>(width) + 6);
  const auto fill = [&](int row) {
    const auto* from = pixels.ptr<std::uint8_t>(rows - 1 - row);
    std::uint8_t* to = sharp[static_cast<std::size_t>(row % 3)].data();
    for (int col = 0; col < pixels.cols; ++col) {
      for (int c = 0; c < 3; ++c) to[3 * col + c] = tone[from[4 * col + c]][c];
    }
  };
  const auto at = [&](int row) {
    return sharp[static_cast<std::size_t>(std::clamp(row, 0, rows - 1) % 3)].data();
  };
  fill(0);
  for (int row = 0; row < rows; ++row) {
    if (row + 1 < rows) fill(row + 1);
    const std::uint8_t *above = at(row - 1), *here = at(row), *below = at(row + 1);
    std::uint16_t* middle = down.data() + 3;
    for (int i = 0; i < width; ++i)
      middle[i] = static_cast<std::uint16_t>(above[i] + 6 * here[i] + below[i]);
    for (int c = 0; c < 3; ++c) {
      middle[c - 3] = middle[c];
      middle[width + c] = middle[width - 3 + c];
    }
    auto* to = image.ptr<std::uint8_t>(row);
    for (int i = 0; i < width; ++i)
      to[i] = static_cast<std::uint8_t>((middle[i - 3] + 6 * middle[i] + middle[i + 3] + 32) >> 6);
  }
  return image;
}

}  // namespace

class Renderer::Impl {
 public:
  Impl(std::shared_ptr<const Scenery> scenery, const RendererOptions& options)
      : scenery_(std::move(scenery)), options_(options) {
    ThrowOnMujocoErrors();
    const OffscreenContext::Current current(context_);
    gl_.emplace();
    // Only numbers change in this copy; the arrays stay the scenery's.
    mjModel model = scenery_->model();
    // Pictures are drawn into framebuffers of their own size: what a larger one has outside costs
    // time too.
    model.vis.global.offwidth = model.vis.global.offheight = 1;
    mjr_defaultContext(&mujoco_);
    mjr_makeContext(&model, &mujoco_, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &mujoco_);
    if (mujoco_.currentBuffer != mjFB_OFFSCREEN) {
      throw RenderingUnavailable("cameras cannot be rendered: OpenGL gives no framebuffer");
    }
    mujocos_framebuffer_ = mujoco_.offFBO;
    SampleOneLevel();
    depth_program_ = Program(1, kDepthVertexShader, kDepthShader);
    mjv_defaultScene(&scene_);
    mjv_makeScene(&scenery_->model(), &scene_, static_cast<int>(scenery_->pieces().size()));
    std::ranges::fill(scene_.flags, mjtByte{0});
    scene_.flags[mjRND_CULL_FACE] = 1;
  }

  ~Impl() {
    const OffscreenContext::Current current(context_);
    mjv_freeScene(&scene_);
    mujoco_.offFBO = mujocos_framebuffer_;
    mjr_freeContext(&mujoco_);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  cv::Mat Render(const CameraView& view, const Lamps& given) {
    Check(view);
    if (given.p_WLamp.size() > kMaxLamps)
      throw std::invalid_argument("more lamps than a renderer can light");
    DrawLit(view, Merged(given));
    return Develop(pixels_, ToneTable(given.p_WLamp.empty() ? 0.0 : given.brightness));
  }

  cv::Mat RenderDepth(const CameraView& view) {
    Check(view);
    DrawDepth(view);
    cv::Mat depth(pixels_.size(), CV_32F);
    for (int row = 0; row < depth.rows; ++row) {
      const auto* from = pixels_.ptr<cv::Vec4b>(depth.rows - 1 - row);
      auto* to = depth.ptr<float>(row);
      for (int col = 0; col < depth.cols; ++col) {
        const cv::Vec4b& p = from[col];
        const double share = p[2] + p[1] / 256.0 + p[0] / 65536.0;
        to[col] = static_cast<float>(share / 255.0 * 2.0 * kReach_m);
      }
    }
    return depth;
  }

 private:
  /// Into `pixels_`, as `DrawDepth`. Other renderers wait meanwhile.
  void DrawLit(const CameraView& view, const Lamps& lamps) {
    ChoosePieces(view);
    const OffscreenContext::Current current(context_);
    const std::span drawn(scene_.geoms, static_cast<std::size_t>(scene_.ngeom));
    const bool film =
        std::ranges::any_of(drawn, [](const mjvGeom& geom) { return geom.emission > 0.0f; });
    const GLuint program = film ? LampProgram(film_programs_, lamps, kVertexShader, FilmShader())
                                : LampProgram(lamp_programs_, lamps, kVertexShader, kLampShader);
    gl_->UseProgram(program);
    SetLamps(view, lamps, program);
    Draw(view);
    if (const auto sheets = VisibleWater(view); !sheets.empty()) DrawWater(view, lamps, sheets);
    ReadBack(view);
  }

  void DrawDepth(const CameraView& view) {
    ChoosePieces(view);
    const OffscreenContext::Current current(context_);
    gl_->UseProgram(depth_program_);
    Draw(view);
    for (const WaterSheet* sheet : VisibleWater(view)) DrawSheet(view, *sheet);
    ReadBack(view);
  }

  void Check(const CameraView& view) const {
    if (view.width_px < 1 || view.height_px < 1 || view.width_px > options_.max_width_px ||
        view.height_px > options_.max_height_px || !(view.focal_px > 0.0)) {
      throw std::invalid_argument(
          "a camera view must have a focal length, and a size from 1 pixel to the renderer's");
    }
  }

  /// The nearest of a texture's levels alone: a mix of two, as MuJoCo sets, costs a seventh more
  /// time for the whole frame, and nobody sees it on walls as rough as these.
  void SampleOneLevel() const {
    for (int i = 0; i < mujoco_.ntexture; ++i) {
      gl_->BindTexture(GL_TEXTURE_2D, mujoco_.texture[i]);
      gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
      // A little sharper than levels are meant to be: the camera's blur comes later.
      gl_->TexParameterf(GL_TEXTURE_2D, GL_TEXTURE_LOD_BIAS, -0.4F);
    }
  }

  using LampPrograms = std::array<GLuint, kMaxLamps + 1>;

  /// A program for so many lamps.
  [[nodiscard]] GLuint Program(std::size_t lamps, const std::string& vertex_source,
                               const std::string& fragment_source) const {
    const std::string defined =
        fmt::format("#define LAMPS {}\n#define REACH {:.3f}\n", lamps, kReach_m);
    return LinkProgram(*gl_, defined + vertex_source, defined + fragment_source);
  }

  static std::string FilmShader() { return std::string("#define FILM\n") + kLampShader; }

  /// None is drawn as one that is switched off.
  GLuint LampProgram(LampPrograms& programs, const Lamps& lamps, const std::string& vertex_source,
                     const std::string& fragment_source) const {
    const std::size_t count = std::max<std::size_t>(lamps.p_WLamp.size(), 1);
    GLuint& program = programs[count];
    if (program == 0) program = Program(count, vertex_source, fragment_source);
    return program;
  }

  void SetLamps(const CameraView& view, const Lamps& lamps, GLuint program) const {
    // Camera frame C to OpenGL's eye frame E: y and z are turned round.
    Eigen::Matrix3d R_EW = view.X_WC.linear().transpose();
    R_EW.row(1) *= -1.0;
    R_EW.row(2) *= -1.0;
    std::array<Eigen::Vector3f, kMaxLamps> p_ELamp{Eigen::Vector3f(0.0f, 0.0f, 1.0f)};
    for (std::size_t i = 0; i < lamps.p_WLamp.size(); ++i) {
      p_ELamp[i] = (R_EW * (lamps.p_WLamp[i] - view.X_WC.translation())).cast<float>();
    }
    const auto count = std::max(static_cast<GLint>(lamps.p_WLamp.size()), 1);
    const Eigen::Vector3f direction_E = (R_EW * lamps.direction_W.normalized()).cast<float>();
    const double radiance = lamps.p_WLamp.empty() ? 0.0 : kExposure * lamps.brightness / count;
    const auto at = [&](const char* name) { return gl_->GetUniformLocation(program, name); };
    gl_->Uniform1i(at("pattern"), 0);
    gl_->Uniform3fv(at("p_ELamp"), count, p_ELamp[0].data());
    gl_->Uniform3fv(at("direction_E"), 1, direction_E.data());
    gl_->Uniform1f(at("radiance"), static_cast<float>(radiance));
  }

  [[nodiscard]] std::vector<const WaterSheet*> VisibleWater(const CameraView& view) const {
    const Pyramid pyramid(view);
    std::vector<const WaterSheet*> visible;
    for (const WaterSheet& sheet : scenery_->water()) {
      if (pyramid.Meets(sheet.p_WCentre, sheet.radius_m)) visible.push_back(&sheet);
    }
    return visible;
  }

  /// With the bound program, into MuJoCo's frame and before its depth buffer. MuJoCo leaves its
  /// camera in OpenGL's matrices.
  void DrawSheet(const CameraView& view, const WaterSheet& sheet) const {
    const Eigen::Vector3f p_CO = (sheet.p_WO - view.X_WC.translation()).cast<float>();
    gl_->Begin(GL_TRIANGLE_STRIP);
    for (const WaterSheet::Vertex& vertex : sheet.vertices) {
      gl_->Normal3fv(vertex.normal.data());
      gl_->MultiTexCoord3fv(GL_TEXTURE0, vertex.wall_axis.data());
      gl_->MultiTexCoord3fv(GL_TEXTURE1, vertex.p_VAxis.data());
      gl_->MultiTexCoord2fv(GL_TEXTURE2, vertex.along_left_m.data());
      const Eigen::Vector3f p = p_CO + vertex.p_OV;
      gl_->Vertex3fv(p.data());
    }
    gl_->End();
  }

  void DrawWater(const CameraView& view, const Lamps& lamps,
                 const std::vector<const WaterSheet*>& sheets) {
    CopyFrame(view);
    const GLuint program = LampProgram(water_programs_, lamps, kWaterVertexShader, kWaterShader);
    gl_->UseProgram(program);
    SetLamps(view, lamps, program);
    const auto at = [&](const char* name) { return gl_->GetUniformLocation(program, name); };
    gl_->Uniform1i(at("frame"), 0);
    gl_->Uniform2f(at("frame_share"),
                   static_cast<float>(view.width_px) / static_cast<float>(options_.max_width_px),
                   static_cast<float>(view.height_px) / static_cast<float>(options_.max_height_px));
    for (const WaterSheet* sheet : sheets) {
      const Eigen::Vector3f bed =
          Vector3d(sheet->wall_radius_m, sheet->bed_radius_m, sheet->depth_m).cast<float>();
      gl_->Uniform3fv(at("bed"), 1, bed.data());
      DrawSheet(view, *sheet);
    }
  }

  /// The frame so far, as a texture.
  void CopyFrame(const CameraView& view) {
    gl_->ActiveTexture(GL_TEXTURE0);
    if (frame_ == 0) {
      gl_->GenTextures(1, &frame_);
      gl_->BindTexture(GL_TEXTURE_2D, frame_);
      for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl_->TexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
      for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        gl_->TexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
      gl_->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, options_.max_width_px, options_.max_height_px, 0,
                      GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    }
    gl_->BindTexture(GL_TEXTURE_2D, frame_);
    gl_->CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, view.width_px, view.height_px);
  }

  /// Draws the chosen pieces with the bound program.
  void Draw(const CameraView& view) {
    SetCamera(view);
    const mjrRect viewport{0, 0, view.width_px, view.height_px};
    GLuint& framebuffer = framebuffers_[{view.width_px, view.height_px}];
    if (framebuffer == 0) framebuffer = NewFramebuffer(*gl_, view.width_px, view.height_px);
    mujoco_.offFBO = framebuffer;
    mjr_setBuffer(mjFB_OFFSCREEN, &mujoco_);
    mjr_render(viewport, &scene_, &mujoco_);
  }

  void ReadBack(const CameraView& view) {
    pixels_.create(view.height_px, view.width_px, CV_8UC4);
    gl_->ReadPixels(0, 0, view.width_px, view.height_px, GL_BGRA, GL_UNSIGNED_BYTE, pixels_.data);
  }

  /// The camera stands at OpenGL's origin and the scene is moved to it: single precision then
  /// suffices anywhere.
  void SetCamera(const CameraView& view) {
    mjvGLCamera camera{};
    const Eigen::Matrix3f R_WC = view.X_WC.linear().cast<float>();
    Eigen::Map<Eigen::Vector3f>(camera.forward) = R_WC.col(2);
    Eigen::Map<Eigen::Vector3f>(camera.up) = -R_WC.col(1);
    const double scale = kNear_m / view.focal_px;
    camera.frustum_center =
        static_cast<float>(scale * (0.5 * (view.width_px - 1) - view.center_x_px));
    camera.frustum_top = static_cast<float>(scale * (view.center_y_px + 0.5));
    camera.frustum_bottom = static_cast<float>(-scale * (view.height_px - 0.5 - view.center_y_px));
    camera.frustum_near = static_cast<float>(kNear_m);
    camera.frustum_far = static_cast<float>(2.0 * kReach_m);
    scene_.camera[0] = scene_.camera[1] = camera;
  }

  /// The nearest first: what they hide is then not shaded.
  void ChoosePieces(const CameraView& view) {
    const Pyramid pyramid(view);
    const Vector3d& p_WC = view.X_WC.translation();
    chosen_.clear();
    for (const Scenery::Piece& piece : scenery_->pieces()) {
      if (pyramid.Meets(piece.p_WCentre, piece.radius_m))
        chosen_.emplace_back((piece.p_WCentre - p_WC).squaredNorm(), &piece);
    }
    std::ranges::stable_sort(chosen_, {}, &std::pair<double, const Scenery::Piece*>::first);
    scene_.ngeom = 0;
    for (const auto& [distance2, piece] : chosen_) {
      mjvGeom& geom = scene_.geoms[scene_.ngeom++];
      geom = piece->geom;
      Eigen::Map<Eigen::Vector3f>(geom.pos) = (piece->p_WG - p_WC).cast<float>();
    }
  }

  /// Walls 0.3 to 0.6 m ahead of the nominal lamps come out mid-grey.
  static constexpr double kExposure = 0.37;

  std::shared_ptr<const Scenery> scenery_;
  RendererOptions options_;
  OffscreenContext context_;
  std::optional<Gl> gl_;
  mjrContext mujoco_{};
  mjvScene scene_{};
  LampPrograms lamp_programs_{}, film_programs_{}, water_programs_{};  ///< 0 if not yet needed
  std::map<std::pair<int, int>, GLuint> framebuffers_;                 ///< by width and height
  GLuint mujocos_framebuffer_{};
  GLuint frame_{};  ///< texture, 0 if not yet needed
  GLuint depth_program_{};
  cv::Mat pixels_;  ///< of the last picture; BGRA, the lowest row first
  std::vector<std::pair<double, const Scenery::Piece*>> chosen_;
};

Renderer::Renderer(std::shared_ptr<const Scenery> scenery, const RendererOptions& options)
    : impl_(std::make_unique<Impl>(std::move(scenery), options)) {}

Renderer::~Renderer() = default;

cv::Mat Renderer::Render(const CameraView& view, const Lamps& lamps) {
  return impl_->Render(view, lamps);
}

cv::Mat Renderer::RenderDepth(const CameraView& view) { return impl_->RenderDepth(view); }

double Response(double radiance) {
  return kBlack + (1.0 - kBlack) * std::sqrt(1.0 - std::exp(-radiance));
}

}  // namespace kantaro::sim
