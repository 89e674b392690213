#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>

namespace kantaro::sim {

/// Cameras cannot be rendered on this machine. Nothing goes on without images.
class RenderingUnavailable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An OpenGL context in memory: OSMesa, which needs neither display nor GPU.
///
/// Entry points come from the context itself; the program links no other OpenGL, because MuJoCo
/// takes its own from whichever it finds first. A context may move between threads but is current
/// on at most one.
class OffscreenContext {
 public:
  /// @throws RenderingUnavailable if OSMesa does not start.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// Current on this thread for as long as it lives.
  class Current {
   public:
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
  using AnyFunction = void (*)();
  static AnyFunction Find(const char* name);

  struct Deleter {
    void operator()(void* context) const;
  };
  std::unique_ptr<void, Deleter> context_;
  /// OSMesa insists on a buffer of its own; pictures are drawn in a framebuffer object instead.
  alignas(16) std::byte unused_buffer_[16 * 16 * 4]{};
};

}  // namespace kantaro::sim
