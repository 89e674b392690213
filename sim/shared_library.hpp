#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include "sim/offscreen_context.hpp"

namespace kantaro::sim {

/// A library opened at run time, for good: what it leaves behind when a thread ends is its own
/// code.
class SharedLibrary {
 public:
  /// Global, so that MuJoCo finds its functions too.
  /// @param what  it is, for the error. @throws RenderingUnavailable if it cannot be opened.
  SharedLibrary(const char* file, const char* what)
      : what_(what), handle_(dlopen(file, RTLD_NOW | RTLD_GLOBAL)) {
    if (handle_ == nullptr)
      throw RenderingUnavailable(
          fmt::format("cameras cannot be rendered: {} cannot be opened ({})", what, dlerror()));
  }

  /// @throws RenderingUnavailable if the library lacks it.
  template <typename Function>
  void Load(Function*& function, const char* name) const {
    function = reinterpret_cast<Function*>(dlsym(handle_, name));
    if (function == nullptr)
      throw RenderingUnavailable(
          fmt::format("cameras cannot be rendered: {} lacks {}", what_, name));
  }

 private:
  const char* what_;
  void* handle_;
};

}  // namespace kantaro::sim
