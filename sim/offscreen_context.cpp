#include "sim/offscreen_context.hpp"

#include <GL/osmesa.h>

#include <cstdlib>
#include <mutex>
#include <string>

namespace kantaro::sim {
namespace {

/// llvmpipe reads its settings once, from the environment, when its first context starts.
/// Rasterising in the calling thread lets two renderers draw on two cores at once; what the user
/// set wins.
void ChooseThreadsOnce() {
  static std::once_flag once;
  std::call_once(once, [] { setenv("LP_NUM_THREADS", "0", /*overwrite=*/0); });
}

OSMesaContext CreateContext() {
  ChooseThreadsOnce();
  return OSMesaCreateContextExt(OSMESA_RGBA, /*depthBits=*/24, /*stencilBits=*/8, /*accumBits=*/0,
                                nullptr);
}

}  // namespace

OffscreenContext::OffscreenContext() : context_(CreateContext()) {
  if (!context_)
    throw RenderingUnavailable("cameras cannot be rendered: OSMesa gave no OpenGL context");
  const Current current(*this);
}

OffscreenContext::~OffscreenContext() = default;

void OffscreenContext::Deleter::operator()(void* context) const {
  OSMesaDestroyContext(static_cast<OSMesaContext>(context));
}

OffscreenContext::Current::Current(OffscreenContext& context) {
  if (!OSMesaMakeCurrent(static_cast<OSMesaContext>(context.context_.get()), context.unused_buffer_,
                         GL_UNSIGNED_BYTE, 16, 16)) {
    throw RenderingUnavailable(
        "cameras cannot be rendered: OSMesa's OpenGL context does not start");
  }
}

OffscreenContext::Current::~Current() {
  OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
}

OffscreenContext::AnyFunction OffscreenContext::Find(const char* name) {
  const AnyFunction function = OSMesaGetProcAddress(name);
  if (function == nullptr) {
    throw RenderingUnavailable(std::string("cameras cannot be rendered: OpenGL lacks ") + name);
  }
  return function;
}

}  // namespace kantaro::sim
