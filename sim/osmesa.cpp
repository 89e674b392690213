#include <GL/osmesa.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include "sim/offscreen_context.hpp"
#include "sim/open_gl.hpp"
#include "sim/shared_library.hpp"

#if defined(__SANITIZE_ADDRESS__)
// OSMesa never frees the bookkeeping of a context's buffer, about 200 bytes.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so"; }
#endif

namespace kantaro::sim {
namespace {

struct Functions {
  decltype(OSMesaCreateContextExt)* create{};
  decltype(OSMesaDestroyContext)* destroy{};
  decltype(OSMesaMakeCurrent)* make_current{};
  decltype(OSMesaGetProcAddress)* find{};

  explicit Functions(const SharedLibrary& library) {
    library.Load(create, "OSMesaCreateContextExt");
    library.Load(destroy, "OSMesaDestroyContext");
    library.Load(make_current, "OSMesaMakeCurrent");
    library.Load(find, "OSMesaGetProcAddress");
  }
};

class OsmesaContext final : public OpenGl::Context {
 public:
  explicit OsmesaContext(const Functions& osmesa)
      : osmesa_(osmesa),
        context_(osmesa.create(OSMESA_RGBA, /*depthBits=*/24, /*stencilBits=*/8, /*accumBits=*/0,
                               nullptr)) {
    if (context_ == nullptr)
      throw RenderingUnavailable("cameras cannot be rendered: OSMesa gives no OpenGL context");
  }
  ~OsmesaContext() override { osmesa_.destroy(context_); }
  OsmesaContext(const OsmesaContext&) = delete;
  OsmesaContext& operator=(const OsmesaContext&) = delete;

  void MakeCurrent() override {
    if (!osmesa_.make_current(context_, unused_buffer_, GL_UNSIGNED_BYTE, 16, 16))
      throw RenderingUnavailable(
          "cameras cannot be rendered: OSMesa's OpenGL context does not start");
  }

 private:
  const Functions& osmesa_;
  OSMesaContext context_;
  /// OSMesa insists on a buffer of its own; pictures are drawn in a framebuffer object instead.
  alignas(16) std::byte unused_buffer_[16 * 16 * 4]{};
};

/// Never returns: exits with 0 if OSMesa starts, else with 1, or dies.
[[noreturn]] void TryInChild(const Functions& osmesa) {
  constexpr unsigned kPatience_s = 30;
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  alarm(kPatience_s);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  try {
    OsmesaContext(osmesa).MakeCurrent();
  } catch (const RenderingUnavailable&) {
    _exit(1);
  }
  _exit(0);
}

/// OSMesa does not say that it finds no driver, or one that the processor cannot run: it crashes.
/// So it is started in a child first. @throws RenderingUnavailable
void DemandThatItStarts(const Functions& osmesa) {
  const pid_t child = fork();
  if (child < 0) return;  // nothing to be learned
  if (child == 0) TryInChild(osmesa);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  const char* driver = std::getenv("GALLIUM_DRIVER");
  throw RenderingUnavailable(fmt::format(
      "cameras cannot be rendered: OSMesa does not start ({}{})",
      WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "it gives no OpenGL context",
      driver != nullptr ? fmt::format("; the environment asks for GALLIUM_DRIVER={}", driver)
                        : ""));
}

class Osmesa final : public OpenGl {
 public:
  Osmesa() : functions_(SharedLibrary("libOSMesa.so.8", "OSMesa")) {
    DemandThatItStarts(functions_);
  }

  std::unique_ptr<Context> NewContext() override {
    return std::make_unique<OsmesaContext>(functions_);
  }
  void Release() override { functions_.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }
  AnyFunction Find(const char* name) override { return functions_.find(name); }

 private:
  Functions functions_;
};

}  // namespace

std::unique_ptr<OpenGl> OpenOsmesa() { return std::make_unique<Osmesa>(); }

}  // namespace kantaro::sim
