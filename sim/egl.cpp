#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <vector>

#include "sim/offscreen_context.hpp"
#include "sim/open_gl.hpp"
#include "sim/shared_library.hpp"

namespace kantaro::sim {
namespace {

struct Functions {
  decltype(eglGetProcAddress)* find{};
  decltype(eglInitialize)* initialize{};
  decltype(eglBindAPI)* bind_api{};
  decltype(eglChooseConfig)* choose_config{};
  decltype(eglCreateContext)* create_context{};
  decltype(eglDestroyContext)* destroy_context{};
  decltype(eglCreatePbufferSurface)* create_pbuffer{};
  decltype(eglDestroySurface)* destroy_surface{};
  decltype(eglMakeCurrent)* make_current{};
  decltype(eglGetError)* get_error{};

  explicit Functions(const SharedLibrary& library) {
    library.Load(find, "eglGetProcAddress");
    library.Load(initialize, "eglInitialize");
    library.Load(bind_api, "eglBindAPI");
    library.Load(choose_config, "eglChooseConfig");
    library.Load(create_context, "eglCreateContext");
    library.Load(destroy_context, "eglDestroyContext");
    library.Load(create_pbuffer, "eglCreatePbufferSurface");
    library.Load(destroy_surface, "eglDestroySurface");
    library.Load(make_current, "eglMakeCurrent");
    library.Load(get_error, "eglGetError");
  }
};

[[noreturn]] void Fail(const Functions& egl, const char* problem) {
  throw RenderingUnavailable(
      fmt::format("cameras cannot be rendered: EGL {} (error {:#x})", problem, egl.get_error()));
}

/// GPUs first, software last.
std::vector<EGLDeviceEXT> Devices(const Functions& egl) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.find("eglQueryDevicesEXT"));
  std::vector<EGLDeviceEXT> devices(8);
  EGLint count = 0;
  if (query == nullptr || !query(static_cast<EGLint>(devices.size()), devices.data(), &count))
    count = 0;
  devices.resize(static_cast<std::size_t>(count));
  return devices;
}

/// A GPU where there is one, else Mesa's software renderer. @throws RenderingUnavailable
EGLDisplay OpenDisplay(const Functions& egl) {
  const auto get_platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl.find("eglGetPlatformDisplayEXT"));
  const auto starts = [&](EGLenum platform, void* device) {
    const EGLDisplay display = get_platform_display(platform, device, nullptr);
    const bool started = display != EGL_NO_DISPLAY && egl.initialize(display, nullptr, nullptr);
    return started ? display : EGL_NO_DISPLAY;
  };
  if (get_platform_display != nullptr) {
    for (const EGLDeviceEXT device : Devices(egl)) {
      if (const EGLDisplay display = starts(EGL_PLATFORM_DEVICE_EXT, device)) return display;
    }
    if (const EGLDisplay display = starts(EGL_PLATFORM_SURFACELESS_MESA, nullptr)) return display;
  }
  Fail(egl, "has no driver that starts without a display");
}

EGLConfig ChooseConfig(const Functions& egl, EGLDisplay display) {
  constexpr std::array<EGLint, 17> kWanted{EGL_SURFACE_TYPE,
                                           EGL_PBUFFER_BIT,  //
                                           EGL_RED_SIZE,
                                           8,  //
                                           EGL_GREEN_SIZE,
                                           8,  //
                                           EGL_BLUE_SIZE,
                                           8,  //
                                           EGL_ALPHA_SIZE,
                                           8,  //
                                           EGL_DEPTH_SIZE,
                                           24,  //
                                           EGL_STENCIL_SIZE,
                                           8,  //
                                           EGL_RENDERABLE_TYPE,
                                           EGL_OPENGL_BIT,
                                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!egl.choose_config(display, kWanted.data(), &config, 1, &count) || count == 0)
    Fail(egl, "draws no OpenGL into memory");
  return config;
}

class EglContext final : public OpenGl::Context {
 public:
  EglContext(const Functions& egl, EGLDisplay display, EGLConfig config)
      : egl_(egl), display_(display) {
    // Pictures are drawn in a framebuffer object; this surface is only there to be current.
    constexpr std::array<EGLint, 5> kSize{EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
    // The API is bound thread by thread.
    if (!egl_.bind_api(EGL_OPENGL_API)) Fail(egl_, "has no OpenGL");
    surface_ = egl_.create_pbuffer(display_, config, kSize.data());
    if (surface_ == EGL_NO_SURFACE) Fail(egl_, "gives no surface");
    context_ = egl_.create_context(display_, config, EGL_NO_CONTEXT, nullptr);
    if (context_ == EGL_NO_CONTEXT) {
      egl_.destroy_surface(display_, surface_);
      Fail(egl_, "gives no OpenGL context");
    }
  }
  ~EglContext() override {
    egl_.destroy_context(display_, context_);
    egl_.destroy_surface(display_, surface_);
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void MakeCurrent() override {
    if (!egl_.bind_api(EGL_OPENGL_API) ||
        !egl_.make_current(display_, surface_, surface_, context_))
      Fail(egl_, "does not start its OpenGL context");
  }

 private:
  const Functions& egl_;
  EGLDisplay display_;
  EGLSurface surface_{EGL_NO_SURFACE};
  EGLContext context_{EGL_NO_CONTEXT};
};

class Egl final : public OpenGl {
 public:
  Egl()
      : functions_(SharedLibrary("libEGL.so.1", "EGL")),
        display_(OpenDisplay(functions_)),
        config_(ChooseConfig(functions_, display_)) {}

  std::unique_ptr<Context> NewContext() override {
    return std::make_unique<EglContext>(functions_, display_, config_);
  }
  void Release() override {
    functions_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  AnyFunction Find(const char* name) override { return functions_.find(name); }

 private:
  Functions functions_;
  EGLDisplay display_;
  EGLConfig config_;
};

}  // namespace

std::unique_ptr<OpenGl> OpenEgl() { return std::make_unique<Egl>(); }

}  // namespace kantaro::sim
