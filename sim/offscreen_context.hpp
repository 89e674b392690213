#pragma once

#include <memory>
#include <mutex>
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
/// own from whichever it finds first, into globals.
///
/// A context may move between threads. One in the whole process is current at any time: before
/// Mesa 22.3's llvmpipe reads or writes a texture it walks through what every context is about to
/// draw, without a lock, and once in many hours it found freed memory there.
class OffscreenContext {
 public:
  /// @throws RenderingUnavailable if the library is absent or does not start.
  /// @throws InputError if KANTARO_GL names no library that is known, or LP_NATIVE_VECTOR_WIDTH a
  /// width that Mesa cannot draw with.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// Current on this thread for as long as it lives, after all others have gone. Two on one thread
  /// never end.
  class Current {
   public:
    /// @throws RenderingUnavailable
    explicit Current(OffscreenContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    std::lock_guard<std::mutex> alone_;
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
