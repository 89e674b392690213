#include "sim/offscreen_context.hpp"

#include <GL/gl.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

namespace kantaro::sim {
namespace {

TEST(OffscreenContext, DrawsWithSoftware) {
  OffscreenContext context;
  const OffscreenContext::Current current(context);
  const auto get_string = OffscreenContext::Entry<const GLubyte* (*)(GLenum)>("glGetString");
  ASSERT_NE(get_string(GL_RENDERER), nullptr);
}

// llvmpipe reads what other contexts are drawing without a lock.
TEST(OffscreenContext, IsCurrentOnOneThreadAlone) {
  std::atomic<int> current_now = 0, most = 0;
  {
    std::array<std::jthread, 2> threads;
    for (std::jthread& thread : threads) {
      thread = std::jthread([&] {
        OffscreenContext context;
        for (int i = 0; i < 100; ++i) {
          const OffscreenContext::Current current(context);
          const int now = ++current_now;
          if (now > most) most = now;
          std::this_thread::yield();
          --current_now;
        }
      });
    }
  }
  EXPECT_EQ(most, 1);
}

TEST(OffscreenContext, SaysWhatOpenGlLacks) {
  try {
    (void)OffscreenContext::Entry<void (*)()>("noSuchFunction");
    FAIL() << "found a function that does not exist";
  } catch (const RenderingUnavailable& error) {
    EXPECT_STREQ(error.what(), "cameras cannot be rendered: OpenGL lacks noSuchFunction");
  }
}

}  // namespace
}  // namespace kantaro::sim
