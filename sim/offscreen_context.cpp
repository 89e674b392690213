#include "sim/offscreen_context.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <mutex>
#include <string>

#include "base/input_error.hpp"

namespace kantaro::sim {
namespace {

std::unique_ptr<OpenGl> OpenChosen() {
  const char* given = std::getenv("KANTARO_GL");
  const std::string name = given != nullptr ? given : "";
  if (name.empty() || name == "osmesa") return OpenOsmesa();
  if (name == "egl") return OpenEgl();
  throw InputError("KANTARO_GL", {}, "", fmt::format("\"{}\" is none of osmesa, egl", name));
}

/// @throws InputError: Mesa crashes or hangs with any other width, in the midst of drawing.
void CheckVectorWidth() {
  const char* given = std::getenv("LP_NATIVE_VECTOR_WIDTH");
  const std::string width = given != nullptr ? given : "";
  if (width.empty() || width == "128" || width == "256") return;
  throw InputError("LP_NATIVE_VECTOR_WIDTH", {}, "",
                   fmt::format("Mesa cannot draw with \"{}\"; 128 and 256 are right", width));
}

/// One for the whole process, as MuJoCo keeps one set of entry points. Never closed: worker threads
/// of the library outlive main().
OpenGl& Chosen() {
  static OpenGl* const gl = [] {
    // Mesa keeps compiled shaders on disk and does not tell those for narrow vectors from those for
    // wide ones: a program must not depend on what another left there.
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    CheckVectorWidth();
    return OpenChosen().release();
  }();
  return *gl;
}

/// Who holds it may draw, and make and end contexts.
std::mutex& DrawingMutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

OffscreenContext::OffscreenContext() {
  {
    const std::lock_guard alone(DrawingMutex());
    context_ = Chosen().NewContext();
  }
  const Current current(*this);
}

OffscreenContext::~OffscreenContext() {
  const std::lock_guard alone(DrawingMutex());
  context_.reset();
}

OffscreenContext::Current::Current(OffscreenContext& context) : alone_(DrawingMutex()) {
  context.context_->MakeCurrent();
}

OffscreenContext::Current::~Current() { Chosen().Release(); }

OpenGl::AnyFunction OffscreenContext::Find(const char* name) {
  const OpenGl::AnyFunction function = Chosen().Find(name);
  if (function == nullptr) {
    throw RenderingUnavailable(fmt::format("cameras cannot be rendered: OpenGL lacks {}", name));
  }
  return function;
}

}  // namespace kantaro::sim
