#include "sim/mujoco_error.hpp"

#include <mujoco/mujoco.h>

#include <mutex>
#include <string>

namespace kantaro::sim {

void ThrowOnMujocoErrors() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = [](const char* text) { throw MujocoError(std::string("MuJoCo: ") + text); };
    mju_user_warning = [](const char* text) {
      throw MujocoError(std::string("MuJoCo warns: ") + text);
    };
  });
}

}  // namespace kantaro::sim
