// A context of OpenGL ES 3.0 without a window or a display: a GPU by EGL's devices where there is one, else Mesa's
// software.
#pragma once

#include <string>

#include "host/render/gl.hpp"

namespace lockstep {

class EglContext {
 public:
  /// Makes the context current in this thread. Throws Error (device) where there is no EGL, or none that can do it.
  EglContext();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  const Gl& gl() const { return gl_; }
  /// What draws, as the driver calls itself.
  const std::string& renderer() const { return renderer_; }
  /// And which OpenGL ES it speaks, by which release of the driver.
  const std::string& version() const { return version_; }

 private:
  struct Egl;  // the functions of EGL itself

  bool open(const Egl& egl, EGLDisplay display);
  void load_functions(const Egl& egl);

  void *egl_library_ = nullptr, *gles_library_ = nullptr;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
  decltype(&::eglTerminate) terminate_ = nullptr;
  decltype(&::eglMakeCurrent) make_current_ = nullptr;
  Gl gl_;
  std::string renderer_, version_;
};

}  // namespace lockstep
