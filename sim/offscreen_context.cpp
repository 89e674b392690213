#include "sim/offscreen_context.hpp"

#include <GL/osmesa.h>

#include <string>

#if defined(__SANITIZE_ADDRESS__)
// OSMesa never frees the bookkeeping of a context's buffer, about 200 bytes.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so"; }
#endif

namespace kantaro::sim {
namespace {

OSMesaContext CreateContext() {
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
