#pragma once

#include <memory>

namespace kantaro::sim {

/// A library that draws into memory, opened at run time: only the one that was asked for may be in
/// the process, because MuJoCo draws with the first it finds.
class OpenGl {
 public:
  using AnyFunction = void (*)();

  /// What was drawn so far, and with what. May move between threads.
  class Context {
   public:
    virtual ~Context() = default;
    /// On this thread. @throws RenderingUnavailable
    virtual void MakeCurrent() = 0;
  };

  virtual ~OpenGl() = default;
  /// @throws RenderingUnavailable
  [[nodiscard]] virtual std::unique_ptr<Context> NewContext() = 0;
  /// No context is current on this thread afterwards.
  virtual void Release() = 0;
  /// Null if there is no such function.
  [[nodiscard]] virtual AnyFunction Find(const char* name) = 0;
};

/// Mesa's software renderer. @throws RenderingUnavailable if it is absent or does not start.
[[nodiscard]] std::unique_ptr<OpenGl> OpenOsmesa();

/// EGL without a display: a GPU where a driver gives one, else Mesa's software renderer.
/// @throws RenderingUnavailable if it is absent or does not start.
[[nodiscard]] std::unique_ptr<OpenGl> OpenEgl();

}  // namespace kantaro::sim
