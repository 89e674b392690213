#pragma once

#include <GL/gl.h>
#include <GL/glext.h>

#include <array>
#include <string>

#include "sim/offscreen_context.hpp"
#include "sim/shaders.hpp"

namespace kantaro::sim {

/// The OpenGL calls that a renderer makes itself, of the context that is current when this is made.
struct Gl {
  template <typename Function>
  static Function Entry(const char* name) {
    return OffscreenContext::Entry<Function>(name);
  }
  PFNGLCREATESHADERPROC CreateShader = Entry<PFNGLCREATESHADERPROC>("glCreateShader");
  PFNGLSHADERSOURCEPROC ShaderSource = Entry<PFNGLSHADERSOURCEPROC>("glShaderSource");
  PFNGLCOMPILESHADERPROC CompileShader = Entry<PFNGLCOMPILESHADERPROC>("glCompileShader");
  PFNGLGETSHADERIVPROC GetShaderiv = Entry<PFNGLGETSHADERIVPROC>("glGetShaderiv");
  PFNGLGETSHADERINFOLOGPROC GetShaderInfoLog =
      Entry<PFNGLGETSHADERINFOLOGPROC>("glGetShaderInfoLog");
  PFNGLCREATEPROGRAMPROC CreateProgram = Entry<PFNGLCREATEPROGRAMPROC>("glCreateProgram");
  PFNGLATTACHSHADERPROC AttachShader = Entry<PFNGLATTACHSHADERPROC>("glAttachShader");
  PFNGLLINKPROGRAMPROC LinkProgram = Entry<PFNGLLINKPROGRAMPROC>("glLinkProgram");
  PFNGLGETPROGRAMIVPROC GetProgramiv = Entry<PFNGLGETPROGRAMIVPROC>("glGetProgramiv");
  PFNGLUSEPROGRAMPROC UseProgram = Entry<PFNGLUSEPROGRAMPROC>("glUseProgram");
  PFNGLGETUNIFORMLOCATIONPROC GetUniformLocation =
      Entry<PFNGLGETUNIFORMLOCATIONPROC>("glGetUniformLocation");
  PFNGLUNIFORM1IPROC Uniform1i = Entry<PFNGLUNIFORM1IPROC>("glUniform1i");
  PFNGLUNIFORM1FPROC Uniform1f = Entry<PFNGLUNIFORM1FPROC>("glUniform1f");
  PFNGLUNIFORM3FVPROC Uniform3fv = Entry<PFNGLUNIFORM3FVPROC>("glUniform3fv");
  PFNGLUNIFORM2FPROC Uniform2f = Entry<PFNGLUNIFORM2FPROC>("glUniform2f");
  void (*MultiTexCoord2fv)(GLenum, const GLfloat*) =
      Entry<void (*)(GLenum, const GLfloat*)>("glMultiTexCoord2fv");
  void (*MultiTexCoord3fv)(GLenum, const GLfloat*) =
      Entry<void (*)(GLenum, const GLfloat*)>("glMultiTexCoord3fv");
  PFNGLACTIVETEXTUREPROC ActiveTexture = Entry<PFNGLACTIVETEXTUREPROC>("glActiveTexture");
  void (*Begin)(GLenum) = Entry<void (*)(GLenum)>("glBegin");
  void (*End)() = Entry<void (*)()>("glEnd");
  void (*Vertex3fv)(const GLfloat*) = Entry<void (*)(const GLfloat*)>("glVertex3fv");
  void (*Normal3fv)(const GLfloat*) = Entry<void (*)(const GLfloat*)>("glNormal3fv");
  void (*GenTextures)(GLsizei, GLuint*) = Entry<void (*)(GLsizei, GLuint*)>("glGenTextures");
  void (*BindTexture)(GLenum, GLuint) = Entry<void (*)(GLenum, GLuint)>("glBindTexture");
  void (*TexParameteri)(GLenum, GLenum,
                        GLint) = Entry<void (*)(GLenum, GLenum, GLint)>("glTexParameteri");
  void (*TexParameterf)(GLenum, GLenum,
                        GLfloat) = Entry<void (*)(GLenum, GLenum, GLfloat)>("glTexParameterf");
  void (*TexImage2D)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*) =
      Entry<void (*)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*)>(
          "glTexImage2D");
  void (*CopyTexSubImage2D)(GLenum, GLint, GLint, GLint, GLint, GLint, GLsizei, GLsizei) =
      Entry<void (*)(GLenum, GLint, GLint, GLint, GLint, GLint, GLsizei, GLsizei)>(
          "glCopyTexSubImage2D");
  PFNGLGENFRAMEBUFFERSPROC GenFramebuffers = Entry<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers");
  PFNGLBINDFRAMEBUFFERPROC BindFramebuffer = Entry<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer");
  PFNGLGENRENDERBUFFERSPROC GenRenderbuffers =
      Entry<PFNGLGENRENDERBUFFERSPROC>("glGenRenderbuffers");
  PFNGLBINDRENDERBUFFERPROC BindRenderbuffer =
      Entry<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer");
  PFNGLRENDERBUFFERSTORAGEPROC RenderbufferStorage =
      Entry<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage");
  PFNGLFRAMEBUFFERRENDERBUFFERPROC FramebufferRenderbuffer =
      Entry<PFNGLFRAMEBUFFERRENDERBUFFERPROC>("glFramebufferRenderbuffer");
  PFNGLCHECKFRAMEBUFFERSTATUSPROC CheckFramebufferStatus =
      Entry<PFNGLCHECKFRAMEBUFFERSTATUSPROC>("glCheckFramebufferStatus");
  using ReadPixelsFunction = void (*)(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void*);
  ReadPixelsFunction ReadPixels = Entry<ReadPixelsFunction>("glReadPixels");
};

inline GLuint CompileShader(const Gl& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == 0) {
    std::array<char, 2000> log{};
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw RenderingUnavailable(
        std::string("cameras cannot be rendered: OpenGL refuses a shader: ") + log.data());
  }
  return shader;
}

/// @throws RenderingUnavailable if OpenGL refuses a shader.
inline GLuint LinkProgram(const Gl& gl, const std::string& vertex_source,
                          const std::string& fragment_source) {
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, CompileShader(gl, GL_VERTEX_SHADER, kVersion + vertex_source));
  gl.AttachShader(program, CompileShader(gl, GL_FRAGMENT_SHADER, kVersion + fragment_source));
  gl.LinkProgram(program);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == 0)
    throw RenderingUnavailable("cameras cannot be rendered: OpenGL does not link a shader");
  return program;
}

/// Something to draw into, of this size.
inline GLuint NewFramebuffer(const Gl& gl, int width_px, int height_px) {
  GLuint framebuffer = 0;
  gl.GenFramebuffers(1, &framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  std::array<GLuint, 2> buffers{};
  gl.GenRenderbuffers(2, buffers.data());
  const auto attach = [&](GLuint buffer, GLenum format, GLenum attachment) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, width_px, height_px);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  attach(buffers[0], GL_RGBA8, GL_COLOR_ATTACHMENT0);
  attach(buffers[1], GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw RenderingUnavailable("cameras cannot be rendered: OpenGL gives no framebuffer");
  return framebuffer;
}

}  // namespace kantaro::sim
