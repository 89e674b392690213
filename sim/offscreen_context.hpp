#pragma once

#include <memory>
#include <stdexcept>

#include "sim/open_gl.hpp"

namespace kantaro::sim {

/// Cameras cannot be rendered on this machine. Nothing goes on without images.
class RenderingUnavailable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An OpenGL context in memory: OSMesa, which needs neither display nor GPU, or EGL where the
/// environment variable KANTARO_GL is `egl`. All contexts of a process come from one of the two.
///
/// Entry points come from the context itself; the program links no OpenGL, because MuJoCo takes its
/// own from whichever it finds first. A context may move between threads but is current on at most
/// one.
class OffscreenContext {
 public:
  /// @throws RenderingUnavailable if the library is absent or does not start.
  /// @throws InputError if KANTARO_GL names no library that is known, or LP_NATIVE_VECTOR_WIDTH a
  /// width that Mesa cannot draw with.
  OffscreenContext();

  /// Current on this thread for as long as it lives.
  class Current {
   public:
    /// @throws RenderingUnavailable
    explicit Current(OffscreenContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
  };

  /// An OpenGL function by name. @throws RenderingUnavailable if this OpenGL lacks it.
  template <typename Function>
  [[nodiscard]] static Function Entry(const char* name) {
    return reinterpret_cast<Function>(Find(name));
  }

 private:
  static OpenGl::AnyFunction Find(const char* name);

  std::unique_ptr<OpenGl::Context> context_;
};

}  // namespace kantaro::sim
