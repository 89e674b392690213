#include "sim/mujoco_error.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

namespace kantaro::sim {
namespace {

TEST(ThrowOnMujocoErrors, TurnsAnErrorIntoAnException) {
  ThrowOnMujocoErrors();
  EXPECT_THROW(mju_error("it broke"), MujocoError);
}

TEST(ThrowOnMujocoErrors, TurnsAWarningIntoAnException) {
  ThrowOnMujocoErrors();
  EXPECT_THROW(mju_warning("it nearly broke"), MujocoError);
}

}  // namespace
}  // namespace kantaro::sim
