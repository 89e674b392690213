#include "sim/offscreen_context.hpp"

#include <GL/gl.h>
#include <gtest/gtest.h>

namespace kantaro::sim {
namespace {

TEST(OffscreenContext, DrawsWithSoftware) {
  OffscreenContext context;
  const OffscreenContext::Current current(context);
  const auto get_string = OffscreenContext::Entry<const GLubyte* (*)(GLenum)>("glGetString");
  ASSERT_NE(get_string(GL_RENDERER), nullptr);
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
