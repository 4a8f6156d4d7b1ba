// OpenGL ES 3.0, loaded while the program runs: without it everything but pictures works.
#pragma once

#ifndef EGL_NO_X11
#define EGL_NO_X11  // no window system is wanted, nor its headers
#endif
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

namespace lockstep {

/// The functions of OpenGL ES that pictures are drawn with, each under its name without "gl".
struct Gl {
#define GL_FUNCTION(name) decltype(&::gl##name) name = nullptr;
#include "host/render/gl_functions.def"
#undef GL_FUNCTION
};

}  // namespace lockstep
