#pragma once

#include <stdexcept>

namespace kantaro::sim {

/// What MuJoCo reports as an error or a warning. Objects that were in use are not to be used again.
class MujocoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Makes MuJoCo's errors and warnings throw MujocoError; by default errors end the process and
/// warnings go to a log file in the working directory. MuJoCo's handlers are global, so this is the
/// one place that sets them. Cheap and safe to call from any thread, any number of times.
void ThrowOnMujocoErrors();

}  // namespace kantaro::sim
